#include "servo/simulation/robot/unicycle_robot.hpp"

#include <gtest/gtest.h>
#include <visp3/robot/vpSimulatorPioneer.h>

#include <cmath>
#include <limits>

#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

const UnicycleLimits quick{1e3, 1e3, 1e9, 1e9};  // a drive without limits to speak of

TEST(Unicycle, ArcsAreExactAndReversible) {
  // A quarter of a circle of radius 1 m.
  const Pose2 end = integrate({1, 2, 0}, {1, 1}, M_PI / 2);
  EXPECT_NEAR(end.x_m, 2, 1e-12);
  EXPECT_NEAR(end.y_m, 3, 1e-12);
  EXPECT_NEAR(end.yaw_rad, M_PI / 2, 1e-12);
  for (const double w : {0.0, 1e-7, 1e-4, 0.3, -2.0}) {
    const Pose2 there = integrate({0.3, -0.2, 0.9}, {0.7, w}, 1.3);
    const Pose2 back = integrate(there, {0.7, w}, -1.3);
    EXPECT_NEAR(back.x_m, 0.3, 1e-12);
    EXPECT_NEAR(back.y_m, -0.2, 1e-12);
    // In two halves as in one.
    const Pose2 halves = integrate(integrate({0.3, -0.2, 0.9}, {0.7, w}, 0.65), {0.7, w}, 0.65);
    EXPECT_NEAR(halves.x_m, there.x_m, 1e-12);
    EXPECT_NEAR(halves.y_m, there.y_m, 1e-12);
  }
}

TEST(Unicycle, WrappedAnglesLieInOneTurn) {
  for (double angle = -20; angle < 20; angle += 0.37) {
    const double wrapped = wrap_angle(angle);
    EXPECT_GT(wrapped, -M_PI);
    EXPECT_LE(wrapped, M_PI);
    EXPECT_NEAR(std::cos(wrapped - angle), 1, 1e-12);
  }
  EXPECT_EQ(wrap_angle(-M_PI), wrap_angle(M_PI));
}

TEST(Unicycle, SaturationKeepsTheCurvature) {
  const UnicycleLimits limits;
  for (const Twist2 command : {Twist2{3, 1}, Twist2{0.5, 9}, Twist2{-4, 20}}) {
    const Twist2 limited = limit_speed(command, limits);
    EXPECT_NEAR(limited.w_radps * command.v_mps, command.w_radps * limited.v_mps, 1e-12);
    EXPECT_LE(std::abs(limited.v_mps), limits.v_max_mps + 1e-12);
    EXPECT_LE(std::abs(limited.w_radps), limits.w_max_radps + 1e-12);
    const Twist2 first = limit_acceleration({0, 0}, command, limits, 0.02);
    EXPECT_NEAR(first.w_radps * command.v_mps, command.w_radps * first.v_mps, 1e-12);
  }
}

TEST(Unicycle, AccelerationNeverExceedsItsLimits) {
  const UnicycleLimits limits;
  const double dt = 0.01;
  for (double v = -1.2; v <= 1.2; v += 0.3) {
    for (double w = -4; w <= 4; w += 1) {
      for (double cv = -2; cv <= 2; cv += 0.5) {
        for (double cw = -6; cw <= 6; cw += 1.5) {
          const Twist2 next = limit_acceleration({v, w}, {cv, cw}, limits, dt);
          EXPECT_LE(std::abs(next.v_mps - v), limits.a_max_mps2 * dt + 1e-12);
          EXPECT_LE(std::abs(next.w_radps - w), limits.alpha_max_radps2 * dt + 1e-12);
          EXPECT_LE(std::abs(next.v_mps), limits.v_max_mps + 1e-12);
        }
      }
    }
  }
}

