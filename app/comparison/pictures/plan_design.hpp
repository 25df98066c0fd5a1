// Conditions made from lists of numbers: grids, one at a time, at random.
#pragma once

#include <cstdint>
#include <vector>

#include "app/comparison/pictures/condition.hpp"

namespace ballservo {

inline constexpr double most_conditions = 10000;

/// The conditions that `design` (see read_comparison_plan) makes of `base`, named after what is varied
/// ("depth_m_0_5") or numbered ("grid_0001", "random_0001"). Faults are the node's.
std::vector<ComparisonCondition> designed_conditions(YamlNode design, const ComparisonCondition& base,
                                                     std::uint64_t seed);

}  // namespace ballservo
