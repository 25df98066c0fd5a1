// Options, each declared once: key, unit, range, default and meaning.
//
// Beside a struct of options stands one function that names its members:
//
//   void declare(OptionVisitor& v, UnicycleLimits& limits) {
//     v.number("v_max_mps", limits.v_max_mps, NumberRange::above(0, 10, "m/s"), "largest speed");
//     ...
//   }
//
// Visitors walk it: OptionReader fills the struct from YAML, OptionChecker judges one that was made in code,
// OptionLister writes the reference page, and NumberFinder reaches one number by its path.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "calibration/base/strict_yaml.hpp"

namespace ballservo {

/// What holds where a file leaves a key out. Unless said otherwise: the value that the struct has.
struct Fallback {
  bool required = false;  ///< nothing does: a missing key is a fault
  std::string words{};    ///< of a value that depends on others: "the ball's radius"
};
inline const Fallback required{true};
inline Fallback otherwise(std::string words) { return {false, std::move(words)}; }

/// The values of a choice beside their names in files.
template <class Value>
using Names = std::vector<std::pair<std::string, Value>>;
template <class List, class Name>
auto names_of(const List& values, const Name& name) {
  Names<typename List::value_type> names;
  for (const auto& value : values) names.emplace_back(std::string(name(value)), value);
  return names;
}

/// One option, as visitors see it.
struct Option {
  using Value =
      std::variant<double*, long long*, bool*, std::string*, std::vector<double>*, std::vector<std::string>*>;

  std::string key;
  Value value;
  NumberRange range;                 ///< of a number, a whole number, each number of a list
  std::vector<std::string> choices;  ///< of a text; empty: any text
  std::size_t count = 0;             ///< of a list of numbers: its length; 0: any
  std::string help;
  Fallback fallback;
};

class OptionVisitor {
 public:
  using Text = const std::string&;
  using Range = const NumberRange&;
  using Body = std::function<void()>;
  using Item = std::function<void(std::size_t)>;
  using Entry = std::function<void(Text)>;
  virtual ~OptionVisitor() = default;

  virtual void option(const Option& option) = 0;
  /// What `body` declares lies in a map below `key`.
  virtual void map(Text key, const Fallback& fallback, const Body& body) = 0;
  void map(Text key, const Body& body) { map(key, Fallback{}, body); }
  /// Each item of the list below `key` is a map that `item` declares; the struct holds `count` of them.
  virtual void list(Text key, std::size_t count, const Fallback& fallback, const Item& item) = 0;
  void list(Text key, const Item& item) { list(key, 0, {}, item); }
  /// Of a map whose keys are the user's own, such as `example`: `entry` declares what lies at each.
  virtual void entries(Text key, Text example, const Entry& entry) = 0;
  /// Whether a key is there; `now`: whether the struct has its value already.
  virtual bool present(Text key, bool now) = 0;
  /// The keys that `body` declares are known only if `holds`; the text says when that is: "type: rolling".
  virtual void only_if(bool holds, Text, const Body& body) {
    if (holds) body();
  }
  /// A fault at `key` unless `holds`: for what no range can say.
  virtual void require(bool holds, Text key, Text found, Text allowed) = 0;
  virtual std::size_t fault_count() const { return 0; }

  void number(Text key, double& value, Range range, Text help, const Fallback& fallback = {}) {
    option({key, &value, range, {}, 0, help, fallback});
  }
  template <class Int>
  void integer(Text key, Int& value, double low, double high, Text help, const Fallback& fallback = {}) {
    auto wide = static_cast<long long>(value);
    option({key, &wide, NumberRange::within(low, high, ""), {}, 0, help, fallback});
    value = static_cast<Int>(wide);
  }
  void boolean(Text key, bool& value, Text help) { option({key, &value, {}, {}, 0, help, {}}); }
  void text(Text key, std::string& value, Text help, const Fallback& fallback = {}) {
    option({key, &value, {}, {}, 0, help, fallback});
  }
  void choice(Text key, std::string& value, const std::vector<std::string>& choices, Text help,
              const Fallback& fallback = {}) {
    option({key, &value, {}, choices, 0, help, fallback});
  }
  template <class Value>
  void one_of(Text key, Value& value, const Names<Value>& names, Text help, const Fallback& fallback = {}) {
    std::string name;
    std::vector<std::string> choices;
    for (const auto& [known, meant] : names) {
      choices.push_back(known);
      if (meant == value) name = known;
    }
    choice(key, name, choices, help, fallback);
    for (const auto& [known, meant] : names)
      if (known == name) value = meant;
  }
  void numbers(Text key, std::vector<double>& values, Range range, std::size_t count, Text help,
               const Fallback& fallback = {}) {
    option({key, &values, range, {}, count, help, fallback});
  }
  void texts(Text key, std::vector<std::string>& values, Text help, const Fallback& fallback = {}) {
    option({key, &values, {}, {}, 0, help, fallback});
  }
  /// An array or Eigen vector: as many numbers as it has.
  template <class Vector>
  void vector(Text key, Vector& vector, Range range, Text help, const Fallback& fallback = {}) {
    std::vector<double> values(vector.begin(), vector.end());
    numbers(key, values, range, values.size(), help, fallback);
    std::copy(values.begin(), values.end(), vector.begin());
  }
  /// Options that have a `declare` of their own.
  template <class Options>
  void part(Text key, Options& options, const Fallback& fallback = {}) {
    map(key, fallback, [&] { declare(*this, options); });
  }
  /// `declare_it(key, value)` declares a value that may be missing.
  template <class Value, class Declare>
  void maybe(Text key, std::optional<Value>& value, const Declare& declare_it) {
    if (!present(key, value.has_value())) return;
    Value there = value.value_or(Value{});
    declare_it(key, there);
    value = there;
  }
  /// Whether nothing is wrong with what `body` declares.
  bool without_fault(const Body& body) {
    const std::size_t before = fault_count();
    body();
    return fault_count() == before;
  }
};

/// Reads the struct below a document's node; faults go to the document's list.
class OptionReader : public OptionVisitor {
 public:
  OptionReader(StrictYaml& yaml, YamlNode node) : yaml_(yaml), node_(std::move(node)) {}

