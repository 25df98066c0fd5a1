// What is wrong with a number that lies out of its range.
#pragma once

#include <fmt/format.h>

#include <string>

#include "calibration/base/fault.hpp"

namespace ballservo {

/// A fault at `place` unless the value lies from `low` to `high`.
inline void check_range(FaultList& faults, const std::string& place, double value, double low, double high) {
  if (!(value >= low && value <= high))
    faults.add(place, fmt::format("{}", value), fmt::format("{} to {}", low, high));
}

}  // namespace ballservo
