#include "servo/control/controller.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <array>
#include <cmath>
#include <set>

#include "calibration/base/fault.hpp"
#include "tests/servo/drive.hpp"

namespace ballservo {
namespace {

using test::drive;
using test::DriveSetup;
using test::DriveStep;
using test::settled_s;

constexpr double degree = 0.017453292519943295;

Eigen::Vector2d at(double range_m, double bearing_rad) {
  return {range_m * std::cos(bearing_rad), range_m * std::sin(bearing_rad)};
}

double nearest_m(const std::vector<DriveStep>& steps) {
  double nearest = 1e9;
  for (const DriveStep& step : steps) nearest = std::min(nearest, step.range_error_m);
  return nearest;
}

std::unique_ptr<Law> a_law(const ControllerOptions& options, const std::string& name = "cone") {
  return builtin_laws().make({name, options.turn_gain_per_s}, options.goal);
}

std::vector<ControlState> states_of(const std::vector<DriveStep>& steps) {
  std::vector<ControlState> states;
  for (const DriveStep& step : steps) {
    if (states.empty() || states.back() != step.output.state) states.push_back(step.output.state);
  }
  return states;
}

TEST(Controller, SettlesInTheTimeThatBrakingAllows) {
  for (const std::string& law : builtin_laws().names()) {
    // The prototype's times, with a margin of a twentieth.
    for (const auto& [range_m, allowed_s] : {std::pair{2.5, 6.7}, {3.5, 8.0}, {4.5, 9.0}}) {
      for (const double bearing_rad : {-0.4, 0.0, 0.3}) {
        DriveSetup setup;
        setup.law.name = law;
        setup.ball = [=, r = range_m](double) { return at(r, bearing_rad); };
        const auto steps = drive(setup);
        const double settled = settled_s(steps);
        EXPECT_GT(settled, 0) << law << " from " << range_m;
        EXPECT_LT(settled, allowed_s) << law << " from " << range_m;
        EXPECT_LT(std::abs(steps.back().range_error_m), 0.001);
        EXPECT_LT(std::abs(steps.back().bearing_rad), 0.05 * degree);
        EXPECT_EQ(steps.back().output.state, ControlState::hold);
        EXPECT_GT(nearest_m(steps), -0.002) << law << " overshoots from " << range_m;
      }
    }
  }
}

TEST(Controller, DoesNotOvershootUnderAnyDelayItKnows) {
  for (const double latency_s : {0.0, 0.033, 0.1, 0.2}) {
    for (const double actuation_s : {0.0, 0.05, 0.15}) {
      for (const double gain : {0.6, 2.0, 4.0}) {
        DriveSetup setup;
        setup.controller.latency_s = latency_s;
        setup.controller.actuation_delay_s = actuation_s;
        setup.law.gain_per_s = gain;
        setup.duration_s = 25;
        setup.ball = [](double) { return at(3.5, 0.2); };
        const auto steps = drive(setup);
        EXPECT_GT(settled_s(steps), 0) << latency_s << ' ' << actuation_s << ' ' << gain;
        EXPECT_GT(nearest_m(steps), -0.005) << latency_s << ' ' << actuation_s << ' ' << gain;
      }
    }
  }
}

TEST(Controller, BacksUpWhenTooNear) {
  DriveSetup setup;
  setup.ball = [](double) { return at(0.65, 0.1); };
  const auto steps = drive(setup);
  EXPECT_GT(settled_s(steps), 0);
  for (const DriveStep& step : steps) EXPECT_LT(step.range_error_m, 0.005);
}

TEST(Controller, DrivesNothingOnABallThatIsNotConfirmed) {
  DriveSetup setup;
  // Two frames of thirty show it: never confirmed.
  setup.visible = [](double t) { return std::fmod(t, 1.0) < 0.06; };
  for (const DriveStep& step : drive(setup)) {
    EXPECT_NE(step.output.state, ControlState::approach);
    EXPECT_EQ(step.output.command.v_mps, 0);
  }
}

// A ball that the border cuts is seen and not confirmed, for ever, unless the robot turns towards it.
TEST(Controller, TurnsTowardsABallAtTheBorderOfThePicture) {
  for (const double bearing_rad : {-0.55, 0.55}) {
    DriveSetup setup;
    setup.clear_view_rad = 1.0;
    setup.ball = [=](double) { return at(3.0, bearing_rad); };
    const auto steps = drive(setup);
    EXPECT_GT(settled_s(steps), 0) << bearing_rad;
    EXPECT_LT(settled_s(steps), 12) << bearing_rad;
  }
}

TEST(Controller, TurnsUntilItSeesTheBallBehindIt) {
  DriveSetup setup;
  setup.start.yaw_rad = 3.0;
  setup.ball = [](double) { return at(2.5, 0.0); };
  setup.duration_s = 25;
  const auto steps = drive(setup);
  const std::vector<ControlState> expected{ControlState::search, ControlState::acquire,
                                           ControlState::approach, ControlState::hold};
  EXPECT_EQ(states_of(steps), expected);
  EXPECT_GT(settled_s(steps), 0);
}

TEST(Controller, GivesUpAfterAFullTurnWithoutTheBall) {
  DriveSetup setup;
  setup.visible = [](double) { return false; };
  const auto steps = drive(setup);
  const std::vector<ControlState> expected{ControlState::search, ControlState::given_up};
  EXPECT_EQ(states_of(steps), expected);
  EXPECT_EQ(steps.back().output.command.w_radps, 0);
  EXPECT_EQ(steps.back().output.lost_events, 0);
}

TEST(Controller, StopsAndSaysSoWhenTheBallIsLostAndGoesOnWhenItIsBack) {
  DriveSetup setup;
  setup.ball = [](double) { return at(4.5, 0.0); };
  setup.visible = [](double t) { return t < 3.0 || t > 7.0; };
  setup.duration_s = 30;
  const auto steps = drive(setup);
  bool stopped = false, said = false;
  for (const DriveStep& step : steps) {
    if (step.time_s > 3.0 + 0.033 + 0.6 + 0.05 && step.time_s < 7.0) {
      EXPECT_EQ(step.output.command.v_mps, 0) << step.time_s;
      said |= step.output.state == ControlState::lost;
      stopped |= std::abs(step.twist.v_mps) < 1e-9;
    }
  }
  EXPECT_TRUE(said);
  EXPECT_TRUE(stopped);
  EXPECT_EQ(steps.back().output.lost_events, 1);
  EXPECT_GT(settled_s(steps), 0);
}

TEST(Controller, DrivesOnThroughAShortOcclusion) {
  DriveSetup setup;
  setup.ball = [](double) { return at(3.5, 0.2); };
  setup.visible = [](double t) { return t < 3.0 || t > 3.4; };
  const auto steps = drive(setup);
  EXPECT_EQ(steps.back().output.lost_events, 0);
  EXPECT_LT(settled_s(steps), 8.0);
}

TEST(Controller, GoesOnAtOnceAfterACommandThatWasStopped) {
  DriveSetup setup;
  setup.controller.latency_s = 0;
  Controller controller(setup.controller, a_law(setup.controller));
  test::PointDrive all(setup);
  double before_mps = 0;
  for (long k = 0; before_mps < 0.5; ++k) {
    ASSERT_LT(k, 500);
    const double t = 0.02 * k;
    const RobotState robot = all.read(t);
    controller.see(all.look({k, t, t}).ball);
    const Twist2 command = controller.step(t, robot.odometry, robot.twist).command;
    all.command(command, t);
    before_mps = command.v_mps;
    if (before_mps < 0.5) continue;
    all.command({}, t + 0.01);  // the guard's
    controller.rested(t + 0.01);
    const RobotState next = all.read(t + 0.02);
    controller.see(all.look({k + 1, t + 0.02, t + 0.02}).ball);
    const ControlOutput after = controller.step(t + 0.02, next.odometry, next.twist);
    EXPECT_GT(after.command.v_mps, before_mps - 0.01);
    // Who rested for long sets out anew.
    controller.rested(t + 0.03);
    controller.see(all.look({k + 100, t + 5, t + 5}).ball);
    EXPECT_LT(std::abs(controller.step(t + 5, next.odometry, {}).command.v_mps), 0.01);
  }
}

TEST(Controller, StopsOnStaleVisionWithinItsTime) {
  DriveSetup setup;
  setup.ball = [](double) { return at(4.5, 0.0); };
  setup.frames = [](double t) { return t < 3.0 || t > 5.0; };
  const auto steps = drive(setup);
  for (const DriveStep& step : steps) {
    // The last frame's picture is at most a frame's period older than 3.0 s.
    if (step.time_s > 3.0 + 0.033 + 0.2 + 0.02 && step.time_s < 5.0) {
      EXPECT_EQ(step.output.state, ControlState::stale) << step.time_s;
      EXPECT_EQ(step.output.command.v_mps, 0);
      EXPECT_EQ(step.output.command.w_radps, 0);
    }
  }
  EXPECT_GT(settled_s(steps), 0);
}

TEST(Controller, FollowsABallThatRollsAway) {
  DriveSetup setup;
  setup.ball = [](double t) { return Eigen::Vector2d(2.0 + 0.3 * t, 0.2); };
  setup.pixel_noise = 0.02;
  setup.duration_s = 20;
  const auto steps = drive(setup);
  for (const DriveStep& step : steps) {
    if (step.time_s < 14) continue;
    EXPECT_LT(std::abs(step.range_error_m), 0.05) << step.time_s;
    EXPECT_LT(std::abs(step.bearing_rad), 2 * degree) << step.time_s;
  }
}

TEST(Controller, IsNotMisledByOneWildSighting) {
  ControllerOptions options;
  Controller calm(options, a_law(options)), disturbed(options, a_law(options));
  ControlOutput a, b;
  for (int k = 0; k < 200; ++k) {
    const double t = 0.02 * k;
    BallMeasurement frame;
    frame.time_s = t;
    frame.state = TrackState::confirmed;
    frame.p_CB = {-0.2, 0.1, 3.0};
    frame.covariance_m2 = 1e-4 * Eigen::Matrix3d::Identity();
    calm.see(frame);
    if (k == 150) frame.p_CB = {1.5, 0.1, 1.0};
    disturbed.see(frame);
    a = calm.step(t, {}, {});
    b = disturbed.step(t, {}, {});
    EXPECT_NEAR(a.command.v_mps, b.command.v_mps, 0.01);
    EXPECT_NEAR(a.command.w_radps, b.command.w_radps, 0.01);
  }
  EXPECT_GT(a.command.v_mps, 0);
}

TEST(Controller, IgnoresDuplicateAndBackwardFrames) {
  ControllerOptions options;
  Controller once(options, a_law(options)), again(options, a_law(options));
  for (int k = 0; k < 100; ++k) {
    const double t = 0.02 * k;
    BallMeasurement frame;
    frame.time_s = t;
    frame.state = TrackState::confirmed;
    frame.p_CB = {-0.2, 0.1, 3.0};
    frame.covariance_m2 = 1e-4 * Eigen::Matrix3d::Identity();
    once.see(frame);
    again.see(frame);
    frame.p_CB.x() += 0.05;  // what a duplicate or a late one claims must not matter
    again.see(frame);
    frame.time_s -= 1.0;
    again.see(frame);
    const auto a = once.step(t, {}, {}), b = again.step(t, {}, {});
    EXPECT_EQ(a.command.v_mps, b.command.v_mps);
    EXPECT_EQ(a.command.w_radps, b.command.w_radps);
    EXPECT_EQ(a.state, b.state);
    EXPECT_EQ(a.track_state, b.track_state);
  }
}

TEST(Controller, StopsOnNonsenseAndRecovers) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ControllerOptions options;
  Controller controller(options, a_law(options));
  ControlOutput output;
  for (int k = 0; k < 300; ++k) {
    const double t = 0.02 * k;
    BallMeasurement frame;
    frame.time_s = t;
    frame.state = TrackState::confirmed;
    frame.p_CB = {-0.2, 0.1, k == 120 ? nan : 3.0};
    frame.covariance_m2 = 1e-4 * Eigen::Matrix3d::Identity();
    controller.see(frame);
    Pose2 pose;
    if (k == 150) pose.yaw_rad = nan;
    controller.note_pan({k == 210 ? nan : 0, 0});
    output = controller.step(k == 180 ? nan : t, pose, {});
    if (k == 120 || k == 150 || k == 180 || k == 210) {
      EXPECT_EQ(output.state, ControlState::fault) << k;
      EXPECT_EQ(output.command.v_mps, 0);
      EXPECT_EQ(output.command.w_radps, 0);
      EXPECT_EQ(output.pan_radps, 0);
    } else if (k > 10) {
      EXPECT_EQ(output.state, ControlState::approach) << k << ' ' << output.reason;
    }
  }
}

TEST(Controller, NamesEveryFaultOfItsOptions) {
  ControllerOptions options;
  options.rate_hz = 0;
  options.latency_s = -1;
  options.limits.a_max_mps2 = std::numeric_limits<double>::quiet_NaN();
  options.turn_gain_per_s = 0;
  options.goal.distance_m = 0;
  options.command_s = -1;
  options.actuation_delay_s = 3;
  try {
    Controller controller(options, a_law({}));
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.faults().size(), 7u) << error.what();
  }
}

