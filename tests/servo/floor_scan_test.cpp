// What the camera sees standing on the floor, in the memory of free space.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "servo/avoidance/free_space.hpp"

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
FreeSpace open_space() {
  FreeSpace space{FreeSpaceOptions{}};
  space.move(0, {});
  for (int turn = 0; turn < 40; ++turn) {
    for (int twice = 0; twice < 2; ++twice) space.look({0, 3, 5.0, false}, {0, 0, 0.157 * turn});
  }
  return space;
}

void fire_ahead(FreeSpace& space) {
  for (int twice = 0; twice < 2; ++twice) {
    for (const double yaw : {-0.35, -0.17, 0.0}) space.look({0, 3, 5.0, false}, {0, 0, yaw});
  }
}

const FloorCell thing = FreeSpace::cell_at(1.2, 0.0), before = FreeSpace::cell_at(1.0, 0.0),
                beyond = FreeSpace::cell_at(1.6, 0.0), beside = FreeSpace::cell_at(1.15, 0.35);

TEST(FloorScan, WhatIsSeenTwiceStandsAndNoFiringFreesIt) {
  FreeSpace space = open_space();
  ASSERT_TRUE(space.is_free(thing));
  space.look_at_floor(scan_of(1.1, 1.4), {});
  EXPECT_TRUE(space.is_free(thing)) << "seen once: a glint, perhaps";
  space.look_at_floor(scan_of(1.1, 1.4), {});
  EXPECT_FALSE(space.is_free(thing));
  EXPECT_TRUE(space.is_suspected(thing));
  EXPECT_TRUE(space.is_standing(thing));
  fire_ahead(space);
  EXPECT_FALSE(space.is_free(thing)) << "it lies under the beam";
  for (int k = 0; k < 8; ++k) {
    space.look_at_floor(scan_of(1.1, 1.4), {});
    ASSERT_TRUE(space.is_standing(thing)) << "as long as it is seen";
  }
  for (const FloorCell& cell : {before, beyond, beside}) {
    EXPECT_TRUE(space.is_free(cell)) << cell.column << ' ' << cell.row;
    EXPECT_FALSE(space.is_suspected(cell));
  }
  EXPECT_TRUE(space.is_block_suspected(thing.column / FreeSpace::block, 0));
}

TEST(FloorScan, GlimpsesWithAScanBetweenThemAreNotTwoInARow) {
  for (int between = 1; between < 5; ++between) {
    FreeSpace space = open_space();
    for (int glimpse = 0; glimpse < 3; ++glimpse) {
      space.look_at_floor(scan_of(1.1, 1.4), {});
      EXPECT_FALSE(space.is_standing(thing)) << between;
      // Floor up to the thing, whose place this scan says nothing of.
      for (int k = 0; k < between; ++k) space.look_at_floor(scan_of(1.0, 1.0), {});
    }
    EXPECT_TRUE(space.is_free(thing)) << between;
  }
}

TEST(FloorScan, TheShieldsPlaceIsBlockedByIt) {
  FreeSpace space = open_space();
  const Pose2 there{0.9, 0, 0};
  ASSERT_TRUE(space.covers(pioneer_3dx_footprint, there, 0.02, FreeSpace::Drift::close, nullptr));
  for (int k = 0; k < 2; ++k) space.look_at_floor(scan_of(1.1, 1.2), {});
  EXPECT_FALSE(space.covers(pioneer_3dx_footprint, there, 0.02, FreeSpace::Drift::close, nullptr));
}

TEST(FloorScan, FloorThatIsSeenAgainAndTheBodyLiftIt) {
  FreeSpace space = open_space();
  for (int k = 0; k < 2; ++k) space.look_at_floor(scan_of(1.1, 1.4), {});
  for (int k = 0; k < 3; ++k) space.look_at_floor(scan_of(1.8, 1.8), {});
  EXPECT_FALSE(space.is_standing(thing));
  EXPECT_FALSE(space.is_suspected(thing));
  EXPECT_FALSE(space.is_free(thing)) << "the sonars have the word again";
  fire_ahead(space);
  EXPECT_TRUE(space.is_free(thing));
  EXPECT_FALSE(space.is_block_suspected(thing.column / FreeSpace::block, 0));

  for (int k = 0; k < 2; ++k) space.look_at_floor(scan_of(1.1, 1.4), {});
  ASSERT_TRUE(space.is_standing(thing));
  space.move(1, {1.2, 0, 0});
  EXPECT_TRUE(space.is_free(thing)) << "the body stands there";
}

TEST(FloorScan, IsPlacedByThePoseOfItsExposureAndTheCamera) {
  FreeSpace space = open_space();
  FloorScan scan = scan_of(1.0, 1.2);
  scan.camera_forward_m = 0.3;
  for (int k = 0; k < 2; ++k) space.look_at_floor(scan, {0.1, 0.2, M_PI / 2});
  EXPECT_TRUE(space.is_standing(FreeSpace::cell_at(0.1, 0.2 + 0.3 + 1.1)));
  EXPECT_FALSE(space.is_standing(FreeSpace::cell_at(0.1, 0.2 + 0.3 + 0.9)));
  EXPECT_FALSE(space.is_standing(thing));
}

TEST(FloorScan, OfWhatHidesTheFloorBeyondItHalfAMetreIsTakenToStand) {
  FreeSpace space = open_space();
  for (int k = 0; k < 2; ++k) space.look_at_floor(scan_of(0.8, 1.8), {});
  EXPECT_TRUE(space.is_standing(FreeSpace::cell_at(1.2, 0)));
  EXPECT_FALSE(space.is_standing(FreeSpace::cell_at(1.5, 0)));
}

TEST(FloorScan, SenselessOnesAreIgnored) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  FreeSpace space = open_space();
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
      for (int k = 0; k < 4; ++k) space.look_at_floor(scan, {});
    }
  }
  FloorScan scan = scan_of(1.1, 1.4);
  scan.count = FloorScan::max_rays + 1;
  for (int k = 0; k < 4; ++k) space.look_at_floor(scan, {});
  scan.count = 1;
  for (int k = 0; k < 4; ++k) space.look_at_floor(scan, {});
  EXPECT_TRUE(space.is_free(thing));
  EXPECT_FALSE(space.is_standing(thing));
}

}  // namespace
}  // namespace ballservo
