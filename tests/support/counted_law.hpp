// A law whose use of the heap is counted apart: ViSP's vpServo allocates in every step.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "servo/control/law.hpp"
#include "servo/features/builtin_laws.hpp"
#include "tests/support/allocation_counter.hpp"

namespace ballservo::test {

/// Counts what the law takes apart from what the rest of the step takes.
class CountedLaw final : public Law {
 public:
  CountedLaw(const std::string& name, const ServoGoal& goal, long& taken)
      : law_(builtin_laws().make({name}, goal)), taken_(taken) {}
  std::optional<LawOutput> command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) override {
    const long before = allocations();
    const auto output = law_->command(p_CB, v_CB);
    taken_ += allocations() - before;
    return output;
  }

 private:
  std::unique_ptr<Law> law_;
  long& taken_;
};

}  // namespace ballservo::test
