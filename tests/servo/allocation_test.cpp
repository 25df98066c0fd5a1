// After warm-up a control step takes no memory from the heap, but for what its law takes. Counted below
// operator new, where Eigen and the C library allocate too.
#include <gtest/gtest.h>

#include "servo/control/controller.hpp"
#include "servo/features/builtin_laws.hpp"
#include "tests/support/allocation_counter.hpp"

namespace ballservo {
namespace {

/// Counts what the law takes apart from what the rest of the step takes.
class CountedLaw final : public Law {
 public:
  CountedLaw(const std::string& name, const ServoGoal& goal, long& taken)
      : law_(builtin_laws().make({name}, goal)), taken_(taken) {}
  std::optional<LawOutput> command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) override {
    const long before = test::allocations();
    const auto output = law_->command(p_CB, v_CB);
    taken_ += test::allocations() - before;
    return output;
  }

 private:
  std::unique_ptr<Law> law_;
  long& taken_;
};

struct Allocations {
  long by_the_law = 0, by_the_rest = 0;
};

Allocations allocations_of_run(const std::string& law, AvoidanceOptions::Type avoidance = {}) {
  ControllerOptions options;
  options.avoidance.type = avoidance;
  Allocations taken;
  Controller controller(options, std::make_unique<CountedLaw>(law, options.goal, taken.by_the_law));
  long before = 0;
  for (int k = 0; k < 1500; ++k) {
    if (k == 300) {
      before = test::allocations();
      taken.by_the_law = 0;
    }
    BallMeasurement frame;
    frame.time_s = 0.02 * k;
    // Seen, lost, seen again; frames missing altogether for a while.
    frame.state = k % 400 < 300 ? TrackState::confirmed : TrackState::none;
    frame.p_CB = {0.3, 0.1, 3.0};
    frame.covariance_m2 = 1e-4 * Eigen::Matrix3d::Identity();
    if (k % 700 < 650) controller.see(frame);
    // Echoes all around, near ones in between; the robot moves on.
    const auto transducer = static_cast<std::size_t>(k % 16);
    controller.hear({0.02 * k - 0.03, transducer, k % 37 < 20 ? 1.2 : 2.5, true});
    // Something on the floor, which comes and goes.
    FloorScan scan;
    scan.time_s = 0.02 * k;
    scan.camera_forward_m = 0.1;
    for (scan.count = 0; scan.count < FloorScan::max_rays; ++scan.count) {
      const double clear_m = k % 50 < 25 && scan.count > 20 ? 0.9 : 1.8;
      scan.rays[scan.count] = {0.02 * static_cast<double>(scan.count) - 0.64, 0.4, clear_m, 1.8};
    }
    controller.see(scan);
    controller.step(0.02 * k, {0.002 * k, 0.0, 0.0}, {0.1, 0.0});
  }
  taken.by_the_rest = test::allocations() - before - taken.by_the_law;
  return taken;
}

TEST(Allocation, ControlStepTakesNoMemory) { EXPECT_EQ(allocations_of_run("cone").by_the_rest, 0); }

TEST(Allocation, NorDoesOneAmongObstacles) {
  EXPECT_EQ(allocations_of_run("cone", AvoidanceOptions::Type::full).by_the_rest, 0);
}

TEST(Allocation, TheCounterCounts) { EXPECT_GT(allocations_of_run("visp").by_the_law, 0); }

}  // namespace
}  // namespace ballservo
