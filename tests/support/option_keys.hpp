// What tests ask of the keys that a file of options has.
#pragma once

#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "calibration/base/numbers.hpp"
#include "calibration/base/options.hpp"

namespace ballservo::test {

/// The paths of all values of a document, items of lists as "[]".
inline void add_paths(const nlohmann::json& value, const std::string& path, std::set<std::string>& paths) {
  const bool items = value.is_array() && !value.empty() && value[0].is_object();
  if (value.is_object()) {
    for (const auto& [key, child] : value.items())
      add_paths(child, path.empty() ? key : path + "." + key, paths);
  } else if (items) {
    for (const auto& child : value) add_paths(child, path + "[]", paths);
  } else if (!value.is_array() || !value.empty()) {
    paths.insert(path);
  }
}

/// "balls[].x_m" as `item` names it: "balls[0].x_m" in messages.
inline std::string of_first_item(std::string path) {
  for (std::size_t at; (at = path.find("[]")) != std::string::npos;) path.insert(at + 1, "0");
  return path;
}

/// `text` with that value at the row's key, in lists of one item, where the row's conditions hold.
inline std::string with_value(const std::string& text, const OptionRow& row, const std::string& value) {
  StrictYaml yaml = StrictYaml::from_text(text, "base");
  for (std::size_t at = row.path.find("[]"); at != std::string::npos; at = row.path.find("[]", at + 1))
    yaml.set(of_first_item(row.path.substr(0, at)), "[{}]");
  for (const std::string& condition : row.conditions) {
    const std::size_t colon = condition.find(": ");
    if (colon == std::string::npos) continue;
    const std::string first = condition.substr(colon + 2, condition.find(',', colon) - colon - 2);
    yaml.set(of_first_item(condition.substr(0, colon)), first);
  }
  yaml.set(of_first_item(row.path), value);
  return yaml.resolved_json();
}

/// Values that the row does not allow.
inline std::vector<std::string> values_outside(const OptionRow& row) {
  const Option& option = row.option;
  std::vector<std::string> values{"{a: 1}"};
  const NumberRange& range = option.range;
  const bool number = std::holds_alternative<double*>(option.value);
  if (number || std::holds_alternative<long long*>(option.value)) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    values.emplace_back("text");
    const double low = range.low - (range.low_open ? 0 : 1), high = range.high + 1;
    if (low > -infinity && !range.contains(low)) values.push_back(number_text(low));
    if (high < infinity && !range.contains(high)) values.push_back(number_text(high));
  }
  if (std::holds_alternative<bool*>(option.value)) values.emplace_back("3");
  if (!option.choices.empty()) values.emplace_back("no_such_choice");
  return values;
}

/// Whether the row names a default that can be written into a file.
inline bool has_default(const OptionRow& row) {
  return !row.option.fallback.required && row.option.fallback.words.empty() && !row.fallback.empty();
}

}  // namespace ballservo::test
