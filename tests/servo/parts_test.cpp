// The controller's parts: envelope, filter, poses of the past, motion to come.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "calibration/base/random.hpp"
#include "servo/control/ball_memory.hpp"
#include "servo/motion/camera_mount.hpp"
#include "servo/motion/motion_history.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo {
namespace {

const UnicycleLimits limits;

TEST(SpeedEnvelope, RobotBrakingFromItStopsBeforeTheGoal) {
  for (const double way_m : {0.01, 0.3, 1.0, 2.0}) {
    const double v = braking_speed(way_m, limits.a_max_mps2, envelope_braking_share);
    EXPECT_LT(v * v / (2 * limits.a_max_mps2), way_m);
    EXPECT_NEAR(v * v / (2 * 0.85 * limits.a_max_mps2), way_m, 1e-12);
  }
  EXPECT_EQ(braking_speed(0, 1, 0.85), 0);
  EXPECT_EQ(braking_speed(-1, 1, 0.85), 0);
}

TEST(SpeedEnvelope, NeverRaisesASpeedAndKeepsTheCurvature) {
  RandomEngine engine = random_stream(1, "envelope");
  for (int i = 0; i < 2000; ++i) {
    const Twist2 u{uniform(engine, -20, 20), uniform(engine, -20, 20)};
    const double e = uniform(engine, -0.5, 3);
    const Eigen::Vector2d p_RB(0.8 + e, uniform(engine, -1, 1));
    const Twist2 limited = limit_to_envelope(u, e, p_RB, {0, 0}, limits);
    EXPECT_LE(std::abs(limited.v_mps), std::abs(u.v_mps));
    EXPECT_LE(std::abs(limited.w_radps), std::abs(u.w_radps));
    EXPECT_NEAR(limited.v_mps * u.w_radps, limited.w_radps * u.v_mps, 1e-9);
    const double toward = e > 0 ? limited.v_mps : -limited.v_mps;
    EXPECT_LE(toward, braking_speed(std::abs(e) + range_slack_m, limits.a_max_mps2, 0.85) + 1e-12);
  }
}

TEST(SpeedEnvelope, LeavesASmallCommandAlone) {
  const Twist2 limited = limit_to_envelope({0.1, 0.05}, 1.0, {1.8, 0.2}, {0, 0}, limits);
  EXPECT_EQ(limited.v_mps, 0.1);
  EXPECT_EQ(limited.w_radps, 0.05);
}

TEST(SpeedEnvelope, LetsTheRobotKeepUpWithABallThatLeaves) {
  const Twist2 limited = limit_to_envelope({0.5, 0}, 0.0, {0.8, 0}, {0.5, 0}, limits);
  EXPECT_EQ(limited.v_mps, 0.5);
}

TEST(SpeedEnvelope, BacksOffFromABallThatComesFast) {
  const Twist2 limited = limit_to_envelope({0.2, 0.1}, 0.0, {0.8, 0}, {-0.5, 0}, limits);
  EXPECT_LT(limited.v_mps, 0);
}

TEST(PoseHistory, InterpolatesAcrossTheWrapAndKnowsItsEnds) {
  PoseHistory history(4);
  EXPECT_FALSE(pose_at(history, 0));
  history.add(1.0, {0, 0, 3.1});
  history.add(2.0, {0, 0, -3.1});
  history.add(1.5, {9, 9, 9});  // backward: ignored
  ASSERT_TRUE(pose_at(history, 1.5));
  EXPECT_NEAR(std::abs(wrap_angle(pose_at(history, 1.5)->yaw_rad)), M_PI, 1e-9);
  EXPECT_DOUBLE_EQ(pose_at(history, 2.0)->yaw_rad, -3.1);
  EXPECT_FALSE(pose_at(history, 2.1));
  EXPECT_FALSE(pose_at(history, 0.9));
  EXPECT_FALSE(pose_at(history, std::numeric_limits<double>::quiet_NaN()));
  for (int i = 3; i < 7; ++i) history.add(i, {});
  EXPECT_FALSE(pose_at(history, 2.0));  // pushed out
  EXPECT_TRUE(pose_at(history, 3.0));
}

TEST(PoseHistory, InterpolatesAlongAnArc) {
  PoseHistory history(4);
  const Pose2 start{0.3, -0.2, 3.0};
  const Twist2 twist{2.0, 3.0};
  for (const double time_s : {0.0, 0.125}) history.add(time_s, integrate(start, twist, time_s));
  for (const double time_s : {0.02, 0.06, 0.11}) {
    const Pose2 truth = integrate(start, twist, time_s), pose = *pose_at(history, time_s);
    EXPECT_LT(std::hypot(pose.x_m - truth.x_m, pose.y_m - truth.y_m), 2e-3) << "11 mm along the chord";
  }
}

TEST(MotionPredictor, KnowsTheTwistFromTheCommandsAndOdometryWithinItsBound) {
  const OdometryBound bound{0.2, 0.1, 0};
  MotionPredictor predictor(limits, 0.1, 64);
  RobotMotion truth;
  Twist2 command;
  for (int k = 0; k < 100; ++k) {
    const double now_s = 0.02 * k;
    const Twist2 measured{0.8 * truth.twist.v_mps, 1.1 * truth.twist.w_radps};
    const Twist2 twist = predictor.twist_at(now_s, measured, bound);
    ASSERT_NEAR(twist.v_mps, truth.twist.v_mps, 1e-9) << k;
    ASSERT_NEAR(twist.w_radps, truth.twist.w_radps, 1e-9) << k;
    if (k == 20) command = {0.5, 0.1};
    if (k == 70) command = {};
    predictor.add_command(now_s, command);
    // It acts after five steps.
    truth = drive(truth, k < 25 || k >= 75 ? Twist2{} : Twist2{0.5, 0.1}, limits, 0.02, 10);
  }
  const Twist2 slipping = predictor.twist_at(2.0, {0.6, 0.0}, bound);
  EXPECT_NEAR(slipping.v_mps, 0.6 - 0.6 * 0.2 / 0.8, 1e-9) << "it does not go as the commands say";
}

TEST(MotionPredictor, IsTheRobotItselfThroughTheCommandsInFlight) {
  RandomEngine engine = random_stream(2, "flight");
  const double delay_s = 0.13, dt_s = 0.02;
  MotionPredictor predictor(limits, delay_s, 64);
  std::vector<Twist2> commands;
  // The robot itself, at a finer step. How a drive at its limits shares them between its speeds depends a
  // little on the step, hence the tolerances: far below what the delay itself would cost (0.13 s at 1 m/s).
  std::vector<RobotMotion> truth{RobotMotion{}};
  Twist2 u;
  for (int k = 0; k < 200; ++k) {
    u = limit_acceleration(u, {uniform(engine, -1, 1), uniform(engine, -2, 2)}, limits, dt_s);
    commands.push_back(u);
  }
  for (int tick = 0; tick < 200 * 20; ++tick) {  // of 1 ms
    const int acting = static_cast<int>(std::floor((tick * 0.001 - delay_s) / dt_s + 1e-9));
    RobotMotion robot = truth.back();
    const Twist2 command = acting >= 0 ? commands[acting] : Twist2{};
    const Twist2 after = limit_acceleration(robot.twist, command, limits, 0.001);
    robot.pose = integrate(
        robot.pose, {0.5 * (robot.twist.v_mps + after.v_mps), 0.5 * (robot.twist.w_radps + after.w_radps)},
        0.001);
    robot.twist = after;
    truth.push_back(robot);
  }
  for (int k = 0; k + 8 < 200; ++k) {
    const RobotMotion ahead = predictor.predict(k * dt_s, truth[20 * k]);
    predictor.add_command(k * dt_s, commands[k]);
    const RobotMotion& there = truth[20 * k + 130];
    EXPECT_NEAR(ahead.pose.x_m, there.pose.x_m, 5e-4) << k;
    EXPECT_NEAR(ahead.pose.y_m, there.pose.y_m, 5e-4) << k;
    EXPECT_NEAR(ahead.pose.yaw_rad, there.pose.yaw_rad, 1e-3) << k;
    EXPECT_NEAR(ahead.twist.v_mps, there.twist.v_mps, 3e-3) << k;
  }
}

BallMeasurement sighting(double time_s, const Eigen::Vector3d& p_CB, double sigma_m) {
  BallMeasurement measurement;
  measurement.time_s = time_s;
  measurement.state = TrackState::confirmed;
  measurement.p_CB = p_CB;
  measurement.covariance_m2 = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
  return measurement;
}

TEST(TargetFilter, PlacesAnExactSightingWhereTheBallIs) {
  const CameraMount mount;
  TargetFilter filter(mount);
  EXPECT_FALSE(filter.predict(0));
  const Pose2 pose{1.0, -2.0, 0.7};
  const Eigen::Vector3d p_OB(3.0, 0.5, 0.06);
  const Eigen::Vector3d p_CB = (X_WR(pose) * mount.X_RC()).inverse() * p_OB;
  EXPECT_EQ(filter.update(sighting(1.0, p_CB, 0.01), pose), TargetFilter::Update::started);
  EXPECT_NEAR((filter.predict(1.0)->p_OB - p_OB).norm(), 0, 1e-12);
}

TEST(TargetFilter, AveragesARestingBallAndTakesItToRest) {
  const CameraMount mount;
  TargetFilter filter(mount);
  RandomEngine engine = random_stream(3, "rest");
  const Eigen::Vector3d p_CB(0.3, 0.1, 3.0), p_OB = mount.X_RC() * p_CB;
  double moving_steps = 0, square_error = 0;
  for (int k = 0; k < 600; ++k) {
    Eigen::Vector3d noisy = p_CB;
    for (int axis = 0; axis < 3; ++axis) noisy[axis] += 0.01 * standard_normal(engine);
    filter.update(sighting(k / 30.0, noisy, 0.01), {});
    if (k < 60) continue;
    const auto estimate = filter.predict(k / 30.0 + 0.05);
    moving_steps += estimate->v_OB.isZero(0.0) ? 0 : 1;
    square_error += (estimate->p_OB - p_OB).squaredNorm();
  }
  EXPECT_LE(moving_steps, 5);
  EXPECT_LT(std::sqrt(square_error / 540 / 3), 0.006);  // better than a sighting's 0.010
}

TEST(TargetFilter, FollowsABallOfConstantVelocityWithoutLag) {
  const CameraMount mount;
  TargetFilter filter(mount);
  for (int k = 0; k < 300; ++k) {
    const double t = k / 30.0;
    filter.update(sighting(t, mount.X_RC().inverse() * Eigen::Vector3d(2 + 0.3 * t, 0.1 * t, 0.06), 0.002),
                  {});
  }
  const auto estimate = filter.predict(10.5);
  EXPECT_NEAR((estimate->p_OB - Eigen::Vector3d(2 + 0.3 * 10.5, 1.05, 0.06)).norm(), 0, 0.002);
  EXPECT_NEAR((estimate->v_OB - Eigen::Vector2d(0.3, 0.1)).norm(), 0, 0.003);
}

TEST(TargetFilter, IgnoresWhatIsLateDoubleOrNoSighting) {
  TargetFilter filter(CameraMount{});
  const Eigen::Vector3d p(0, 0, 2);
  filter.update(sighting(1.0, p, 0.01), {});
  EXPECT_EQ(filter.update(sighting(1.0, p, 0.01), {}), TargetFilter::Update::ignored);
  EXPECT_EQ(filter.update(sighting(0.9, p, 0.01), {}), TargetFilter::Update::ignored);
  BallMeasurement coasting = sighting(1.1, p, 0.01);
  coasting.state = TrackState::coasting;
  EXPECT_EQ(filter.update(coasting, {}), TargetFilter::Update::ignored);
  BallMeasurement negative = sighting(1.1, p, 0.01);
  negative.covariance_m2 = -Eigen::Matrix3d::Identity();
  EXPECT_EQ(filter.update(negative, {}), TargetFilter::Update::ignored);
  EXPECT_EQ(filter.update(sighting(1.1, p, 0.01), {}), TargetFilter::Update::accepted);
}

TEST(TargetFilter, DoubtsOneOutlierAndBelievesARow) {
  TargetFilter filter(CameraMount{});
  const Eigen::Vector3d here(0, 0, 2), there(0.8, 0, 2);
  for (int k = 0; k < 30; ++k) filter.update(sighting(k / 30.0, here, 0.005), {});
  const Eigen::Vector3d before = filter.predict(1.0)->p_OB;
  EXPECT_EQ(filter.update(sighting(1.0, there, 0.005), {}), TargetFilter::Update::doubted);
  EXPECT_NEAR((filter.predict(1.0)->p_OB - before).norm(), 0, 1e-12);
  TargetFilter::Update last = TargetFilter::Update::ignored;
  for (int k = 1; k < TargetFilter::doubts_to_restart; ++k)
    last = filter.update(sighting(1.0 + k / 30.0, there, 0.005), {});
  EXPECT_EQ(last, TargetFilter::Update::started);
}

/// Feeds a filter by a drive towards a ball, after a second at rest; the ball is seen `scale` times as far
/// away as it is.
class Approach {
 public:
  explicit Approach(double scale) : scale_(scale) {}

