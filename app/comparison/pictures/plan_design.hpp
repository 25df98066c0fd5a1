// Conditions made from lists of numbers: grids, one at a time, at random.
#pragma once

#include <cstdint>
#include <vector>

#include "app/comparison/pictures/condition.hpp"

namespace ballservo {

inline constexpr double most_conditions = 10000;

/// {type: one_at_a_time, vary: {depth_m: [0.5, 1, 2], ...}} changes one number of the defaults at a time,
/// {type: grid} makes all combinations, {type: random, conditions: N, vary: {depth_m: {uniform: [0.5, 3]},
/// noise.read: {log_uniform: [0.5, 10]}}} draws them.
struct PlanDesign {
  /// A number of the conditions, and its values; of a random design: the two ends.
  struct Varied {
    std::string key;
    std::vector<double> values;
    bool log = false;
  };
  std::string type;
  long long conditions = 0;  ///< of a random design
  std::vector<Varied> vary;
};

/// The numbers that `base` has are those that can be varied.
void declare(OptionVisitor& v, PlanDesign& design, const ComparisonCondition& base);

/// The conditions that a design makes of `base`, named after what is varied ("depth_m_0_5") or numbered
/// ("grid_0001", "random_0001"). Too many are a fault of its node.
std::vector<ComparisonCondition> designed_conditions(const PlanDesign& design, YamlNode node,
                                                     const ComparisonCondition& base, std::uint64_t seed);

}  // namespace ballservo