TEST(UnicycleRobot, BrakingKeepsToTheArc) {
  UnicycleRobot robot({}, {}, 0);
  robot.command({0.6, 0.6});
  robot.advance_to(5);
  ASSERT_NEAR(robot.twist().v_mps, 0.6, 1e-9);
  robot.command({0, 0});
  const Pose2 start = robot.pose();
  for (double t = 5; t < 8; t += 0.1) {
    robot.advance_to(t);
    EXPECT_NEAR(robot.twist().v_mps, robot.twist().w_radps, 1e-9);
    // Radius 1 m: the distance to the arc's middle stays.
    const double x = start.x_m - std::sin(start.yaw_rad), y = start.y_m + std::cos(start.yaw_rad);
    EXPECT_NEAR(std::hypot(robot.pose().x_m - x, robot.pose().y_m - y), 1, 1e-9);
  }
  EXPECT_EQ(robot.twist().v_mps, 0);
  // v^2 / (2 a) of arc to stand still.
  EXPECT_NEAR(robot.pose().yaw_rad - start.yaw_rad, 0.36 / 0.6, 1e-3);
}

TEST(UnicycleRobot, ACommandActsAfterItsDelay) {
  UnicycleRobot robot({}, quick, 0.05);
  robot.command({1, 0});
  robot.advance_to(0.05);
  EXPECT_EQ(robot.pose().x_m, 0);
  robot.advance_to(0.15);
  EXPECT_NEAR(robot.pose().x_m, 0.1, 1e-3);
  robot.command({std::numeric_limits<double>::quiet_NaN(), 0});
  robot.advance_to(1);
  EXPECT_NEAR(robot.pose().x_m, 0.15, 1e-3);  // stands
}

TEST(UnicycleRobot, TheWayDoesNotDependOnHowOftenItIsAsked) {
  UnicycleRobot once({}, {}, 0.05), often({}, {}, 0.05);
  once.command({0.5, 0.4});
  often.command({0.5, 0.4});
  once.advance_to(3);
  for (int k = 1; k <= 90; ++k) often.advance_to(k / 30.0);
  EXPECT_NEAR(once.pose().x_m, often.pose().x_m, 1e-6);
  EXPECT_NEAR(once.pose().yaw_rad, often.pose().yaw_rad, 1e-6);
}

TEST(UnicycleRobot, RefusesLimitsAndDelaysThatCannotBe) {
  EXPECT_THROW(UnicycleRobot({}, {0, 1, 1, std::nan("")}, 0), InputError);
  EXPECT_THROW(UnicycleRobot({}, {}, -0.1), InputError);
}

/// Distance between where ViSP's simulated Pioneer and ours end up after the same commands.
double gap_to_visp(double step_s) {
  vpSimulatorPioneer visp;
  visp.vpUnicycle::set_cMe(vpHomogeneousMatrix());  // its position is the camera's: put that on the axle
  visp.setSamplingTime(step_s);
  visp.setMaxTranslationVelocity(10);
  visp.setMaxRotationVelocity(10);
  UnicycleRobot ours({}, quick, 0);
  const auto drive = [&](double v, double w, double until_s, double from_s) {
    vpColVector velocity(2);
    velocity[0] = v;
    velocity[1] = w;
    ours.command({v, w});
    const int steps = static_cast<int>(std::lround((until_s - from_s) / step_s));
    for (int k = 0; k < steps; ++k) visp.setVelocity(vpRobot::ARTICULAR_FRAME, velocity);
    ours.advance_to(until_s);
  };
  drive(0.5, 0.6, 2, 0);
  drive(0.8, -0.4, 4, 2);
  drive(-0.3, 0.9, 5, 4);
  vpHomogeneousMatrix wMm;
  visp.getPosition(wMm);
  return std::hypot(wMm[0][3] - ours.pose().x_m, wMm[1][3] - ours.pose().y_m);
}

TEST(UnicycleRobot, VispsSimulatorConvergesToItAsItsStepShrinks) {
  const double coarse = gap_to_visp(0.04), fine = gap_to_visp(0.01), finest = gap_to_visp(0.0025);
  EXPECT_LT(fine, 0.35 * coarse);  // Euler's error is of first order
  EXPECT_LT(finest, 0.35 * fine);
  EXPECT_LT(finest, 0.003);
  EXPECT_GT(coarse, 1e-3);
}

}  // namespace
}  // namespace ballservo
