// A range of a scenario, `[low, high]`, from which a seed draws.
#pragma once

#include <string>

#include "calibration/base/random.hpp"
#include "calibration/base/strict_yaml.hpp"

namespace ballservo {

struct DrawnRange {
  double low = 0, high = 0;
  double draw(RandomEngine& engine) const { return uniform(engine, low, high); }
};

/// Bounds in falling order are a fault.
inline DrawnRange read_drawn_range(YamlNode& node, const std::string& key, const NumberRange& allowed,
                                   const DrawnRange& fallback) {
  const std::vector<double> values =
      node.numbers(key, allowed, 2, std::vector<double>{fallback.low, fallback.high});
  if (values[0] > values[1]) node.fault(key, "bounds in falling order", "[low, high]");
  return {values[0], values[1]};
}

}  // namespace ballservo
