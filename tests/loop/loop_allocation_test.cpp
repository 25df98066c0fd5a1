// The loop takes no memory from the heap once it runs, but for what its law takes.
#include <gtest/gtest.h>

#include "tests/loop/test_ports.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/counted_law.hpp"

namespace ballservo {
namespace {

TEST(LoopAllocation, FramesAndStepsTakeNothingFromTheHeap) {
  test::TestCamera camera;
  test::TestPerception perception;
  test::TestRobot robot;
  const ControllerOptions options;
  long by_the_law = 0, by_the_law_before = 0;
  Controller controller(options, std::make_unique<test::CountedLaw>("cone", options.goal, by_the_law));
  SteppedClock clock;
  long before = 0, after = 0;
  run_loop({camera, perception, robot, controller}, clock, [&](double time_s) {
    if (time_s < 1) {
      before = test::allocations();
      by_the_law_before = by_the_law;
    }
    after = test::allocations();
    return time_s < 5;
  });
  EXPECT_TRUE(robot.drove());
  EXPECT_EQ(after - before, by_the_law - by_the_law_before);
}

}  // namespace
}  // namespace ballservo
