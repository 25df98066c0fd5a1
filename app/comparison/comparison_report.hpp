// What the page of a comparison is drawn from, beside its tables.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "app/comparison/comparison.hpp"
#include "app/comparison/pictures/comparison_photos.hpp"

namespace ballservo {

/// Takes a file of the results.
using WriteFile = std::function<void(const std::string& name, std::string_view contents)>;

/// The contents of report.json: what the methods do, and curves. `show` draws examples and the worst frames
/// again, whose pictures go to `write`; empty where the pictures are not at hand, and the page says so.
nlohmann::ordered_json comparison_report(const ComparisonResults& results, const ShowFrame& show,
                                         const WriteFile& write);

}  // namespace ballservo
