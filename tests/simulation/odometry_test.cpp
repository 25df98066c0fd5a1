#include <gtest/gtest.h>

#include <cmath>

#include "servo/simulation/robot/unicycle_robot.hpp"

namespace ballservo {
namespace {

const OdometryBound bound{0.01, 0.02, 0.01};

TEST(Odometry, WithoutABoundItIsExact) {
  Odometry odometry({}, {1, 2, 0.5}, 3);
  const Pose2 there = integrate({1, 2, 0.5}, {0.7, 1.1}, 1.0);
  odometry.move(there);
  EXPECT_EQ(odometry.pose().x_m, there.x_m);
  EXPECT_EQ(odometry.pose().yaw_rad, there.yaw_rad);
}

/// A random way, and how far a resting point that was seen at its start is from where odometry puts it.
void drive_randomly(double excess, std::uint64_t seed, double& worst_share, double& drift_m) {
  OdometryOptions options{bound, excess};
  Pose2 pose{0.3, -0.2, 0.4};
  Odometry odometry(options, pose, seed);
  const Pose2 start = pose, believed_start = odometry.pose();
  RandomEngine engine = random_stream(seed, "way");
  const Eigen::Vector2d p_R0(uniform(engine, -3, 3), uniform(engine, -3, 3));
  const Eigen::Vector2d p_W = in_world_frame(start, p_R0), p_O = in_world_frame(believed_start, p_R0);
  double path_m = 0, turn_rad = 0, v = 0, w = 0;
  for (int k = 0; k < 600; ++k) {
    if (k % 40 == 0) {
      v = uniform(engine, -0.5, 1.0);
      w = uniform(engine, -1, 1);
    }
    pose = integrate(pose, {v, w}, 0.02);
    path_m += std::abs(v) * 0.02;
    turn_rad += std::abs(w) * 0.02;
    odometry.move(pose);
    const Eigen::Vector2d truly = in_robot_frame(pose, p_W), believed = in_robot_frame(odometry.pose(), p_O);
    drift_m = (truly - believed).norm();
    // The bound is stated in what odometry itself measures: a hundredth or two of difference.
    worst_share =
        std::max(worst_share, drift_m / (1.03 * bound.point_error_m(path_m, turn_rad, truly.norm())));
  }
}

TEST(Odometry, ErrorsStayWithinTheBoundThatIsStated) {
  double worst_share = 0, total_drift_m = 0, drift_m = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    drive_randomly(1, seed, worst_share, drift_m);
    total_drift_m += drift_m;
  }
  EXPECT_LE(worst_share, 1.0);
  EXPECT_GT(worst_share, 0.3) << "a bound that is never approached says nothing";
  EXPECT_GT(total_drift_m / 200, 0.02);
}

TEST(Odometry, AnExcessBreaksTheBound) {
  double worst_share = 0, drift_m = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) drive_randomly(4, seed, worst_share, drift_m);
  EXPECT_GT(worst_share, 1.0);
}

TEST(Odometry, IsTheSeedsOwn) {
  double share = 0, a = 0, b = 0, c = 0;
  drive_randomly(1, 7, share, a);
  drive_randomly(1, 7, share, b);
  drive_randomly(1, 8, share, c);
  EXPECT_EQ(a, b);
  EXPECT_NE(a, c);
}

}  // namespace
}  // namespace ballservo
