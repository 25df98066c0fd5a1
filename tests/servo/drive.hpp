// The closed loop for the controller's tests: exact unicycle, delays, a ball as a point, noise as asked for.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "app/loop/loop.hpp"
#include "calibration/base/random.hpp"
#include "servo/features/builtin_laws.hpp"
#include "servo/simulation/robot/unicycle_robot.hpp"

namespace ballservo::test {

struct DriveSetup {
  ControllerOptions controller;
  LawOptions law;
  Pose2 start;
  std::function<Eigen::Vector2d(double time_s)> ball = [](double) { return Eigen::Vector2d(3.0, 0.4); };
  /// Whether the camera sees the ball in the frame at that time; frames fail to come where `frames` says so.
  std::function<bool(double time_s)> visible = [](double) { return true; };
  std::function<bool(double time_s)> frames = [](double) { return true; };
  double camera_hz = 30.0, duration_s = 20.0;
  double pixel_noise = 0.0;  ///< sigma of the outline's radius and centre, in pixels of a lens of f = 480
  double field_of_view_rad = 1.2;
  double clear_view_rad = 1.2;  ///< further aside the ball is cut by the border: seen, but never confirmed
};

struct DriveStep {
  double time_s = 0, range_error_m = 0, bearing_rad = 0;
  Twist2 twist;
  ControlOutput output;
};

/// Everything that is plugged into the loop of a drive, and what is left of it.
class PointDrive final : public FrameSource, public BallPerception, public Robot, public LoopObserver {
 public:
  explicit PointDrive(const DriveSetup& setup)
      : setup_(setup), robot_(setup.start, setup.controller.limits, setup.controller.actuation_delay_s) {}

  RobotState read(double now_s) override {
    robot_.advance_to(now_s);
    return {now_s, robot_.pose(), robot_.twist()};
  }
  void command(const Twist2& twist, double) override { robot_.command(twist); }

  std::optional<CameraFrame> take(Clock& clock, double until_s) override {
    for (double due_s; (due_s = static_cast<double>(frames_) / setup_.camera_hz) <= until_s;) {
      clock.sleep_until(due_s);
      robot_.advance_to(due_s);
      CameraFrame frame{frames_++, due_s, due_s + setup_.controller.latency_s};
      if (setup_.frames(due_s)) return frame;
    }
    return std::nullopt;
  }

  Percept look(const CameraFrame& frame) override {
    const ServoGoal& goal = setup_.controller.goal;
    const Eigen::Vector2d ball = setup_.ball(frame.time_s);
    Percept percept;
    BallMeasurement& seen = percept.ball;
    seen.time_s = frame.time_s;
    seen.p_CB = (X_WR(robot_.pose()) * goal.mount.X_RC()).inverse() *
                Eigen::Vector3d(ball.x(), ball.y(), goal.ball_height_m);
    const double aside_rad = std::abs(std::atan2(seen.p_CB.x(), seen.p_CB.z()));
    const bool in_view = aside_rad < 0.5 * setup_.field_of_view_rad && seen.p_CB.z() > 0;
    seen_in_a_row_ = in_view && setup_.visible(frame.time_s) ? seen_in_a_row_ + 1 : 0;
    if (seen_in_a_row_ == 0) return percept;
    const bool clear = seen_in_a_row_ >= 3 && aside_rad < 0.5 * setup_.clear_view_rad;
    seen.state = clear ? TrackState::confirmed : TrackState::tentative;
    const double rho = seen.p_CB.norm(), radius_px = 480 * goal.ball_height_m / rho;
    const double depth_sigma = rho * setup_.pixel_noise / radius_px,
                 side_sigma = rho * setup_.pixel_noise / 480;
    const Eigen::Vector3d ray = seen.p_CB / rho;
    seen.covariance_m2 = side_sigma * side_sigma * Eigen::Matrix3d::Identity() +
                         depth_sigma * depth_sigma * ray * ray.transpose();
    for (int axis = 0; axis < 3; ++axis) seen.p_CB[axis] += side_sigma * standard_normal(engine_);
    seen.p_CB += depth_sigma * standard_normal(engine_) * ray;
    return percept;
  }

  void step(const StepEvent& event) override {
    const Eigen::Vector2d p_RB = in_robot_frame(event.robot.odometry, setup_.ball(event.robot.time_s));
    steps.push_back({event.robot.time_s, p_RB.norm() - setup_.controller.goal.distance_m,
                     std::atan2(p_RB.y(), p_RB.x()), event.robot.twist, event.control});
  }

  std::vector<DriveStep> steps;

 private:
  const DriveSetup& setup_;
  UnicycleRobot robot_;
  RandomEngine engine_ = random_stream(0, "drive");
  long frames_ = 0;
  int seen_in_a_row_ = 0;
};

/// Every control step of a run.
inline std::vector<DriveStep> drive(const DriveSetup& setup) {
  ControllerOptions options = setup.controller;
  options.turn_gain_per_s = setup.law.gain_per_s;
  Controller controller(options, builtin_laws().make(setup.law, options.goal));
  PointDrive all(setup);
  SteppedClock clock;
  run_loop({all, all, all, controller, {&all}}, clock,
           [&](double time_s) { return time_s + 1 / options.rate_hz < setup.duration_s; });
  return std::move(all.steps);
}

/// The start of the stretch, up to the end, in which the robot stays within 10 mm and 0.5 degrees and 5 mm/s;
/// -1: none.
inline double settled_s(const std::vector<DriveStep>& steps) {
  double since_s = -1;
  for (const DriveStep& step : steps) {
    const bool there = std::abs(step.range_error_m) <= 0.010 &&
                       std::abs(step.bearing_rad) <= 0.5 * M_PI / 180 && std::abs(step.twist.v_mps) <= 0.005;
    if (!there)
      since_s = -1;
    else if (since_s < 0)
      since_s = step.time_s;
  }
  return since_s;
}

}  // namespace ballservo::test
