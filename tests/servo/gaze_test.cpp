// A pan that keeps its camera on the ball.
#include "servo/control/gaze.hpp"

#include <gtest/gtest.h>
#include <visp3/core/vpVelocityTwistMatrix.h>
#include <visp3/vs/vpServo.h>

#include <cmath>

#include "calibration/base/random.hpp"
#include "servo/features/ball_feature.hpp"

namespace ballservo {
namespace {

constexpr double gain_per_s = 6, aside_max_rad = 0.3;

CameraMount panning_mount(double max_rad) { return {0.10, 0.28, 0.21, {max_rad, 3, 12}}; }

vpHomogeneousMatrix to_visp(const Eigen::Isometry3d& X) {
  vpHomogeneousMatrix M;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) M[row][column] = X.matrix()(row, column);
  return M;
}

/// The pan's speed as ViSP's task has it: the azimuth in the turned camera, and what the drive does to it.
double by_visp(const CameraMount& mount, double pan_rad, const Eigen::Vector3d& p_RB, const Twist2& twist) {
  const Eigen::Isometry3d X_CR = mount.X_RC(pan_rad).inverse();
  ConeFeature seen(mount.X_RC().linear()), desired = seen;
  seen.buildFrom(X_CR * p_RB);
  const double aside_rad = std::copysign(aside_max_rad, p_RB.y());
  desired.buildFrom(mount.X_RC().inverse() *
                    Eigen::Vector3d(mount.forward_m + std::cos(aside_rad), std::sin(aside_rad), 0));
  vpServo task;
  task.setServo(vpServo::EYEINHAND_L_cVe_eJe);
  task.setInteractionMatrixType(vpServo::CURRENT, vpServo::PSEUDO_INVERSE);
  task.setLambda(gain_per_s);
  task.addFeature(seen, desired, vpBasicFeature::FEATURE_LINE[1]);
  const vpVelocityTwistMatrix cVe(to_visp(X_CR));
  task.set_cVe(cVe);
  vpMatrix of_pan(6, 1), of_drive(6, 2);
  of_pan[1][0] = -mount.forward_m;  // a turn about the camera, at the axle
  of_pan[5][0] = of_drive[0][0] = of_drive[5][1] = 1;
  task.set_eJe(of_pan);
  double speed = task.computeControlLaw()[0];
  vpColVector u(2);
  u[0] = twist.v_mps, u[1] = twist.w_radps;
  const vpMatrix L = seen.interaction(vpBasicFeature::FEATURE_LINE[1]);
  speed -= (L * cVe * of_drive * u)[0] / (L * cVe * of_pan)[0][0];
  task.kill();
  return speed;
}

TEST(Gaze, IsTheTaskOfViSPOnTheAzimuth) {
  RandomEngine engine = random_stream(0, "gaze test");
  for (int round = 0; round < 300; ++round) {
    const CameraMount mount = panning_mount(3);
    const double side = round % 2 == 0 ? 1 : -1, range_m = uniform(engine, 0.5, 4);
    const double azimuth = side * uniform(engine, 0.31, 1.5);
    const double pan_rad = azimuth - side * aside_max_rad + uniform(engine, -0.1, 0.1);
    const Eigen::Vector3d p_RB(mount.forward_m + range_m * std::cos(azimuth), range_m * std::sin(azimuth),
                               0.06);
    const Twist2 twist{uniform(engine, -0.3, 0.6), uniform(engine, -0.6, 0.6)};
    Gaze gaze(mount, aside_max_rad, 0, 8);
    const double speed = gaze.follow(0, {pan_rad, 0}, {p_RB.head<2>(), {0, 0}}, twist);
    EXPECT_NEAR(speed, by_visp(mount, pan_rad, p_RB, twist), 1e-9) << round;
  }
}

TEST(Gaze, LooksAheadWhileTheBallIsWellInsideThePicture) {
  Gaze gaze(panning_mount(3), aside_max_rad, 0, 8);
  EXPECT_EQ(gaze.follow(0, {}, {{1, 0.2}, {0, 0}}, {0.5, 0.5}), 0);
  EXPECT_LT(gaze.follow(0.02, {0.1, 0}, {{1, 0.2}, {0, 0}}, {0.5, 0.5}), 0);
}

TEST(Gaze, BrakesBeforeItsStopsHoweverFastTheBallPasses) {
  const CameraMount mount = panning_mount(1);
  const double way_rad = 0.01, brakes_radps = std::sqrt(2 * mount.pan.acceleration_max_radps2 * way_rad);
  Gaze gaze(mount, 0, 0, 8);
  const double speed = gaze.follow(0, {1 - way_rad, 0}, {{0.6, 0.8}, {-2, 2}}, {});
  EXPECT_GT(speed, 0);
  EXPECT_LT(speed, brakes_radps);
  EXPECT_EQ(gaze.follow(0.02, {-2, 0}, {{0.6, -0.8}, {0, 0}}, {}), mount.pan.speed_max_radps)
      << "back from beyond";
}

TEST(Gaze, WithoutAPanOrANumberNothingTurns) {
  Gaze fixed(panning_mount(0), aside_max_rad, 0.05, 8), blind(panning_mount(1), aside_max_rad, 0.05, 8);
  EXPECT_EQ(fixed.follow(0, {}, {{1, 1}, {0, 0}}, {}), 0);
  EXPECT_EQ(fixed.scan(0.02, {}), 0);
  const double nan = std::nan("");
  EXPECT_EQ(blind.follow(0, {nan, 0}, {{1, 1}, {0, 0}}, {}), 0);
  EXPECT_TRUE(std::isfinite(blind.follow(0.02, {}, {{nan, 1}, {0, 0}}, {})));
  EXPECT_TRUE(std::isfinite(blind.follow(0.04, {}, {{0.10, 0}, {0, 0}}, {})));
}

}  // namespace
}  // namespace ballservo
