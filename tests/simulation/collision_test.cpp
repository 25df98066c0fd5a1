#include "servo/simulation/world/collision.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/simulation/dark_room.hpp"

namespace ballservo {
namespace {

const Footprint footprint = pioneer_3dx_footprint;

World with(const Shape& shape, const Eigen::Vector3d& center, double yaw_rad = 0) {
  World world = test::dark_room();
  Obstacle obstacle;
  obstacle.name = "thing";
  obstacle.shape = shape;
  obstacle.center_m = center;
  obstacle.yaw_rad = yaw_rad;
  world.obstacles = {obstacle};
  return world;
}

double clearance(const World& world, const Pose2& pose = {}) {
  return find_contacts(world, footprint, pose, 0).clearance_m;
}

TEST(Contacts, DistancesAheadAndAsideAreThoseOfTheRectangle) {
  EXPECT_NEAR(clearance(with(CylinderShape{0.1, 0.5}, {1, 0, 0.25})), 1 - 0.1 - 0.210, 1e-12);
  EXPECT_NEAR(clearance(with(CylinderShape{0.1, 0.5}, {-1, 0, 0.25})), 1 - 0.1 - 0.301, 1e-12);
  EXPECT_NEAR(clearance(with(CylinderShape{0.1, 0.5}, {0, 1, 0.25})), 1 - 0.1 - 0.2125, 1e-12);
  EXPECT_NEAR(clearance(with(BoxShape{{0.2, 0.4, 0.3}}, {1, 0, 0.15})), 1 - 0.1 - 0.210, 1e-12);
  EXPECT_NEAR(clearance(with(BoxShape{{0.2, 0.4, 0.3}}, {1, 0, 0.15}, M_PI / 2)), 1 - 0.2 - 0.210, 1e-12);
  EXPECT_NEAR(clearance(with(BoxShape{{0.2, 0.2, 0.3}}, {1, 0, 0.15}, M_PI / 4)), 1 - 0.1 * M_SQRT2 - 0.210,
              1e-12);
}

TEST(Contacts, ACornerNearAnEdgeIsFree) {
  // Only the robot's edge lies between the two: the box's own edges all cut through the robot's corners.
  EXPECT_NEAR(clearance(with(BoxShape{{0.2, 0.2, 0.3}}, {0.210 + 0.1 * M_SQRT2 + 0.02, 0, 0.15}, M_PI / 4)),
              0.02, 1e-12);
}

TEST(Contacts, TurningRobotAndWorldTogetherChangesNothing) {
  const double yaw = 0.7, c = std::cos(yaw), s = std::sin(yaw);
  for (double angle = 0; angle < 6.28; angle += 0.3) {
    const Eigen::Vector3d p(0.8 * std::cos(angle), 0.8 * std::sin(angle), 0.15);
    const Eigen::Vector3d q(c * p.x() - s * p.y() + 1, s * p.x() + c * p.y() - 2, 0.15);
    EXPECT_NEAR(clearance(with(BoxShape{{0.2, 0.3, 0.3}}, p, angle)),
                clearance(with(BoxShape{{0.2, 0.3, 0.3}}, q, angle + yaw), {1, -2, yaw}), 1e-9);
  }
}

TEST(Contacts, TouchingIsACollisionAndAMillimetreLessIsNot) {
  EXPECT_FALSE(
      find_contacts(with(BoxShape{{0.2, 0.2, 0.3}}, {0.311, 0, 0.15}), footprint, {}, 0).collision());
  EXPECT_TRUE(find_contacts(with(BoxShape{{0.2, 0.2, 0.3}}, {0.309, 0, 0.15}), footprint, {}, 0).collision());
  EXPECT_TRUE(find_contacts(with(BoxShape{{0.05, 0.05, 0.3}}, {0, 0, 0.15}), footprint, {}, 0).collision());
  EXPECT_TRUE(find_contacts(with(BoxShape{{5, 0.01, 0.3}}, {0, 0, 0.15}), footprint, {}, 0).collision());
}

TEST(Contacts, RobotDrivesUnderWhatHangsHigh) {
  EXPECT_GT(clearance(with(BoxShape{{1, 1, 0.2}}, {0, 0, 1.5})), 1);
}

TEST(Contacts, WallsCountFromTheNearestCorner) {
  World world = test::dark_room();
  EXPECT_NEAR(clearance(world, {19, 0, 0}), 1 - 0.210, 1e-12);
  EXPECT_NEAR(clearance(world, {19, 0, M_PI}), 1 - 0.301, 1e-12);
  const double corner = std::hypot(0.301, 0.2125);
  EXPECT_NEAR(clearance(world, {19, 0, M_PI + std::atan2(0.2125, 0.301)}), 1 - corner, 1e-9);
  EXPECT_TRUE(find_contacts(world, footprint, {19.9, 0, 0}, 0).collision());
}

TEST(Contacts, BallsAreCountedApartAndWhereTheyAreThen) {
  World world = test::dark_room();
  Ball ball = test::white_ball({2, 0, 0.06}, 0.12);
  LinearMotion motion;
  motion.velocity_mps = {-1, 0};
  ball.motion = motion;
  world.balls = {ball};
  EXPECT_NEAR(find_contacts(world, footprint, {}, 0).ball_clearance_m, 2 - 0.06 - 0.210, 1e-12);
  EXPECT_NEAR(find_contacts(world, footprint, {}, 1).ball_clearance_m, 1 - 0.06 - 0.210, 1e-12);
  const ContactReport hit = find_contacts(world, footprint, {}, 1.8);
  EXPECT_TRUE(hit.ball_contact());
  EXPECT_FALSE(hit.collision());
}

}  // namespace
}  // namespace ballservo
