#include "servo/avoidance/occupancy_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ballservo {
namespace {

OccupancyGridOptions without_start() {
  OccupancyGridOptions options;
  options.start_clear_m = 0;
  return options;
}

/// The same transducer fires twice: one look alone is not believed.
void look_twice(OccupancyGrid& grid, std::size_t transducer, double range_m, double time_s,
                const Pose2& pose = {}) {
  for (int k = 0; k < 2; ++k) grid.look({time_s, transducer, range_m, range_m < 5.0}, pose);
}

TEST(OccupancyGrid, UnknownIsNotFree) {
  OccupancyGrid grid(without_start());
  grid.move(0, {});
  for (int column = -140; column < 140; column += 7) {
    for (int row = -140; row < 140; row += 7) EXPECT_FALSE(grid.is_free({column, row}));
  }
}

TEST(OccupancyGrid, ARangeAtTheLeastFreesNothing) {
  for (const double over_m : {0.0, 0.01}) {
    OccupancyGridOptions options = without_start();
    options.beam.min_range_m = 0.4;
    OccupancyGrid grid(options);
    grid.move(0, {});
    look_twice(grid, 3, 0.4 + over_m, 0);
    EXPECT_EQ(grid.is_free(OccupancyGrid::cell_at(0.45, 0.07)), over_m > 0) << "what is nearer reads so, too";
  }
}

TEST(OccupancyGrid, ACellIsFreeExactlyWhenTheConeHoldsAllOfIt) {
  for (std::size_t k = 0; k < sonar_count; ++k) {
    for (const double yaw : {0.4, -2.2}) {
      const OccupancyGridOptions options = without_start();
      OccupancyGrid grid(options);
      const Pose2 pose{0.3, -0.2, yaw};
      grid.move(0, pose);
      look_twice(grid, k, 1.4, 0, pose);
      const SonarMount& mount = pioneer_3dx_sonars[k];
      const Eigen::Vector2d apex = in_world_frame(pose, {mount.x_m, mount.y_m});
      const double half = options.beam.half_angle_rad - OccupancyGrid::angle_error_rad;
      const auto holds = [&](double x, double y, double slack) {
        const double dx = x - apex.x(), dy = y - apex.y(), range = std::hypot(dx, dy);
        const double off = wrap_angle(std::atan2(dy, dx) - yaw - mount.heading_rad);
        return range <= 1.4 - options.range_error_m + slack &&
               range * std::sin(std::abs(off) - half) <= slack && std::abs(off) < 1.5;
      };
      int free = 0;
      for (int column = -80; column < 80; ++column) {
        for (int row = -80; row < 80; ++row) {
          bool all = true, nearly_all = true;
          for (const int i : {0, 1}) {
            for (const int j : {0, 1}) {
              const double x = (column + i) * OccupancyGrid::cell_m, y = (row + j) * OccupancyGrid::cell_m;
              all = all && holds(x, y, 1e-9);
              nearly_all = nearly_all && holds(x, y, -1e-9);
            }
          }
          if (grid.is_free({column, row})) {
            EXPECT_TRUE(all) << k << ' ' << column << ' ' << row;
            ++free;
          } else {
            EXPECT_FALSE(nearly_all) << k << ' ' << column << ' ' << row;
          }
        }
      }
      EXPECT_GT(free, 200) << k;
    }
  }
}

TEST(OccupancyGrid, OneLookAloneIsNotBelieved) {
  OccupancyGrid grid(without_start());
  grid.move(0, {});
  grid.look({0, 3, 0.5, true}, {});
  grid.look({0.32, 3, 5.0, false}, {});  // the echo is missed once
  const FloorCell behind = OccupancyGrid::cell_at(1.0, 0.2);
  EXPECT_FALSE(grid.is_free(behind));
  grid.look({0.64, 3, 5.0, false}, {});
  EXPECT_TRUE(grid.is_free(behind));
}

TEST(OccupancyGrid, IsForgottenWithTheWayAndTheTurnButNotWhileTheRobotRests) {
  OccupancyGridOptions options = without_start();
  options.odometry = {0.01, 0.01, 0.005};
  const auto seen = [&options](double path_m, double turn_rad, double rest_s) {
    OccupancyGrid grid(options);
    grid.move(0, {});
    look_twice(grid, 3, 1.5, 0);
    double time_s = rest_s;
    grid.move(time_s, {});
    for (int k = 1; k <= 100; ++k) {
      // There and back, so that the cell stays where it was.
      const double there = k <= 50 ? k / 50.0 : 2 - k / 50.0;
      grid.move(time_s += 0.02, {-0.5 * path_m * there, 0, 0.5 * turn_rad * there});
    }
    return grid.is_free(OccupancyGrid::cell_at(0.8, 0.12));
  };
  EXPECT_TRUE(seen(0, 0, 1000));
  EXPECT_TRUE(seen(1.0, 0, 0));
  EXPECT_FALSE(seen(3.0, 0, 0));
  EXPECT_TRUE(seen(0, 3.0, 0));
  EXPECT_FALSE(seen(0, 9.0, 0));
  options.memory_s = 1.0;
  EXPECT_FALSE(seen(0.1, 0, 0)) << "two seconds in motion";
}

TEST(OccupancyGrid, AnEchoAmidFreeSpaceTakesItBackAndOneThatIsExplainedDoesNot) {
  OccupancyGrid grid(without_start());
  grid.move(0, {});
  for (const double yaw : {-0.15, 0.0, 0.15}) look_twice(grid, 3, 2.0, 0, {0, 0, yaw});
  const FloorCell middle = OccupancyGrid::cell_at(1.15, 0.2);
  ASSERT_TRUE(grid.is_free(middle));
  // Something has come: the whole arc lies in free space.
  const double range_m = std::hypot(1.15 - 0.166, 0.2 - 0.027);
  grid.look({1, 3, range_m, true}, {});
  EXPECT_TRUE(grid.is_free(middle)) << "heard once: perhaps another's ping";
  grid.look({1.32, 3, range_m - 0.01, true}, {});
  grid.look({1.64, 3, range_m, true}, {});
  EXPECT_FALSE(grid.is_free(middle));
  // It is gone again.
  look_twice(grid, 3, 2.0, 2);
  EXPECT_TRUE(grid.is_free(middle));
  // Transducer 2 looks aside, where much is unknown: its echo need not come from there.
  look_twice(grid, 2, 1.0, 3);
  EXPECT_TRUE(grid.is_free(middle));
}

// An echo takes free space back beside and under the body's edge: the robot may still leave.
TEST(OccupancyGrid, WhatWasTakenBackUnderTheBodysEdgeMayBeCreptAwayFrom) {
  const OccupancyGridOptions options;
  OccupancyGrid grid(options);
  const Pose2 here{}, ahead{0.01, 0, 0}, turned_towards_it{0, 0, 0.05};
  grid.move(0, here);
  const auto covers = [&](const Pose2& pose, const Pose2* from) {
    return grid.covers(options.footprint, pose, 0.02, OccupancyGrid::Drift::allowed, from);
  };
  ASSERT_TRUE(covers(ahead, nullptr));
  look_twice(grid, 0, 0.105, 0);  // 3 cm from the left side
  EXPECT_FALSE(grid.is_free(OccupancyGrid::cell_at(0.07, 0.22)));
  EXPECT_FALSE(covers(ahead, nullptr));
  EXPECT_TRUE(covers(ahead, &here));
  EXPECT_FALSE(covers(turned_towards_it, &here));
}

TEST(OccupancyGrid, CoversNothingBeyondItsWindow) {
  OccupancyGridOptions options;
  options.start_clear_m = 3;
  OccupancyGrid grid(options);
  grid.move(0, {});
  constexpr double window_m = OccupancyGrid::size * OccupancyGrid::cell_m;
  const auto covers = [&](double x_m) {
    return grid.covers(pioneer_3dx_footprint, {x_m, 0, 0}, 0.02, OccupancyGrid::Drift::close);
  };
  EXPECT_TRUE(covers(-2));
  EXPECT_FALSE(covers(window_m - 2)) << "a ring buffer must not answer for the other side";
}

TEST(OccupancyGrid, NeverAnswersForWhatLeftItsWindow) {
  OccupancyGrid grid(OccupancyGridOptions{});
  grid.move(0, {});
  const FloorCell start = OccupancyGrid::cell_at(0.1, 0.1);
  EXPECT_TRUE(grid.is_free(start));
  for (int k = 1; k <= 100; ++k) grid.move(0.02 * k, {0.1 * k, 0.05 * k, 0});
  EXPECT_FALSE(grid.in_window(start));
  EXPECT_FALSE(grid.is_free(start));
  for (int k = 99; k >= 0; --k) grid.move(4 - 0.02 * k, {0.1 * k, 0.05 * k, 0});
  EXPECT_TRUE(grid.in_window({60, 60}));
  EXPECT_FALSE(grid.is_free({60, 60})) << "a ring buffer must not remember another round";
}

}  // namespace
}  // namespace ballservo
