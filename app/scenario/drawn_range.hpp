// A range of a scenario, `[low, high]`, from which a seed draws.
#pragma once

#include <string>

#include "calibration/base/options.hpp"
#include "calibration/base/random.hpp"

namespace ballservo {

struct DrawnRange {
  double low = 0, high = 0;
  double draw(RandomEngine& engine) const { return uniform(engine, low, high); }
};

/// Bounds in falling order are a fault.
inline void declare_range(OptionVisitor& v, const std::string& key, DrawnRange& range,
                          const NumberRange& allowed, const std::string& help,
                          const Fallback& fallback = {}) {
  std::vector<double> bounds{range.low, range.high};
  v.numbers(key, bounds, allowed, 2, help, fallback);
  v.require(bounds[0] <= bounds[1], key, "bounds in falling order", "[low, high]");
  range = {bounds[0], bounds[1]};
}

}  // namespace ballservo
