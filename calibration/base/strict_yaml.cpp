#include "calibration/base/strict_yaml.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "calibration/base/numbers.hpp"
#include "calibration/base/system_file.hpp"
#include "calibration/base/yaml_tree.hpp"

namespace ballservo {
namespace {

using Kind = YamlValue::Kind;

/// What stands at a value, for messages.
std::string description(const YamlValue& value) {
  switch (value.kind) {
    case Kind::null:
      return "nothing";
    case Kind::list:
      return "a list";
    case Kind::map:
      return "a map";
    case Kind::scalar:
      break;
  }
  return value.quoted ? "text \"" + value.scalar + "\"" : value.scalar;
}

std::optional<double> number_in(const NumberRange& range, const YamlValue& value) {
  if (value.kind != Kind::scalar || value.quoted) return std::nullopt;
  const auto number = parse_number(value.scalar);
  return number && range.contains(*number) ? number : std::nullopt;
}

/// A number to go on with where a fault is known.
double harmless_in(const NumberRange& range) {
  if (range.contains(0)) return 0;
  return range.contains(1) ? 1 : std::isfinite(range.low) ? range.low : range.high;
}

std::optional<bool> boolean_of(const YamlValue& value) {
  if (value.kind != Kind::scalar || value.quoted) return std::nullopt;
  if (value.scalar == "true") return true;
  if (value.scalar == "false") return false;
  return std::nullopt;
}

nlohmann::json to_json(const YamlValue& value) {
  if (value.kind == Kind::null) return nullptr;
  if (value.kind == Kind::list) {
    auto array = nlohmann::json::array();
    for (const YamlValue* child : value.children) array.push_back(to_json(*child));
    return array;
  }
  if (value.kind == Kind::map) {
    auto object = nlohmann::json::object();
    for (const YamlValue* child : value.children) object[child->name] = to_json(*child);
    return object;
  }
  if (value.quoted) return value.scalar;
  if (const auto integer = parse_integer(value.scalar)) return *integer;
  if (const auto number = parse_number(value.scalar)) return *number;
  if (const auto boolean = boolean_of(value)) return *boolean;
  return value.scalar;
}

void add_faults_of_unknown_keys(YamlTree& tree, const YamlValue& value) {
  if (value.settled) return;
  for (const YamlValue* child : value.children) {
    if (value.kind == Kind::list || value.asked.count(child->name) > 0) {
      add_faults_of_unknown_keys(tree, *child);
    } else {
      const std::string known = fmt::format("one of {}", fmt::join(value.asked, ", "));
      tree.faults.add(tree.place(*child), "an unknown key", value.asked.empty() ? "no key here" : known);
    }
  }
}

/// "balls[0].x" and "balls.0.x" alike, as the steps "balls", "0", "x".
std::vector<std::string> steps_of(const std::string& key_path) {
  std::vector<std::string> steps(1);
  for (std::size_t i = 0; i < key_path.size(); ++i) {
    const char c = key_path[i];
    if (c == '.' || c == '[') {
      steps.emplace_back();
    } else if (c == ']' && (i + 1 == key_path.size() || key_path[i + 1] == '.' || key_path[i + 1] == '[')) {
      if (i + 1 < key_path.size() && key_path[i + 1] == '.') ++i, steps.emplace_back();
    } else {
      steps.back() += c;
    }
  }
  return steps;
}

}  // namespace

bool NumberRange::contains(double value) const {
  return (low_open ? value > low : value >= low) && value <= high;
}

std::string NumberRange::to_text() const {
  const bool has_low = low > -std::numeric_limits<double>::infinity();
  const bool has_high = high < std::numeric_limits<double>::infinity();
  const std::string low_text = (low_open ? "above " : "from ") + number_text(low);
  std::string text = "a finite number";
  if (has_low && has_high) {
    text = "a number " + low_text + (low_open ? " up to " : " to ") + number_text(high);
  } else if (has_low) {
    text = low_open ? "a number above " + number_text(low) : "a number of at least " + number_text(low);
  } else if (has_high) {
    text = "a number of at most " + number_text(high);
  }
  return unit.empty() ? text : text + " (" + unit + ")";
}

std::string NumberRange::interval() const {
  return fmt::format("{}{}, {}{}", low_open || std::isinf(low) ? '(' : '[', low, high,
                     std::isinf(high) ? ')' : ']');
}

YamlValue* YamlNode::ask(const std::string& key) {
  value_->asked.insert(key);
  if (value_->kind != Kind::map && value_->kind != Kind::null && !value_->settled)
    add_fault(*value_, "a map (key: value)");
  YamlValue* child = value_->kind == Kind::map ? value_->child(key) : nullptr;
  return child && child->kind == Kind::null ? nullptr : child;
}

void YamlNode::add_fault(YamlValue& at, std::string allowed) {
  tree_->faults.add(tree_->place(at), description(at), std::move(allowed));
  at.settled = true;
}

void YamlNode::add_missing(const std::string& key, const std::string& allowed) {
  if (!value_->settled) tree_->faults.add(place(key), "nothing", allowed);
}

template <typename T, typename Read>
T YamlNode::get(const std::string& key, const std::optional<T>& fallback, const T& harmless,
                const std::string& allowed, Read read) {
  YamlValue* child = ask(key);
  const std::optional<T> result = child ? read(*child) : fallback;
  if (result) return *result;
  child ? add_fault(*child, allowed) : add_missing(key, allowed);
  return fallback.value_or(harmless);
}

bool YamlNode::has(const std::string& key) { return ask(key) != nullptr; }

double YamlNode::number(const std::string& key, const NumberRange& range, std::optional<double> fallback) {
  return get<double>(key, fallback, harmless_in(range), range.to_text(),
                     [&](const YamlValue& value) { return number_in(range, value); });
}

long long YamlNode::integer(const std::string& key, long long low, long long high,
                            std::optional<long long> fallback) {
  const std::string allowed = fmt::format("a whole number from {} to {}", low, high);
  return get<long long>(key, fallback, low, allowed, [&](const YamlValue& value) -> std::optional<long long> {
    if (value.kind != Kind::scalar || value.quoted) return std::nullopt;
    const auto integer = parse_integer(value.scalar);
    return integer && *integer >= low && *integer <= high ? integer : std::nullopt;
  });
}

bool YamlNode::boolean(const std::string& key, std::optional<bool> fallback) {
  return get<bool>(key, fallback, false, "true or false", boolean_of);
}

std::string YamlNode::text(const std::string& key, std::optional<std::string> fallback) {
  return get<std::string>(key, fallback, "", "text", [](const YamlValue& value) {
    return value.kind == Kind::scalar ? std::optional(value.scalar) : std::nullopt;
  });
}

std::string YamlNode::choice(const std::string& key, const std::vector<std::string>& allowed,
                             std::optional<std::string> fallback) {
  const std::string harmless = allowed.empty() ? std::string() : allowed.front();
  const auto read = [&](const YamlValue& value) {
    const bool known =
        value.kind == Kind::scalar && std::count(allowed.begin(), allowed.end(), value.scalar) > 0;
    return known ? std::optional(value.scalar) : std::nullopt;
  };
  return get<std::string>(key, fallback, harmless, fmt::format("one of {}", fmt::join(allowed, ", ")), read);
}

std::vector<double> YamlNode::numbers(const std::string& key, const NumberRange& range, std::size_t count,
                                      std::optional<std::vector<double>> fallback) {
  const std::string length = count > 0 ? std::to_string(count) : "any number of";
  const std::string allowed = "a list of " + length + " entries, each " + range.to_text();
  const std::vector<double> harmless = fallback.value_or(std::vector<double>(count));
  const auto list = get<YamlValue*>(
      key, fallback ? std::optional<YamlValue*>(nullptr) : std::nullopt, nullptr, allowed,
      [](YamlValue& value) { return value.kind == Kind::list ? std::optional(&value) : std::nullopt; });
  if (!list) return harmless;
  if (count > 0 && list->children.size() != count) {
    fault(key, fmt::format("a list of {} entries", list->children.size()), allowed);
    return harmless;
  }
  std::vector<double> values;
  for (YamlValue* item : list->children) {
    const auto number = number_in(range, *item);
    if (!number) add_fault(*item, range.to_text());
    if (number) values.push_back(*number);
  }
  return values.size() == list->children.size() ? values : harmless;
}

YamlNode YamlNode::map(const std::string& key, bool needed) {
  YamlValue* child = ask(key);
  if (child && child->kind == Kind::map) return YamlNode(tree_, child);
  if (child) {
    add_fault(*child, "a map (key: value)");
  } else if (needed) {
    add_missing(key, "a map (key: value)");
  }
  YamlValue* empty = tree_->make(Kind::map, value_->line);
  empty->parent = value_, empty->name = key;
  empty->settled = child || needed || value_->settled;
  return YamlNode(tree_, empty);
}

std::vector<YamlNode> YamlNode::list(const std::string& key, bool needed) {
  YamlValue* child = ask(key);
  std::vector<YamlNode> items;
  if (child && child->kind == Kind::list) {
    for (YamlValue* item : child->children) items.push_back(YamlNode(tree_, item));
  } else if (child) {
    add_fault(*child, "a list");
  } else if (needed) {
    add_missing(key, "a list");
  }
  return items;
}

std::vector<std::string> YamlNode::keys() const {
  std::vector<std::string> keys;
  if (value_->kind == Kind::map)
    for (const YamlValue* child : value_->children) keys.push_back(child->name);
  return keys;
}

std::string YamlNode::as_text() {
  if (value_->kind == Kind::scalar) return value_->scalar;
  add_fault(*value_, "text");
  return {};
}

void YamlNode::leave_aside(const std::string& key) {
  if (YamlValue* child = ask(key)) child->settled = true;
}

std::string YamlNode::place() const { return tree_->place(*value_); }

std::string YamlNode::place(const std::string& key) const {
  const YamlValue* child = value_->child(key);
  return tree_->place(child ? child->line : value_->line, path_below(value_->path(), key));
}

void YamlNode::fault(const std::string& key, std::string found, std::string allowed) {
  tree_->faults.add(place(key), std::move(found), std::move(allowed));
  value_->asked.insert(key);
  if (YamlValue* child = value_->child(key)) child->settled = true;
}

StrictYaml StrictYaml::from_file(const std::filesystem::path& file) {
  return from_text(read_file_bytes(file, max_bytes), file.string());
}

StrictYaml StrictYaml::from_text(const std::string& text, const std::string& name, YamlTags tags) {
  if (text.size() > max_bytes) {
    throw InputError(name, fmt::format("{} bytes", text.size()), fmt::format("at most {} bytes", max_bytes));
  }
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw InputError(name, "an empty file", "YAML with keys and values");
  StrictYaml yaml;
  yaml.tree_ = std::make_shared<YamlTree>();
  yaml.tree_->name = name;
  if (tags == YamlTags::opencv) yaml.tree_->tags_prefix = "tag:yaml.org,2002:opencv-";
  yaml.tree_->root = parse_yaml(*yaml.tree_, text, true);
  return yaml;
}

YamlNode StrictYaml::root() const { return YamlNode(tree_, tree_->root); }

FaultList& StrictYaml::faults() { return tree_->faults; }

void StrictYaml::set(const std::string& key_path, const std::string& yaml_value) {
  YamlTree& tree = *tree_;
  const auto refuse = [&](std::string found, std::string allowed) {
    tree.faults.add("--set " + key_path, std::move(found), std::move(allowed));
  };
  YamlValue* replacement = nullptr;
  try {
    replacement = parse_yaml(tree, yaml_value, false);
  } catch (const InputError& error) {
    return refuse(error.faults().front().found, "key.path=value, the value as in YAML");
  }
  const std::vector<std::string> steps = steps_of(key_path);
  if (std::count(steps.begin(), steps.end(), "") > 0) return refuse("an empty key", "keys joined by dots");
  YamlValue* at = tree.root;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (at->kind == Kind::null) at->kind = Kind::map;
    YamlValue* next = nullptr;
    if (at->kind == Kind::map) {
      next = at->child(steps[i]);
      if (!next) at->add(steps[i], next = tree.make(Kind::null, 0));
    } else if (at->kind == Kind::list) {
      const auto item = parse_integer(steps[i]);
      if (!item || *item < 0 || *item >= static_cast<long long>(at->children.size())) {
        return refuse(fmt::format("item {} of a list of {}", steps[i], at->children.size()),
                      "an item that exists, counted from 0");
      }
      next = at->children[static_cast<std::size_t>(*item)];
    } else {
      return refuse(description(*at) + " at " + at->path(), "a path through maps and lists");
    }
    at = next;
  }
  replacement->parent = at->parent, replacement->name = at->name;
  *at = *replacement;
  for (YamlValue* child : at->children) child->parent = at;
}

void StrictYaml::finish() {
  add_faults_of_unknown_keys(*tree_, *tree_->root);
  tree_->faults.throw_if_any();
}

std::string StrictYaml::resolved_json() const { return to_json(*tree_->root).dump(); }

std::string with_dots(std::string path) {
  std::replace(path.begin(), path.end(), '[', '.');
  path.erase(std::remove(path.begin(), path.end(), ']'), path.end());
  return path;
}

}  // namespace ballservo
