// A comparison's results as JSON (`--json`).
#pragma once

#include <nlohmann/json.hpp>

#include "app/comparison/comparison.hpp"

namespace ballservo {

/// {"conditions": {NAME: {METHOD: figures}}, "pairs": [...], "certificates": [...]}; no times.
nlohmann::json comparison_json(const ComparisonResults& results);

}  // namespace ballservo
