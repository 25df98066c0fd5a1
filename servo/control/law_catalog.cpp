#include "servo/control/law_catalog.hpp"

#include <algorithm>

#include "calibration/base/options.hpp"

namespace ballservo {

void LawCatalog::add(const std::string& name, Factory factory) {
  for (auto& [known, its_factory] : laws_) {
    if (known != name) continue;
    its_factory = std::move(factory);
    return;
  }
  laws_.emplace_back(name, std::move(factory));
}

std::vector<std::string> LawCatalog::names() const {
  std::vector<std::string> names;
  for (const auto& [name, factory] : laws_) names.push_back(name);
  return names;
}

std::unique_ptr<Law> LawCatalog::make(const LawOptions& options, const ServoGoal& goal) const {
  const auto found =
      std::find_if(laws_.begin(), laws_.end(), [&](const auto& law) { return law.first == options.name; });
  FaultList faults;
  OptionChecker checker(faults, "law");
  LawOptions law = options;
  declare(checker, law, names());
  check_options(faults, "target", goal);
  faults.throw_if_any();
  return found->second(options, goal);
}

}  // namespace ballservo
