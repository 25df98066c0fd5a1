// A YAML document as a plain tree that keeps what strict reading needs: lines, quotes, and duplicate keys as
// faults.
#pragma once

#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "calibration/base/fault.hpp"

namespace ballservo {

/// One value of a document.
struct YamlValue {
  enum class Kind { null, scalar, list, map };

  Kind kind = Kind::null;
  std::string scalar;   ///< of a scalar: its text
  bool quoted = false;  ///< of a scalar: written in quotes or as a block, hence text and never a number
  int line = 0;         ///< counts from 1; 0 where it came from `--set`
  std::string path;     ///< "balls[0].diameter_m"; empty for the root
  std::vector<std::string> keys;             ///< of a map, in the document's order
  std::vector<YamlValue*> children;          ///< of a map (beside `keys`) or a list
  std::map<std::string, std::size_t> index;  ///< of a map: where each key stands
  std::set<std::string> asked;               ///< of a map: the keys that a reader has asked for
  bool settled = false;  ///< a fault about this value as a whole is known: say nothing about its parts

  YamlValue* child(const std::string& key) const;  ///< of a map; null where there is none
};

/// Owns the values of one document; they stay where they are as long as it lives.
struct YamlTree {
  std::string name;         ///< of the file, for messages
  std::string tags_prefix;  ///< tags of lists and maps that begin so pass; empty: none does
  std::deque<YamlValue> values;
  YamlValue* root = nullptr;
  FaultList faults;

  YamlValue* make(YamlValue::Kind kind, int line);
  /// Adds a child under a new key of a map, with its path.
  void add_child(YamlValue& map, const std::string& key, YamlValue* child);
  std::string place(int line, const std::string& path) const;  ///< "file.yaml:12: camera.rate_hz"
};

/// "a.b" below "a", "b" below the root.
std::string path_below(const std::string& path, const std::string& key);

/// Gives a value and everything below it its path.
void set_paths(YamlValue& value, const std::string& path);

/// Parses `text` and adds its values to the tree; returns the document's root (a null value for an empty
/// text). `with_lines` false: the text is no file of its own, and its values get line 0. Throws InputError
/// for bad UTF-8, text that is no YAML, several documents, anchors, aliases, tags, keys that are no scalars,
/// and nesting deeper than
/// 32. A duplicate key becomes a fault of the tree, and its first value stands.
YamlValue* parse_yaml(YamlTree& tree, const std::string& text, bool with_lines);

}  // namespace ballservo
