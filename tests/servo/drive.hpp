// A small closed loop for the controller's tests: exact unicycle, delays, a ball as a point, noise as asked
// for.
#pragma once

#include <cmath>
#include <deque>
#include <functional>
#include <vector>

#include "calibration/base/random.hpp"
#include "servo/control/controller.hpp"
#include "servo/features/builtin_laws.hpp"

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
};

struct DriveStep {
  double time_s = 0, range_error_m = 0, bearing_rad = 0;
  Twist2 twist;
  ControlOutput output;
};

/// Every control step of a run.
inline std::vector<DriveStep> drive(const DriveSetup& setup) {
  ControllerOptions options = setup.controller;
  options.turn_gain_per_s = setup.law.gain_per_s;
  Controller controller(options, builtin_laws().make(setup.law, options.goal));
  Pose2 pose = setup.start;
  Twist2 twist;
  struct Late {
    double at_s;
    BallMeasurement frame;
  };
  std::deque<Late> on_the_way;
  std::deque<std::pair<double, Twist2>> commands;
  std::vector<DriveStep> steps;
  Twist2 acting;
  RandomEngine engine = random_stream(0, "drive");
  const double tick_s = 0.001;
  long next_frame = 0, next_step = 0;
  int seen_in_a_row = 0;
  for (long tick = 0; tick * tick_s < setup.duration_s; ++tick) {
    const double t = static_cast<double>(tick) * tick_s;
    const Eigen::Vector2d ball = setup.ball(t);
    const Eigen::Vector2d p_RB = in_robot_frame(pose, ball);
    if (t >= static_cast<double>(next_frame) / setup.camera_hz) {
      ++next_frame;
      BallMeasurement frame;
      frame.time_s = t;
      frame.p_CB = (X_WR(pose) * options.goal.mount.X_RC()).inverse() *
                   Eigen::Vector3d(ball.x(), ball.y(), options.goal.ball_height_m);
      const bool in_view =
          std::abs(std::atan2(frame.p_CB.x(), frame.p_CB.z())) < 0.5 * setup.field_of_view_rad &&
          frame.p_CB.z() > 0;
      const bool seen = in_view && setup.visible(t);
      seen_in_a_row = seen ? seen_in_a_row + 1 : 0;
      if (seen) {
        frame.state = seen_in_a_row < 3 ? TrackState::tentative : TrackState::confirmed;
        const double rho = frame.p_CB.norm(), radius_px = 480 * options.goal.ball_height_m / rho;
        const double depth_sigma = rho * setup.pixel_noise / radius_px,
                     side_sigma = rho * setup.pixel_noise / 480;
        const Eigen::Vector3d ray = frame.p_CB / rho;
        frame.covariance_m2 = side_sigma * side_sigma * Eigen::Matrix3d::Identity() +
                              depth_sigma * depth_sigma * ray * ray.transpose();
        for (int axis = 0; axis < 3; ++axis) frame.p_CB[axis] += side_sigma * standard_normal(engine);
        frame.p_CB += depth_sigma * standard_normal(engine) * ray;
      }
      if (setup.frames(t)) on_the_way.push_back({t + options.latency_s, frame});
    }
    if (t >= static_cast<double>(next_step) / options.rate_hz) {
      ++next_step;
      while (!on_the_way.empty() && on_the_way.front().at_s <= t) {
        controller.see(on_the_way.front().frame);
        on_the_way.pop_front();
      }
      DriveStep step;
      step.time_s = t;
      step.output = controller.step(t, pose, twist);
      step.range_error_m = p_RB.norm() - options.goal.distance_m;
      step.bearing_rad = std::atan2(p_RB.y(), p_RB.x());
      step.twist = twist;
      steps.push_back(step);
      commands.emplace_back(t + options.actuation_delay_s, step.output.command);
    }
    while (!commands.empty() && commands.front().first <= t + 1e-12) {
      acting = commands.front().second;
      commands.pop_front();
    }
    const Twist2 before = twist;
    twist = limit_acceleration(twist, acting, options.limits, tick_s);
    pose =
        integrate(pose, {0.5 * (before.v_mps + twist.v_mps), 0.5 * (before.w_radps + twist.w_radps)}, tick_s);
  }
  return steps;
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