  void drive(double seconds, double ball_vx_mps) {
    for (int k = 0; k < seconds * 30; ++k) {
      t_s_ += 1 / 30.0;
      if (t_s_ > 1) speed_mps_ = std::min(0.5, speed_mps_ + 0.3 / 30);
      robot_.x_m += speed_mps_ / 30;
      ball_.x() += ball_vx_mps / 30;
      const Eigen::Vector3d p_CB = (X_WR(robot_) * mount_.X_RC()).inverse() * ball_;
      last_ = filter.update(sighting(t_s_, scale_ * p_CB, 0.002), robot_);
      restarts += last_ == TargetFilter::Update::started;
    }
  }
  TargetEstimate estimate() const { return *filter.predict(t_s_); }
  double error_m() const { return (estimate().p_OB - ball_).norm(); }

 private:
  CameraMount mount_;
  double scale_, t_s_ = 0, speed_mps_ = 0;
  Pose2 robot_{10, -4, 0};  // odometry's frame begins anywhere
  Eigen::Vector3d ball_{15, -3.8, 0.06};
  TargetFilter::Update last_ = TargetFilter::Update::ignored;

 public:
  TargetFilter filter{mount_, 0.7};
  int restarts = 0;
};

TEST(TargetFilter, TellsAWrongScaleFromABallThatMoves) {
  for (const double scale : {0.4, 1.0, 3.0}) {
    Approach resting(scale);
    resting.drive(5, 0);
    EXPECT_NEAR(resting.estimate().scale / scale, 1, 0.015);
    EXPECT_TRUE(resting.estimate().v_OB.isZero(0.0)) << scale;
    EXPECT_LT(resting.error_m(), 0.04) << scale;

    if (scale < 1) continue;  // of a ball that seems to creep no speed stands out so soon
    Approach moving(scale);
    moving.drive(5, 0.2);
    EXPECT_NEAR(moving.estimate().v_OB.x(), 0.2, 0.02) << scale;
    EXPECT_NEAR(moving.estimate().scale / scale, 1, 0.05);
  }
}

TEST(TargetFilter, OfABallThatKeepsAheadTheScaleStaysWithinReason) {
  Approach approach(1);
  for (int second = 0; second < 20; ++second) {
    approach.drive(1, std::min(0.5, 0.3 * std::max(0, second - 1)));
    EXPECT_GE(approach.estimate().scale, 1 / TargetFilter::greatest_scale);
    EXPECT_LE(approach.estimate().scale, TargetFilter::greatest_scale);
  }
  EXPECT_EQ(approach.restarts, 1);
}

TEST(TargetFilter, KeepsAScaleThroughABounce) {
  Approach approach(2);
  approach.drive(5, 0.3);
  const double before = approach.estimate().scale;
  approach.drive(0.5, -0.6);
  EXPECT_GE(approach.restarts, 2);
  EXPECT_NEAR(approach.estimate().scale / before, 1, 0.03);
  EXPECT_NEAR(approach.estimate().v_OB.x(), -0.6, 0.1);
}

TEST(TargetFilter, KeepsItsCovariancePositive) {
  TargetFilter filter(CameraMount{}, 0.7);
  RandomEngine engine = random_stream(4, "positive");
  for (int k = 0; k < 3000; ++k) {
    const double sigma = std::exp(uniform(engine, -20, 0));
    filter.update(sighting(k / 30.0, {0.001 * standard_normal(engine), 0, 2}, sigma), {});
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(filter.predict(k / 30.0)->covariance_m2);
    ASSERT_GT(solver.eigenvalues().minCoeff(), 0);
  }
}

}  // namespace
}  // namespace ballservo
