// How the servo side's options say what is wrong with them.
#pragma once

#include <cmath>
#include <string>

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {

/// The number as messages show it: "NaN" and "inf" too.
inline std::string shown_number(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return number_text(value);
}

inline void check_positive(FaultList& faults, const std::string& place, double value,
                           const std::string& unit) {
  if (!(std::isfinite(value) && value > 0.0))
    faults.add(place, shown_number(value), "a number above 0 (" + unit + ")");
}

inline void check_not_negative(FaultList& faults, const std::string& place, double value,
                               const std::string& unit) {
  if (!(std::isfinite(value) && value >= 0.0))
    faults.add(place, shown_number(value), "0 or a number above (" + unit + ")");
}

}  // namespace ballservo
