#include <gtest/gtest.h>

#include <cmath>

#include "calibration/base/random.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {
namespace {

RollingMotion random_motion(RandomEngine& engine) {
  RollingMotion motion;
  const double heading = uniform(engine, -3.2, 3.2), speed = uniform(engine, 0.05, 2);
  motion.velocity_mps = speed * Eigen::Vector2d(std::cos(heading), std::sin(heading));
  motion.start_s = uniform(engine, 0, 3);
  motion.low_m = {-1, -2};
  motion.high_m = {3, 1};
  return motion;
}

TEST(RollingMotion, WithoutFrictionIsTheFoldedStraightWay) {
  RandomEngine engine = random_stream(1, "rolling");
  for (int i = 0; i < 500; ++i) {
    const RollingMotion motion = random_motion(engine);
    const Eigen::Vector2d start(uniform(engine, -1, 3), uniform(engine, -2, 1));
    const double t = uniform(engine, 0, 60);
    const Eigen::Vector2d p = motion.place(start, t);
    for (int k = 0; k < 2; ++k) {
      // A bounce mirrors the way: unfold it, roll straight, fold it again.
      const double width = motion.high_m[k] - motion.low_m[k];
      const double straight =
          start[k] - motion.low_m[k] + motion.velocity_mps[k] * std::max(0.0, t - motion.start_s);
      const double turn = straight - 2 * width * std::floor(straight / (2 * width));
      EXPECT_NEAR(p[k], motion.low_m[k] + (turn <= width ? turn : 2 * width - turn), 1e-9);
    }
  }
}

TEST(RollingMotion, LosesItsSpeedToFrictionAndBouncesAndStaysBetweenTheWalls) {
  RandomEngine engine = random_stream(2, "rolling");
  for (int i = 0; i < 300; ++i) {
    RollingMotion motion = random_motion(engine);
    motion.friction_mps2 = uniform(engine, 0.01, 0.3);
    motion.restitution = uniform(engine, 0.3, 1);
    const Eigen::Vector2d start(uniform(engine, -1, 3), uniform(engine, -2, 1));
    const double speed = motion.velocity_mps.norm(), dt = 0.02;
    double travelled = 0;
    Eigen::Vector2d last = start;
    for (double t = 0; t < motion.start_s + speed / motion.friction_mps2 + 1; t += dt) {
      const Eigen::Vector2d p = motion.place(start, t);
      EXPECT_TRUE((p.array() >= motion.low_m.array() - 1e-9).all() &&
                  (p.array() <= motion.high_m.array() + 1e-9).all());
      const double s = std::max(0.0, t - motion.start_s);
      EXPECT_LE((p - last).norm(), std::max(0.0, speed - motion.friction_mps2 * (s - dt)) * dt + 1e-9);
      travelled += (p - last).norm();
      last = p;
    }
    EXPECT_LE(travelled, speed * speed / (2 * motion.friction_mps2) + 1e-6);
    EXPECT_EQ(last, motion.place(start, 1e6));
  }
}

TEST(RollingMotion, EndsInCornersAndWithoutRoom) {
  RollingMotion motion;
  motion.velocity_mps = {1, 1};
  motion.low_m = {0, 0};
  motion.high_m = {1, 1};
  EXPECT_NEAR((motion.place({0.5, 0.5}, 1) - Eigen::Vector2d(0.5, 0.5)).norm(), 0, 1e-12);
  motion.high_m = {0, 0};
  EXPECT_TRUE(motion.place({0, 0}, 1e9).allFinite());
  motion.velocity_mps = {0, 0};
  EXPECT_EQ(motion.place({0.2, 0.3}, 5), Eigen::Vector2d(0.2, 0.3));
}

}  // namespace
}  // namespace ballservo
