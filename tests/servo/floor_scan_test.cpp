// What the camera sees standing on the floor, in the occupancy grid.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "servo/avoidance/occupancy_grid.hpp"

namespace ballservo {
namespace {

/// A camera over the axle that sees 0.5 rad to each side from 0.4 to 1.8 m, and something from there to there
/// in the rays within 0.1 rad of straight ahead; nothing for 1.8.
FloorScan scan_of(double clear_m, double until_m) {
  FloorScan scan;
  scan.time_s = 0;
  for (scan.count = 0; scan.count < 51; ++scan.count) {
    const double bearing = 0.02 * (static_cast<double>(scan.count) - 25);
    const bool hit = std::abs(bearing) < 0.1;
    scan.rays[scan.count] = {bearing, 0.4, hit ? clear_m : 1.8, hit ? until_m : 1.8};
  }
  return scan;
}

/// All around is seen free by sonars that turned on the spot.
OccupancyGrid open_space() {
  OccupancyGrid grid{OccupancyGridOptions{}};
  grid.move(0, {});
  for (int turn = 0; turn < 40; ++turn) {
    for (int twice = 0; twice < 2; ++twice) grid.look({0, 3, 5.0, false}, {0, 0, 0.157 * turn});
  }
  return grid;
}

void fire_ahead(OccupancyGrid& grid) {
  for (int twice = 0; twice < 2; ++twice) {
    for (const double yaw : {-0.35, -0.17, 0.0}) grid.look({0, 3, 5.0, false}, {0, 0, yaw});
  }
}

const FloorCell thing = OccupancyGrid::cell_at(1.2, 0.0), before_thing = OccupancyGrid::cell_at(1.0, 0.0),
                beyond = OccupancyGrid::cell_at(1.6, 0.0), beside = OccupancyGrid::cell_at(1.15, 0.35);

TEST(FloorScan, WhatIsSeenTwiceStandsAndNoFiringFreesIt) {
  OccupancyGrid grid = open_space();
  ASSERT_TRUE(grid.is_free(thing));
  grid.look_at_floor(scan_of(1.1, 1.4), {});
  EXPECT_TRUE(grid.is_free(thing)) << "seen once: a glint, perhaps";
  grid.look_at_floor(scan_of(1.1, 1.4), {});
  EXPECT_FALSE(grid.is_free(thing));
  EXPECT_TRUE(grid.is_standing(thing));
  fire_ahead(grid);
  EXPECT_FALSE(grid.is_free(thing)) << "it lies under the beam";
  for (int k = 0; k < 8; ++k) {
    grid.look_at_floor(scan_of(1.1, 1.4), {});
    ASSERT_TRUE(grid.is_standing(thing)) << "as long as it is seen";
  }
  for (const FloorCell& cell : {before_thing, beyond, beside}) {
    EXPECT_TRUE(grid.is_free(cell)) << cell.column << ' ' << cell.row;
  }
}

TEST(FloorScan, GlimpsesWithAScanBetweenThemAreNotTwoInARow) {
  for (int between = 1; between < 5; ++between) {
    OccupancyGrid grid = open_space();
    for (int glimpse = 0; glimpse < 3; ++glimpse) {
      grid.look_at_floor(scan_of(1.1, 1.4), {});
      EXPECT_FALSE(grid.is_standing(thing)) << between;
      // Floor up to the thing, whose place this scan says nothing of.
      for (int k = 0; k < between; ++k) grid.look_at_floor(scan_of(1.0, 1.0), {});
    }
    EXPECT_TRUE(grid.is_free(thing)) << between;
  }
}

TEST(FloorScan, TheShieldsPlaceIsBlockedByIt) {
  OccupancyGrid grid = open_space();
  const Pose2 there{0.9, 0, 0};
  ASSERT_TRUE(grid.covers(pioneer_3dx_footprint, there, 0.02, OccupancyGrid::Drift::close));
  for (int k = 0; k < 2; ++k) grid.look_at_floor(scan_of(1.1, 1.2), {});
  EXPECT_FALSE(grid.covers(pioneer_3dx_footprint, there, 0.02, OccupancyGrid::Drift::close));
}

TEST(FloorScan, FloorThatIsSeenAgainAndTheBodyLiftIt) {
  OccupancyGrid grid = open_space();
  for (int k = 0; k < 2; ++k) grid.look_at_floor(scan_of(1.1, 1.4), {});
  for (int k = 0; k < 3; ++k) grid.look_at_floor(scan_of(1.8, 1.8), {});
  EXPECT_FALSE(grid.is_standing(thing));
  EXPECT_FALSE(grid.is_free(thing)) << "the sonars have the word again";
  fire_ahead(grid);
  EXPECT_TRUE(grid.is_free(thing));

  for (int k = 0; k < 2; ++k) grid.look_at_floor(scan_of(1.1, 1.4), {});
  ASSERT_TRUE(grid.is_standing(thing));
  grid.move(1, {1.2, 0, 0});
  EXPECT_TRUE(grid.is_free(thing)) << "the body stands there";
}

TEST(FloorScan, IsPlacedByThePoseOfItsExposureAndTheCamera) {
  OccupancyGrid grid = open_space();
  FloorScan scan = scan_of(1.0, 1.2);
  scan.camera_forward_m = 0.3;
  for (int k = 0; k < 2; ++k) grid.look_at_floor(scan, {0.1, 0.2, M_PI / 2});
  EXPECT_TRUE(grid.is_standing(OccupancyGrid::cell_at(0.1, 0.2 + 0.3 + 1.1)));
  EXPECT_FALSE(grid.is_standing(OccupancyGrid::cell_at(0.1, 0.2 + 0.3 + 0.9)));
  EXPECT_FALSE(grid.is_standing(thing));
}

TEST(FloorScan, OfWhatHidesTheFloorBeyondItHalfAMetreIsTakenToStand) {
  OccupancyGrid grid = open_space();
  for (int k = 0; k < 2; ++k) grid.look_at_floor(scan_of(0.8, 1.8), {});
  EXPECT_TRUE(grid.is_standing(OccupancyGrid::cell_at(1.2, 0)));
  EXPECT_FALSE(grid.is_standing(OccupancyGrid::cell_at(1.5, 0)));
}

TEST(FloorScan, SenselessOnesAreIgnored) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  OccupancyGrid grid = open_space();
  for (const double bad : {nan, inf, -inf, -1.0, 1e9}) {
    for (int field = 0; field < 4; ++field) {
      FloorScan scan = scan_of(1.1, 1.4);
      for (std::size_t k = 0; k < scan.count; ++k) {
        FloorRay& ray = scan.rays[k];
        (field == 0   ? ray.from_m
         : field == 1 ? ray.clear_m
         : field == 2 ? ray.until_m
                      : ray.bearing_rad) = bad;
      }
      for (int k = 0; k < 4; ++k) grid.look_at_floor(scan, {});
    }
  }
  FloorScan scan = scan_of(1.1, 1.4);
  scan.count = FloorScan::max_rays + 1;
  for (int k = 0; k < 4; ++k) grid.look_at_floor(scan, {});
  scan.count = 1;
  for (int k = 0; k < 4; ++k) grid.look_at_floor(scan, {});
  EXPECT_TRUE(grid.is_free(thing));
  EXPECT_FALSE(grid.is_standing(thing));
}

}  // namespace
}  // namespace ballservo
