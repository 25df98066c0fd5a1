// YAML read strictly: every key is either asked for or a fault; all faults are reported at once, with their
// lines.
#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/base/fault.hpp"

namespace ballservo {

struct YamlTree;
struct YamlValue;

/// The range that a number may lie in, its upper bound included, and its unit for messages.
struct NumberRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;  ///< low itself is not allowed
  std::string unit;       ///< "m", "rad", "Hz"; empty where there is none

  static NumberRange any(std::string unit) {
    return at_least(-std::numeric_limits<double>::infinity(), std::move(unit));
  }
  static NumberRange above(double low, std::string unit) {
    return {low, std::numeric_limits<double>::infinity(), true, std::move(unit)};
  }
  static NumberRange above(double low, double high, std::string unit) {  ///< up to `high` itself
    return {low, high, true, std::move(unit)};
  }
  static NumberRange at_least(double low, std::string unit) {
    return {low, std::numeric_limits<double>::infinity(), false, std::move(unit)};
  }
  static NumberRange within(double low, double high, std::string unit) {
    return {low, high, false, std::move(unit)};
  }

  bool contains(double value) const;  ///< false for NaN
  std::string to_text() const;        ///< "a number above 0 (Hz)"
  std::string interval() const;       ///< "(0, inf)"
};

/// A node of a YAML document, with its place in it. A cheap handle; the document lives as long as any of its
/// nodes.
///
/// A reader asks for the keys it knows; each getter that finds something wrong adds a fault and returns a
/// harmless value, so that reading goes on and the user sees everything at once. When the reader is done it
/// calls `StrictYaml::finish`, which adds a fault for every key that nobody asked for, and throws if there is
/// any fault.
class YamlNode {
 public:
  bool has(const std::string& key);  ///< marks the key as known; a null value counts as absent

  /// Required without a fallback: a missing key is a fault.
  double number(const std::string& key, const NumberRange& range, std::optional<double> fallback = {});
  long long integer(const std::string& key, long long low, long long high,
                    std::optional<long long> fallback = {});
  bool boolean(const std::string& key, std::optional<bool> fallback = {});
  std::string text(const std::string& key, std::optional<std::string> fallback = {});
  std::string choice(const std::string& key, const std::vector<std::string>& allowed,
                     std::optional<std::string> fallback = {});
  /// A sequence of numbers; `count` 0 means any length.
  std::vector<double> numbers(const std::string& key, const NumberRange& range, std::size_t count,
                              std::optional<std::vector<double>> fallback = {});
  /// A mapping below this one; where it is missing a fault is added if `needed`, and an empty mapping
  /// returned.
  YamlNode map(const std::string& key, bool needed = true);
  /// The items of a sequence below this one; empty where it is missing (a fault if `needed`).
  std::vector<YamlNode> list(const std::string& key, bool needed = false);
  /// The keys of this mapping, in the document's order, not marked as known (for free-form maps such as
  /// `vary`).
  std::vector<std::string> keys() const;

  /// The scalar of this node itself (items of a list); faults as above.
  std::string as_text();

  /// What is under this key, if anything, is not the reader's business: known, whatever it holds.
  void leave_aside(const std::string& key);

  std::string place() const;                        ///< "file.yaml:12: camera.noise.read"
  std::string place(const std::string& key) const;  ///< the same for a child, with its own line
  void fault(const std::string& key, std::string found,
             std::string allowed);  ///< a fault of the reader's own at a child

 private:
  friend class StrictYaml;
  YamlNode(std::shared_ptr<YamlTree> tree, YamlValue* value) : tree_(std::move(tree)), value_(value) {}

  /// The value under `key`, which counts as known from now on; null where it is absent. What is no map at all
  /// is a fault once.
  YamlValue* ask(const std::string& key);
  void add_fault(YamlValue& at, std::string allowed);
  void add_missing(const std::string& key, const std::string& allowed);
  /// What all the getters do: the fallback or a fault for a missing key, a fault for a value that `read`
  /// refuses.
  template <typename T, typename Read>
  T get(const std::string& key, const std::optional<T>& fallback, const T& harmless,
        const std::string& allowed, Read read);

  std::shared_ptr<YamlTree> tree_;
  YamlValue* value_;
};

/// Which tags (!!name) a document may have.
enum class YamlTags {
  refused,
  opencv  ///< those that OpenCV's FileStorage puts before its matrices: !!opencv-matrix and its like
};

/// A strictly read document. Refuses files over `max_bytes`, bad UTF-8, several documents, anchors and
/// aliases (a small file could unfold without bound), nesting deeper than 32, duplicate keys, `.nan` and
/// `.inf`.
class StrictYaml {
 public:
  static constexpr std::size_t max_bytes = 4u << 20;

  /// Throws InputError when the file can't be read or isn't YAML at all.
  static StrictYaml from_file(const std::filesystem::path& file);
  /// `name` stands for the file in messages.
  static StrictYaml from_text(const std::string& text, const std::string& name,
                              YamlTags tags = YamlTags::refused);

  YamlNode root() const;
  FaultList& faults();
  /// Sets a value at "a.b.c" or "balls.0.diameter_m" before reading (`--set`); the text is parsed as YAML.
  /// A path below something that is not a map or list is a fault at "--set".
  void set(const std::string& key_path, const std::string& yaml_value);
  /// Adds a fault for every key that was never asked for, then throws InputError if any fault is known.
  void finish();
  /// The document as it now stands (after `set`), as JSON text with sorted keys: for manifests and hashes.
  std::string resolved_json() const;

 private:
  std::shared_ptr<YamlTree> tree_;
};

/// The path of a key, "balls[0].x" or "balls.0.x", as the latter.
std::string with_dots(std::string path);

}  // namespace ballservo