TEST(Controller, NeedsALaw) { EXPECT_THROW(Controller({}, nullptr), std::invalid_argument); }

/// Numbers that a sensor could never mean: NaN, infinities, denormals, huge ones, and ordinary ones.
double odd_number(RandomEngine& engine, double ordinary) {
  switch (uniform_index(engine, 12)) {
    case 0:
      return std::numeric_limits<double>::quiet_NaN();
    case 1:
      return std::numeric_limits<double>::infinity();
    case 2:
      return -std::numeric_limits<double>::infinity();
    case 3:
      return std::numeric_limits<double>::denorm_min();
    case 4:
      return -std::numeric_limits<double>::denorm_min();
    case 5:
      return 1e308 * uniform(engine, -1, 1);
    case 6:
      return 1e-308 * uniform(engine, -1, 1);
    case 7:
      return 0.0;
    default:
      return ordinary * uniform(engine, -1, 1);
  }
}

// 100 000 steps in 1000 runs: whatever comes in, what goes out is finite, within the limits, and what a drive
// that was told all of it can follow, except to stop.
TEST(Controller, PutsOutFiniteCommandsWithinTheLimitsWhateverComesIn) {
  long steps = 0;
  const bool ok = rc::check("limits", [&steps](std::uint64_t seed) {
    RandomEngine engine = random_stream(seed, "odd");
    ControllerOptions options;
    const std::string law = uniform_index(engine, 2) == 0 ? "cone" : "visp";
    options.actuation_delay_s = uniform(engine, 0, 0.2);
    options.latency_s = uniform(engine, 0, 0.2);
    Controller controller(options, a_law(options, law));
    const bool mostly_sane = uniform_index(engine, 2) == 0;
    const auto number = [&](double ordinary) {
      return mostly_sane && uniform_index(engine, 40) != 0 ? ordinary * uniform(engine, -1, 1)
                                                           : odd_number(engine, ordinary);
    };
    Twist2 drive, told;
    double told_s = -std::numeric_limits<double>::infinity();
    for (int k = 0; k < 1000; ++k, ++steps) {
      double t = 0.02 * k;
      const int frames = static_cast<int>(uniform_index(engine, 3));
      for (int i = 0; i < frames; ++i) {
        BallMeasurement frame;
        frame.time_s = t + (mostly_sane ? 0.0 : number(0.1));
        frame.state = static_cast<TrackState>(uniform_index(engine, 4) == 0 ? uniform_index(engine, 4) : 2);
        frame.p_CB = {number(2), number(2), std::abs(number(4))};
        for (int j = 0; j < 9; ++j) frame.covariance_m2.data()[j] = number(1e-3);
        if (mostly_sane) frame.covariance_m2 = frame.covariance_m2 * frame.covariance_m2.transpose();
        controller.see(frame);
      }
      if (!mostly_sane && uniform_index(engine, 10) == 0) t = number(t);
      const ControlOutput output =
          controller.step(t, {number(0.01), number(0.01), number(0.01)}, {number(1), number(1)});
      const Twist2 u = output.command;
      if (const double step_s = controller.stamps().step_s; step_s > told_s + 1e-9) {  // else it was refused
        drive = limit_acceleration(drive, told, options.limits, std::min(step_s - told_s, 1e3));
        told_s = step_s;
      }
      told = u;
      RC_ASSERT(std::isfinite(u.v_mps) && std::isfinite(u.w_radps));
      RC_ASSERT(std::abs(u.v_mps) <= options.limits.v_max_mps * (1 + 1e-12));
      RC_ASSERT(std::abs(u.w_radps) <= options.limits.w_max_radps * (1 + 1e-12));
      const bool stop = u.v_mps == 0 && u.w_radps == 0;
      RC_ASSERT(stop ||
                std::abs(u.v_mps - drive.v_mps) <= options.limits.a_max_mps2 / options.rate_hz + 1e-12);
      RC_ASSERT(stop || std::abs(u.w_radps - drive.w_radps) <=
                            options.limits.alpha_max_radps2 / options.rate_hz + 1e-12);
    }
  });
  EXPECT_TRUE(ok);
  EXPECT_GE(steps, 100000);
}

