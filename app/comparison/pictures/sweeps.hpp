// The conditions of a comparison in groups: those that vary one number, and those that show the same.
#pragma once

#include <string>
#include <vector>

#include "app/comparison/comparison.hpp"

namespace ballservo {

/// The conditions that vary one number, two or more, in its order: places in the results' list.
struct Sweep {
  std::string key, label;
  bool log = false;
  std::vector<std::size_t> conditions;
};
std::vector<Sweep> sweeps_of(const ComparisonResults& results);

/// "base; noise, sigma (grey levels): 1, 5": conditions of a sweep by their values, others by their names.
std::string in_words(const ComparisonResults& results, const std::vector<std::size_t>& conditions);

/// Conditions that show one and the same setting, each on frames of its own: the largest group of two or
/// more, empty where there is none.
std::vector<std::size_t> repeated_setting(const ComparisonResults& results);

}  // namespace ballservo
