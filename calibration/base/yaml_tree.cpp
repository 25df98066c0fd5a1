#include "calibration/base/yaml_tree.hpp"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <utility>

namespace ballservo {
namespace {

constexpr std::size_t max_depth = 32;

/// The line (from 1) of the first byte that is no UTF-8 text; nothing if all is well.
std::optional<int> line_of_bad_utf8(const std::string& text) {
  const auto is_control = [](unsigned char c) { return (c < 0x20 && c != '\t' && c != '\r') || c == 0x7F; };
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (std::any_of(line.begin(), line.end(), is_control)) return number;
    try {
      nlohmann::json(line).dump();
    } catch (const nlohmann::json::type_error&) {  // JSON's texts are UTF-8
      return number;
    }
  }
  return std::nullopt;
}

/// Builds the tree from the parser's events. The parser's own node type would let duplicate keys pass.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(YamlTree& tree, bool with_lines) : tree_(tree), with_lines_(with_lines) {}

  YamlValue* root() const { return root_; }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    refuse_anchor(mark, anchor);
    if (waiting_for_key()) refuse(mark, "an empty key", "a name before the colon");
    add(make(YamlValue::Kind::null, mark));
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    refuse(mark, "an alias (*name)", "values written out where they are used");
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    refuse_anchor(mark, anchor);
    refuse_tag(mark, tag);
    if (waiting_for_key()) {
      open_.back().key = text;
      open_.back().key_line = line(mark);
      return;
    }
    YamlValue* value = make(YamlValue::Kind::scalar, mark);
    value->scalar = text;
    value->quoted = tag == "!";
    add(value);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(YamlValue::Kind::list, mark, tag, anchor);
  }
  void OnSequenceEnd() override { open_.pop_back(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(YamlValue::Kind::map, mark, tag, anchor);
  }
  void OnMapEnd() override { open_.pop_back(); }

 private:
  struct Open {
    YamlValue* value;
    std::optional<std::string> key;  ///< read, its value still to come
    int key_line = 0;
  };

  int line(const YAML::Mark& mark) const { return with_lines_ ? mark.line + 1 : 0; }
  YamlValue* make(YamlValue::Kind kind, const YAML::Mark& mark) { return tree_.make(kind, line(mark)); }
  bool waiting_for_key() const {
    return !open_.empty() && open_.back().value->kind == YamlValue::Kind::map && !open_.back().key;
  }

  void add(YamlValue* value) {
    if (open_.empty()) {
      root_ = value;
      return;
    }
    YamlValue& parent = *open_.back().value;
    if (parent.kind == YamlValue::Kind::list)
      return parent.add(std::to_string(parent.children.size()), value);
    const std::string key = *std::exchange(open_.back().key, std::nullopt);
    // The key's line, not its value's: that is where a person looks.
    value->line = open_.back().key_line;
    const YamlValue* first = parent.child(key);
    if (!first) return parent.add(key, value);
    value->parent = &parent, value->name = key;
    tree_.faults.add(tree_.place(*value),
                     "the key a second time (first on line " + std::to_string(first->line) + ")",
                     "each key once");
  }

  void open(YamlValue::Kind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    refuse_anchor(mark, anchor);
    if (tree_.tags_prefix.empty() || tag.rfind(tree_.tags_prefix, 0) != 0) refuse_tag(mark, tag);
    if (waiting_for_key()) refuse(mark, "a list or map as a key", "a name before the colon");
    if (open_.size() >= max_depth) {
      refuse(mark, "values nested deeper than " + std::to_string(max_depth), "a flatter document");
    }
    YamlValue* value = make(kind, mark);
    add(value);
    open_.push_back({value, std::nullopt, 0});
  }

  void refuse_anchor(const YAML::Mark& mark, YAML::anchor_t anchor) const {
    if (anchor != YAML::NullAnchor)
      refuse(mark, "an anchor (&name)", "values written out where they are used");
  }
  void refuse_tag(const YAML::Mark& mark, const std::string& tag) const {
    const bool plain = tag.empty() || tag == "?" || tag == "!";
    if (!plain) refuse(mark, "a tag (" + tag + ")", "values without tags");
  }
  [[noreturn]] void refuse(const YAML::Mark& mark, std::string found, std::string allowed) const {
    throw InputError(tree_.place(line(mark), ""), std::move(found), std::move(allowed));
  }

  YamlTree& tree_;
  bool with_lines_;
  YamlValue* root_ = nullptr;
  std::vector<Open> open_;
};

}  // namespace

YamlValue* YamlValue::child(const std::string& key) const {
  const auto found = index.find(key);
  return found == index.end() ? nullptr : found->second;
}

std::string YamlValue::path() const {
  if (!parent) return "";
  return parent->kind == Kind::list ? parent->path() + "[" + name + "]" : path_below(parent->path(), name);
}

void YamlValue::add(const std::string& child_name, YamlValue* child) {
  child->parent = this, child->name = child_name;
  children.push_back(child);
  if (kind == Kind::map) index.emplace(child_name, child);
}

YamlValue* YamlTree::make(YamlValue::Kind kind, int line) {
  YamlValue& value = values.emplace_back();
  value.kind = kind;
  value.line = line;
  return &value;
}

std::string YamlTree::place(int line, const std::string& path) const {
  std::string place = line > 0 ? name + ":" + std::to_string(line) : "--set";
  if (!path.empty()) place += ": " + path;
  return place;
}

std::string path_below(const std::string& path, const std::string& key) {
  return path.empty() ? key : path + "." + key;
}

YamlValue* parse_yaml(YamlTree& tree, const std::string& text, bool with_lines) {
  const auto refuse = [&](int line, std::string found) {
    throw InputError(tree.place(with_lines ? std::max(line, 1) : 0, ""), std::move(found),
                     "well-formed YAML in UTF-8");
  };
  if (const auto line = line_of_bad_utf8(text)) refuse(*line, "bytes that are no UTF-8 text");
  TreeBuilder builder(tree, with_lines);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    parser.HandleNextDocument(builder);
    if (YamlValue* root = builder.root()) {
      TreeBuilder second(tree, with_lines);
      if (parser.HandleNextDocument(second))
        refuse(second.root() ? second.root()->line : 1, "a second document");
      return root;
    }
  } catch (const YAML::Exception& error) {
    refuse(error.mark.line + 1, "text that is no YAML (" + error.msg + ")");
  }
  return tree.make(YamlValue::Kind::null, with_lines ? 1 : 0);
}

}  // namespace ballservo
