// The laws that exist in a program, by name.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "servo/control/law.hpp"

namespace ballservo {

/// A value: a program copies the catalog of builtin_laws(), adds laws of its own, and hands it to whatever
/// reads a law's name.
class LawCatalog {
 public:
  /// Makes a law for options and goal that have been checked; throws InputError where the law cannot serve
  /// that goal.
  using Factory = std::function<std::unique_ptr<Law>(const LawOptions&, const ServoGoal&)>;

  /// Adds a law, or replaces the one of that name.
  void add(const std::string& name, Factory factory);

  /// In the order in which they were added.
  std::vector<std::string> names() const;

  /// The law named options.name. Throws InputError with every fault of options and goal, and where no law of
  /// that name exists.
  std::unique_ptr<Law> make(const LawOptions& options, const ServoGoal& goal) const;

 private:
  std::vector<std::pair<std::string, Factory>> laws_;
};

}  // namespace ballservo
