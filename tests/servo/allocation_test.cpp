// After warm-up a control step takes no memory from the heap, but for what its law takes. Counted below
// operator new, where Eigen and the C library allocate too.
#include <gtest/gtest.h>

#include "servo/control/controller.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/counted_law.hpp"

namespace ballservo {
namespace {

struct Allocations {
  long by_the_law = 0, by_the_rest = 0;
};

Allocations allocations_of_run(const std::string& law, AvoidanceOptions::Type avoidance = {}) {
  ControllerOptions options;
  options.avoidance.type = avoidance;
  Allocations taken;
  Controller controller(options, std::make_unique<test::CountedLaw>(law, options.goal, taken.by_the_law));
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
