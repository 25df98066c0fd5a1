// The answers of a comparison in sentences: is one step enough?
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "app/comparison/comparison.hpp"

namespace ballservo {

/// Places of the pairs of one step and converged fit in the list of pairs, the exact fit's first.
std::vector<std::size_t> one_step_pairs(const MethodList& methods);

/// Over all conditions, for each condition that has a name of its own, and along each sweep.
nlohmann::ordered_json comparison_answers(const ComparisonResults& results);

}  // namespace ballservo