  void option(const Option& option) override;
  void map(Text key, const Fallback& fallback, const Body& body) override;
  void list(Text key, std::size_t, const Fallback&, const Item& item) override;
  void entries(Text key, Text, const Entry& entry) override;
  bool present(Text key, bool) override { return node_.has(key); }
  void require(bool holds, Text key, Text found, Text allowed) override;
  std::size_t fault_count() const override { return yaml_.faults().faults().size(); }

 private:
  void below(const YamlNode& node, const Body& body);

  StrictYaml& yaml_;
  YamlNode node_;
};

/// Judges a struct that was made in code.
class OptionChecker : public OptionVisitor {
 public:
  OptionChecker(FaultList& faults, std::string place) : faults_(faults), place_(std::move(place)) {}

  void option(const Option& option) override;
  void map(Text key, const Fallback&, const Body& body) override { below(path(key), body); }
  void list(Text key, std::size_t count, const Fallback&, const Item& item) override;
  void entries(Text, Text, const Entry&) override {}
  bool present(Text, bool now) override { return now; }
  void require(bool holds, Text key, Text found, Text allowed) override;
  std::size_t fault_count() const override { return faults_.faults().size(); }

 protected:
  std::string path(Text key) const { return place_.empty() ? key : place_ + "." + key; }
  void below(std::string place, const Body& body);

 private:
  FaultList& faults_;
  std::string place_;
};

/// Adds a fault for every option that its declaration does not allow.
template <class Options>
void check_options(FaultList& faults, const std::string& place, Options options) {
  OptionChecker checker(faults, place);
  declare(checker, options);
}
/// Throws InputError with all of them.
template <class Options>
void check_options(const std::string& place, const Options& options) {
  FaultList faults;
  check_options(faults, place, options);
  faults.throw_if_any();
}

/// A line of the reference: "balls[].motion.speed_mps", "m/s", "required", "[0, 10]" and so on.
struct OptionRow {
  std::string path, unit, fallback, allowed, help;
  std::vector<std::string> conditions;  ///< under which it is known: "balls[].motion.type: rolling"
  Option option;                        ///< its value points nowhere
};

/// Lists every option there is, whatever the struct's values: all alternatives, one item of each list.
class OptionLister : public OptionChecker {
 public:
  OptionLister() : OptionChecker(none_, "") {}
  const std::vector<OptionRow>& rows() const { return rows_; }

  void option(const Option& option) override;
  void list(Text key, std::size_t, const Fallback&, const Item& item) override;
  void entries(Text key, Text example, const Entry& entry) override;
  bool present(Text, bool) override { return true; }
  void only_if(bool, Text condition, const Body& body) override;
  void require(bool, Text, Text, Text) override {}

 private:
  FaultList none_;
  std::vector<OptionRow> rows_;
  std::vector<std::string> conditions_;
};

/// A reference page of a `file` ("scenario") in Markdown, its columns aligned so that it is read as it is: a
/// table for each key of the top.
std::string option_page(const std::string& file, const std::vector<OptionRow>& rows);

/// Calls `use` with the number at a path ("noise.read") of a struct.
class NumberFinder : public OptionChecker {
 public:
  using Use = std::function<void(double& value, const Option& option)>;
  NumberFinder(std::string path, Use use)
      : OptionChecker(none_, ""), wanted_(std::move(path)), use_(std::move(use)) {}

  void option(const Option& option) override;
  bool present(Text key, bool now) override { return now || (wanted_ + ".").rfind(path(key) + ".", 0) == 0; }
  void require(bool, Text, Text, Text) override {}

 private:
  FaultList none_;
  std::string wanted_;
  Use use_;
};

}  // namespace ballservo
