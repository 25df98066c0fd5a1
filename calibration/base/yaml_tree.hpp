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
  const YamlValue* parent = nullptr;        ///< null for the root
  std::string name;                         ///< below its parent: its key, or the number of the list's item
  std::vector<YamlValue*> children;         ///< of a map or a list, in the document's order
  std::map<std::string, YamlValue*> index;  ///< of a map: its children by their keys
  std::set<std::string> asked;              ///< of a map: the keys that a reader has asked for
  bool settled = false;  ///< a fault about this value as a whole is known: say nothing about its parts

  YamlValue* child(const std::string& key) const;             ///< of a map; null where there is none
  std::string path() const;                                   ///< "balls[0].diameter_m"; empty for the root
  void add(const std::string& child_name, YamlValue* child);  ///< at the end of a map or a list
};

/// Owns the values of one document; they stay where they are as long as it lives.
struct YamlTree {
  std::string name;         ///< of the file, for messages
  std::string tags_prefix;  ///< tags of lists and maps that begin so pass; empty: none does
  std::deque<YamlValue> values;
  YamlValue* root = nullptr;
  FaultList faults;

  YamlValue* make(YamlValue::Kind kind, int line);
  std::string place(int line, const std::string& path) const;  ///< "file.yaml:12: camera.rate_hz"
  std::string place(const YamlValue& value) const { return place(value.line, value.path()); }
};

/// "a.b" below "a", "b" below the root.
std::string path_below(const std::string& path, const std::string& key);

/// Parses `text` and adds its values to the tree; returns the document's root (a null value for an empty
/// text). `with_lines` false: the text is no file of its own, and its values get line 0. Throws InputError
/// for bad UTF-8, text that is no YAML, several documents, anchors, aliases, tags, keys that are no scalars,
/// and nesting deeper than 32. A duplicate key becomes a fault of the tree, and its first value stands.
YamlValue* parse_yaml(YamlTree& tree, const std::string& text, bool with_lines);

}  // namespace ballservo
