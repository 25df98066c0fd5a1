#include "calibration/base/options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <map>

#include "calibration/base/numbers.hpp"

namespace ballservo {
namespace {

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

/// The number as messages show it: "NaN" and "inf" too.
std::string shown(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return number_text(value);
}

/// What a missing key is read as; nothing for one that is required.
template <class Value>
std::optional<Value> fallback_of(const Option& option, const Value* value) {
  return option.fallback.required ? std::nullopt : std::optional<Value>(*value);
}

}  // namespace

void OptionReader::option(const Option& o) {
  std::visit(Overloaded{
                 [&](double* value) { *value = node_.number(o.key, o.range, fallback_of(o, value)); },
                 [&](long long* value) {
                   const auto low = static_cast<long long>(o.range.low),
                              high = static_cast<long long>(o.range.high);
                   *value = node_.integer(o.key, low, high, fallback_of(o, value));
                 },
                 [&](bool* value) { *value = node_.boolean(o.key, fallback_of(o, value)); },
                 [&](std::string* value) {
                   *value = o.choices.empty() ? node_.text(o.key, fallback_of(o, value))
                                              : node_.choice(o.key, o.choices, fallback_of(o, value));
                 },
                 [&](std::vector<double>* values) {
                   *values = node_.numbers(o.key, o.range, o.count, fallback_of(o, values));
                 },
                 [&](std::vector<std::string>* values) {
                   if (!node_.has(o.key)) return;
                   values->clear();
                   for (YamlNode& item : node_.list(o.key)) values->push_back(item.as_text());
                 },
             },
             o.value);
}

void OptionReader::below(const YamlNode& node, const Body& body) {
  const YamlNode above = std::exchange(node_, node);
  body();
  node_ = above;
}

void OptionReader::map(Text key, const Fallback& fallback, const Body& body) {
  below(node_.map(key, fallback.required), body);
}

void OptionReader::list(Text key, std::size_t, const Fallback& fallback, const Item& item) {
  const std::vector<YamlNode> items = node_.list(key, fallback.required);
  for (std::size_t i = 0; i < items.size(); ++i) below(items[i], [&] { item(i); });
}

void OptionReader::entries(Text key, Text, const Entry& entry) {
  const YamlNode node = node_.map(key, false);
  below(node, [&] {
    for (const std::string& name : node.keys()) entry(name);
  });
}

void OptionReader::require(bool holds, Text key, Text found, Text allowed) {
  if (!holds) node_.fault(key, found, allowed);
}

void OptionChecker::option(const Option& o) {
  const auto check = [&](double value, const std::string& allowed) {
    require(std::isfinite(value) && o.range.contains(value), o.key, shown(value), allowed);
  };
  std::visit(Overloaded{
                 [&](const double* value) { check(*value, o.range.to_text()); },
                 [&](const long long* value) {
                   check(static_cast<double>(*value),
                         fmt::format("a whole number from {} to {}", o.range.low, o.range.high));
                 },
                 [&](const std::string* value) {
                   require(o.choices.empty() || std::count(o.choices.begin(), o.choices.end(), *value) > 0,
                           o.key, *value, fmt::format("one of {}", fmt::join(o.choices, ", ")));
                 },
                 [&](const std::vector<double>* values) {
                   for (const double value : *values) check(value, o.range.to_text());
                 },
                 [](const auto*) {},
             },
             o.value);
}

void OptionChecker::below(std::string place, const Body& body) {
  std::swap(place, place_);
  body();
  place_ = std::move(place);
}

void OptionChecker::list(Text key, std::size_t count, const Fallback&, const Item& item) {
  for (std::size_t i = 0; i < count; ++i) below(fmt::format("{}[{}]", path(key), i), [&] { item(i); });
}

void OptionChecker::require(bool holds, Text key, Text found, Text allowed) {
  if (!holds) faults_.add(path(key), found, allowed);
}

void OptionLister::option(const Option& o) {
  OptionRow row{path(o.key), o.range.unit, "", o.range.interval(), o.help, conditions_, o};
  row.fallback = std::visit(
      Overloaded{
          [](const double* value) { return number_text(*value); },
          [](const std::vector<std::string>* words) { return fmt::format("[{}]", fmt::join(*words, ", ")); },
          [](const auto* value) { return fmt::format("{}", *value); },
      },
      o.value);
  if (std::holds_alternative<bool*>(o.value)) row.allowed = "true, false";
  if (std::holds_alternative<std::string*>(o.value))
    row.allowed = o.choices.empty() ? "text" : fmt::format("{}", fmt::join(o.choices, ", "));
  if (std::holds_alternative<long long*>(o.value)) row.allowed = "whole, " + row.allowed;
  if (std::holds_alternative<std::vector<double>*>(o.value))
    row.allowed = (o.count > 0 ? std::to_string(o.count) : "a list") + " in " + row.allowed;
  if (std::holds_alternative<std::vector<std::string>*>(o.value)) row.allowed = "a list of texts";
  if (o.fallback.required) row.fallback = "required";
  if (!o.fallback.words.empty()) row.fallback = o.fallback.words;
  std::visit([](auto& value) { value = nullptr; }, row.option.value);
  rows_.push_back(std::move(row));
}

void OptionLister::list(Text key, std::size_t, const Fallback&, const Item& item) {
  below(path(key) + "[]", [&] { item(0); });
}

void OptionLister::entries(Text key, Text example, const Entry& entry) {
  below(path(key), [&] { entry(example); });
}

void OptionLister::only_if(bool, Text condition, const Body& body) {
  conditions_.push_back(path(condition));
  body();
  conditions_.pop_back();
}

std::string option_page(const std::string& file, const std::vector<OptionRow>& rows) {
  using Line = std::array<std::string, 5>;
  const Line head{"key", "unit", "default", "allowed", "meaning"};
  std::map<std::string, std::vector<Line>> tables;
  for (const OptionRow& row : rows) {
    std::string when;
    for (const std::string& condition : row.conditions)
      when += condition.substr(condition.find_last_of('.') + 1) + "; ";
    const std::size_t dot = row.path.find_first_of(".[");
    tables[dot == std::string::npos ? "" : row.path.substr(0, dot)].push_back(
        {"`" + row.path + "`", row.unit, row.fallback, row.allowed, when + row.help});
  }
  std::string text = fmt::format(
      "# Every key of a {}\n\n`[]` stands for an entry of a list, `KEY.PATH` for a key of your own choice. "
      "`[0, 1)` "
      "is a range from 0 to 1, without 1 itself. What stands before a semicolon says when a key is known.\n",
      file);
  for (auto& [name, lines] : tables) {
    lines.insert(lines.begin(), head);
    Line dashes;
    for (std::size_t k = 0; k < head.size(); ++k) {
      std::size_t width = 0;
      for (const Line& line : lines) width = std::max(width, line[k].size());
      for (Line& line : lines) line[k].resize(width, ' ');
      dashes[k].assign(width, '-');
    }
    lines.insert(lines.begin() + 1, dashes);
    text += name.empty() ? "" : fmt::format("\n## {}\n", name);
    text += "\n";
    for (const Line& line : lines) text += fmt::format("| {} |\n", fmt::join(line, " | "));
  }
  return text;
}

void NumberFinder::option(const Option& o) {
  double* const* number = std::get_if<double*>(&o.value);
  if (number && path(o.key) == wanted_) use_(**number, o);
}

}  // namespace ballservo
