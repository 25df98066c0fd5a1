// The loop takes no memory from the heap once it runs.
#include <gtest/gtest.h>

#include "tests/loop/test_ports.hpp"
#include "tests/support/allocation_counter.hpp"

namespace ballservo {
namespace {

TEST(LoopAllocation, FramesAndStepsTakeNothingFromTheHeap) {
  test::TestCamera camera;
  test::TestPerception perception;
  test::TestRobot robot;
  Controller controller = test::test_controller();
  SteppedClock clock;
  long before = 0, after = 0;
  run_loop({camera, perception, robot, controller}, clock, [&](double time_s) {
    if (time_s < 1) before = test::allocations();
    after = test::allocations();
    return time_s < 5;
  });
  EXPECT_TRUE(robot.drove());
  EXPECT_EQ(after - before, 0);
}

}  // namespace
}  // namespace ballservo