// Chasing a ball that rolls away; the camera fails for a while again and again.
TEST(Controller, RestsSoonAfterTheCameraStopsAtAnyOfAThousandInstants) {
  constexpr int instants = 1000;
  RandomEngine engine = random_stream(0, "camera stops");
  struct Gap {
    double from_s, to_s;
  };
  std::vector<Gap> gaps;
  for (double t = 3; gaps.size() < instants; t = gaps.back().to_s) {
    const double from_s = t + uniform(engine, 1.0, 1.6);
    gaps.push_back({from_s, from_s + uniform(engine, 0.3, 0.6)});
  }
  DriveSetup setup;
  setup.ball = [](double t) { return Eigen::Vector2d(2.0 + 0.3 * t, 0.0); };
  setup.duration_s = gaps.back().to_s;
  setup.frames = [&gaps, k = std::size_t{0}](double t) mutable {
    while (k + 1 < gaps.size() && t >= gaps[k].to_s) ++k;
    return t < gaps[k].from_s || t >= gaps[k].to_s;
  };
  const ControllerOptions& options = setup.controller;
  const std::vector<DriveStep> steps = drive(setup);
  int drove = 0;
  std::size_t step = 0;
  for (const Gap& gap : gaps) {
    // The last frame before the gap may have arrived up to a frame earlier than this.
    const double last_arrival_s = gap.from_s + options.latency_s;
    while (step < steps.size() && steps[step].time_s < gap.from_s) ++step;
    drove += steps[step].output.command.v_mps > 0.05 ? 1 : 0;
    for (; step < steps.size() && steps[step].time_s <= gap.to_s; ++step) {
      if (steps[step].time_s <= last_arrival_s + 0.2 + 1.0 / options.rate_hz) continue;
      EXPECT_EQ(steps[step].output.command.v_mps, 0.0) << steps[step].time_s;
      EXPECT_EQ(steps[step].output.command.w_radps, 0.0) << steps[step].time_s;
    }
  }
  EXPECT_GE(drove, 9 * instants / 10) << "a robot that rests anyway shows nothing";
}

}  // namespace
}  // namespace ballservo
