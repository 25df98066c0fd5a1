#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>

#include "calibration/base/fault.hpp"
#include "servo/features/builtin_laws.hpp"
#include "tests/servo/random_scene.hpp"

namespace ballservo {
namespace {

using test::in_camera;
using test::random_goal;
using test::random_p_RB;

constexpr int scenes = 300;

/// A law as derived on paper: errors, their derivative by time per (v, w) for a ball that rests, and by the
/// ball's place. Independent of ViSP and of the features' classes.
struct ClosedForm {
  std::function<Eigen::Vector2d(const Eigen::Vector3d& p_CB)> errors;
  std::function<Eigen::Matrix2d(const Eigen::Vector3d& p_CB)> robot_jacobian;
  std::function<Eigen::Matrix<double, 2, 3>(const Eigen::Vector3d& p_CB)> ball_jacobian;

  Eigen::Vector2d command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB, double gain_per_s) const {
    return robot_jacobian(p_CB).inverse() * (-gain_per_s * errors(p_CB) - ball_jacobian(p_CB) * v_CB);
  }
};

Eigen::Matrix2d matrix(double a, double b, double c, double d) {
  Eigen::Matrix2d m;
  m << a, b, c, d;
  return m;
}

ClosedForm cone_form(const ServoGoal& goal) {
  const Eigen::Matrix3d R = goal.mount.X_RC().linear();
  const double l = goal.mount.forward_m;
  const Eigen::Vector3d q0 = R * goal.desired_p_CB();
  return {[=](const Eigen::Vector3d& p) {
            const Eigen::Vector3d q = R * p;
            return Eigen::Vector2d(std::log(q.norm() / q0.norm()),
                                   wrap_angle(std::atan2(q.y(), q.x()) - std::atan2(q0.y(), q0.x())));
          },
          [=](const Eigen::Vector3d& p) {
            const Eigen::Vector3d q = R * p;
            const double a = q.x(), b = q.y(), rho2 = q.squaredNorm(), r2 = a * a + b * b;
            return matrix(-a / rho2, -l * b / rho2, b / r2, -(1 + l * a / r2));
          },
          [=](const Eigen::Vector3d& p) {
            const Eigen::Vector3d q = R * p;
            const double r2 = q.head<2>().squaredNorm();
            Eigen::Matrix<double, 2, 3> by_q;
            by_q << q.transpose() / q.squaredNorm(), -q.y() / r2, q.x() / r2, 0;
            return Eigen::Matrix<double, 2, 3>(by_q * R);
          }};
}

ClosedForm visp_form(const ServoGoal& goal) {
  const Eigen::Vector3d p0 = goal.desired_p_CB();
  const double l = goal.mount.forward_m;
  const double sine = std::sin(goal.mount.pitch_down_rad), cosine = std::cos(goal.mount.pitch_down_rad);
  return {[=](const Eigen::Vector3d& p) {
            return Eigen::Vector2d(p.x() / p.z() - p0.x() / p0.z(), std::log(p.z() / p0.z()));
          },
          [=](const Eigen::Vector3d& p) {
            const double x = p.x() / p.z(), y = p.y() / p.z(), z = p.z();
            return matrix(cosine * x / z, (1 + x * x) * cosine - y * sine + l / z, -cosine / z, -x * cosine);
          },
          [=](const Eigen::Vector3d& p) {
            Eigen::Matrix<double, 2, 3> L;
            L << 1 / p.z(), 0, -p.x() / (p.z() * p.z()), 0, 0, 1 / p.z();
            return L;
          }};
}

ClosedForm sphere_form(const ServoGoal& goal) {
  const Eigen::Matrix3d R = goal.mount.X_RC().linear();
  const double l = goal.mount.forward_m, radius_m = goal.ball_radius_m;
  const Eigen::Vector3d q0 = R * goal.desired_p_CB();
  return {[=](const Eigen::Vector3d& p) { return Eigen::Vector2d((R * p - q0).head<2>() / radius_m); },
          [=](const Eigen::Vector3d& p) {
            const Eigen::Vector3d q = R * p;
            return Eigen::Matrix2d(matrix(-1, q.y(), 0, -(q.x() + l)) / radius_m);
          },
          [=](const Eigen::Vector3d&) { return Eigen::Matrix<double, 2, 3>(R.topRows<2>() / radius_m); }};
}

ClosedForm pose_form(const ServoGoal& goal) {
  const Eigen::Isometry3d X_RC = goal.mount.X_RC();
  const Eigen::Vector3d p0 = goal.desired_p_RB();
  return {[=](const Eigen::Vector3d& p_CB) {
            const Eigen::Vector3d p = X_RC * p_CB;
            return Eigen::Vector2d(p.head<2>().norm() - p0.head<2>().norm(),
                                   wrap_angle(std::atan2(p.y(), p.x()) - std::atan2(p0.y(), p0.x())));
          },
          [=](const Eigen::Vector3d& p_CB) {
            const Eigen::Vector3d p = X_RC * p_CB;
            const double r2 = p.head<2>().squaredNorm();
            return matrix(-p.x() / std::sqrt(r2), 0, p.y() / r2, -1);
          },
          [=](const Eigen::Vector3d& p_CB) {
            const Eigen::Vector3d p = X_RC * p_CB;
            const double r2 = p.head<2>().squaredNorm(), r = std::sqrt(r2);
            Eigen::Matrix<double, 2, 3> by_p_RB;
            by_p_RB << p.x() / r, p.y() / r, 0, -p.y() / r2, p.x() / r2, 0;
            return Eigen::Matrix<double, 2, 3>(by_p_RB * X_RC.linear());
          }};
}

ClosedForm closed_form(const std::string& name, const ServoGoal& goal) {
  if (name == "cone") return cone_form(goal);
  if (name == "visp") return visp_form(goal);
  if (name == "sphere") return sphere_form(goal);
  if (name == "pose") return pose_form(goal);
  throw std::invalid_argument("no closed form of law " + name);
}

Eigen::Vector2d errors_of(Law& law, const Eigen::Vector3d& p_CB) {
  const auto output = law.command(p_CB, {0, 0, 0});
  return output ? Eigen::Vector2d(output->error_1, output->error_2)
                : Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
}

Eigen::Vector3d random_v_CB(RandomEngine& engine, const ServoGoal& goal) {
  return goal.mount.X_RC().linear().transpose() *
         Eigen::Vector3d(uniform(engine, -0.3, 0.3), uniform(engine, -0.3, 0.3), 0);
}

class EveryLaw : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<Law> law(const ServoGoal& goal, double gain_per_s = 1.0) const {
    return builtin_laws().make({GetParam(), gain_per_s}, goal);
  }
};

TEST_P(EveryLaw, CommandsWhatTheClosedFormDoes) {
  RandomEngine engine = random_stream(7, "closed_form");
  for (int i = 0; i < scenes; ++i) {
    const ServoGoal goal = random_goal(engine);
    const double gain = uniform(engine, 0.3, 3.0);
    const Eigen::Vector3d p_CB = in_camera(goal, {}, random_p_RB(engine, goal));
    const ClosedForm form = closed_form(GetParam(), goal);
    for (const Eigen::Vector3d& v_CB : {Eigen::Vector3d(0, 0, 0), random_v_CB(engine, goal)}) {
      const Eigen::Vector2d u = form.command(p_CB, v_CB, gain);
      const auto output = law(goal, gain)->command(p_CB, v_CB);
      ASSERT_TRUE(output);
      EXPECT_NEAR(output->twist.v_mps, u.x(), 1e-11 * (1 + u.norm())) << "scene " << i;
      EXPECT_NEAR(output->twist.w_radps, u.y(), 1e-11 * (1 + u.norm())) << "scene " << i;
      EXPECT_NEAR((errors_of(*law(goal), p_CB) - form.errors(p_CB)).norm(), 0,
                  1e-13 * (1 + form.errors(p_CB).norm()));
    }
  }
}

TEST_P(EveryLaw, AsksForNothingAtTheGoal) {
  RandomEngine engine = random_stream(1, "goal");
  for (int i = 0; i < scenes; ++i) {
    const ServoGoal goal = random_goal(engine);
    const auto output = law(goal)->command(goal.desired_p_CB(), {0, 0, 0});
    ASSERT_TRUE(output);
    EXPECT_NEAR(output->error_1, 0, 1e-12);
    EXPECT_NEAR(output->error_2, 0, 1e-12);
    EXPECT_NEAR(output->twist.v_mps, 0, 1e-11);
    EXPECT_NEAR(output->twist.w_radps, 0, 1e-11);
  }
}

TEST_P(EveryLaw, RobotJacobianIsTheDerivativeOfTheErrorsAlongTheRobotsMotion) {
  RandomEngine engine = random_stream(2, "robot_jacobian");
  for (int i = 0; i < scenes; ++i) {
    const ServoGoal goal = random_goal(engine);
    const Eigen::Vector3d p_WB = random_p_RB(engine, goal);
    const auto a_law = law(goal);
    const Eigen::Matrix2d J = closed_form(GetParam(), goal).robot_jacobian(in_camera(goal, {}, p_WB));
    const double h = 1e-5;
    const Twist2 directions[2] = {{1, 0}, {0, 1}};
    for (int column = 0; column < 2; ++column) {
      const Eigen::Vector2d difference =
          (errors_of(*a_law, in_camera(goal, integrate({}, directions[column], h), p_WB)) -
           errors_of(*a_law, in_camera(goal, integrate({}, directions[column], -h), p_WB))) /
          (2 * h);
      EXPECT_NEAR((J.col(column) - difference).norm(), 0, 1e-7 * (1 + J.norm())) << "scene " << i;
    }
  }
}

TEST_P(EveryLaw, BallJacobianIsTheDerivativeOfTheErrorsByTheBallsPlace) {
  RandomEngine engine = random_stream(3, "ball_jacobian");
  for (int i = 0; i < scenes; ++i) {
    const ServoGoal goal = random_goal(engine);
    const Eigen::Vector3d p_CB = in_camera(goal, {}, random_p_RB(engine, goal));
    const auto a_law = law(goal);
    const auto L = closed_form(GetParam(), goal).ball_jacobian(p_CB);
    const double h = 1e-6;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(axis);
      const Eigen::Vector2d difference =
          (errors_of(*a_law, p_CB + step) - errors_of(*a_law, p_CB - step)) / (2 * h);
      EXPECT_NEAR((L.col(axis) - difference).norm(), 0, 1e-6 * (1 + L.norm())) << "scene " << i;
    }
  }
}

TEST_P(EveryLaw, ErrorsDecayAtTheGain) {
  RandomEngine engine = random_stream(4, "decay");
  for (int i = 0; i < scenes; ++i) {
    const ServoGoal goal = random_goal(engine);
    const Eigen::Vector3d p_WB = random_p_RB(engine, goal);
    const Eigen::Vector3d v_W(uniform(engine, -0.3, 0.3), uniform(engine, -0.3, 0.3), 0);
    const double gain = uniform(engine, 0.3, 3.0), h = 1e-6;
    const auto a_law = law(goal, gain);
    const Eigen::Vector3d p_CB = in_camera(goal, {}, p_WB);
    const Eigen::Vector3d v_CB = goal.mount.X_RC().linear().transpose() * v_W;
    const auto output = a_law->command(p_CB, v_CB);
    ASSERT_TRUE(output);
    const Eigen::Vector2d e = errors_of(*a_law, p_CB);
    const auto at = [&](double t) {
      return errors_of(*a_law, in_camera(goal, integrate({}, output->twist, t), p_WB + t * v_W));
    };
    const Eigen::Vector2d rate = (at(h) - at(-h)) / (2 * h);
    EXPECT_NEAR((rate + gain * e).norm(), 0, 1e-4 * (1 + gain * e.norm())) << "scene " << i;
  }
}

TEST_P(EveryLaw, MirroredBallMirrorsTheTurn) {
  RandomEngine engine = random_stream(5, "mirror");
  for (int i = 0; i < scenes; ++i) {
    const ServoGoal goal = random_goal(engine);
    const auto a_law = law(goal);
    Eigen::Vector3d p_CB = in_camera(goal, {}, random_p_RB(engine, goal));
    const auto left = a_law->command(p_CB, {0, 0, 0});
    p_CB.x() = -p_CB.x();
    const auto right = a_law->command(p_CB, {0, 0, 0});
    ASSERT_TRUE(left && right);
    EXPECT_NEAR(left->twist.v_mps, right->twist.v_mps, 1e-9 * (1 + std::abs(left->twist.v_mps)));
    EXPECT_NEAR(left->twist.w_radps, -right->twist.w_radps, 1e-9 * (1 + std::abs(left->twist.w_radps)));
  }
}

TEST_P(EveryLaw, StaysBoundedOrSilentAroundTheAxle) {
  RandomEngine engine = random_stream(6, "abeam");
  for (int i = 0; i < 20 * scenes; ++i) {
    const ServoGoal goal = random_goal(engine);
    const double side_m = uniform(engine, 0.3, 3.0) * (uniform01(engine) < 0.5 ? -1 : 1);
    const double ahead_m = uniform(engine, -0.1, 0.1);
    const Eigen::Vector3d p_CB = in_camera(goal, {}, {ahead_m, side_m, goal.ball_height_m});
    const auto output = law(goal)->command(p_CB, {0, 0, 0});
    if (ahead_m < min_ahead_m) {
      EXPECT_FALSE(output) << "ahead " << ahead_m;
    } else if (output) {
      // |e| and the adjugate's entries are bounded over these scenes, the determinant by min_ahead_m from
      // below.
      EXPECT_LT(std::abs(output->twist.v_mps), 5e4);
      EXPECT_LT(std::abs(output->twist.w_radps), 5e4);
    }
  }
}

TEST_P(EveryLaw, HasNoAnswerToNonsense) {
  const ServoGoal goal;
  const auto a_law = law(goal);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& p_CB :
       {Eigen::Vector3d(nan, 0, 1), Eigen::Vector3d(0, nan, 1), Eigen::Vector3d(0, 0, nan),
        Eigen::Vector3d(inf, 0, 1), Eigen::Vector3d(0, 0, inf), Eigen::Vector3d(0, 0, 0),
        Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0, 0, 1e300), Eigen::Vector3d(5e-324, 5e-324, 5e-324)}) {
    const auto output = a_law->command(p_CB, {0, 0, 0});
    if (output) {
      EXPECT_TRUE(std::isfinite(output->twist.v_mps) && std::isfinite(output->twist.w_radps))
          << p_CB.transpose();
    }
  }
  EXPECT_FALSE(a_law->command({0, 0, nan}, {0, 0, 0}));
  EXPECT_FALSE(a_law->command(goal.desired_p_CB(), {0, nan, 0}));
}

TEST_P(EveryLaw, StopsWhereItWasTaughtWhateverDiameterAndFocalLengthItBelieves) {
  RandomEngine engine = random_stream(9, "taught");
  for (int i = 0; i < scenes; ++i) {
    const ServoGoal truth = random_goal(engine);
    // A wrong diameter scales what is seen, a wrong focal length squeezes it along the axis.
    const double scale = uniform(engine, 0.8, 1.2), squeeze = uniform(engine, 0.9, 1.1);
    const auto seen = [&](const Eigen::Vector3d& p_CB) {
      return Eigen::Vector3d(scale * p_CB.x(), scale * p_CB.y(), scale * squeeze * p_CB.z());
    };
    ServoGoal believed = truth;
    believed.ball_radius_m *= scale;
    believed.taught_center_over_radius = seen(truth.desired_p_CB()) / believed.ball_radius_m;
    const auto at_goal = law(believed)->command(seen(truth.desired_p_CB()), {0, 0, 0});
    ASSERT_TRUE(at_goal);
    EXPECT_NEAR(at_goal->twist.v_mps, 0, 1e-10);
    EXPECT_NEAR(at_goal->twist.w_radps, 0, 1e-10);
    // Further away it drives on, nearer it backs off.
    ServoGoal far = truth, near = truth;
    far.distance_m += 0.05;
    near.distance_m -= 0.05;
    EXPECT_GT(law(believed)->command(seen(far.desired_p_CB()), {0, 0, 0})->twist.v_mps, 0);
    EXPECT_LT(law(believed)->command(seen(near.desired_p_CB()), {0, 0, 0})->twist.v_mps, 0);
  }
}

/// What a robot believes of ball and camera: times what is true, and more than it.
struct Belief {
  double diameter_scale, focal_scale, pitch_error_rad;
  double least_rate, greatest_rate;  // in gains, of every law
};

// With V = |e|^2 / 2, dV/dt = -2 gain rate V: stable where rate > 0, which is e' L L^+ e / e' e, with the
// interaction matrix L as it is and L^+ as believed (Chaumette and Hutchinson, "Visual servo control, part
// I", IEEE RAM 13(4), 2006, on the stability of image-based servoing).
TEST_P(EveryLaw, ALyapunovFunctionFallsInTheWholeViewWhateverIsBelieved) {
  for (const Belief& belief :
       {Belief{1, 1, 0, 0.9999, 1.0001}, Belief{0.4, 1, 0, 0.33, 1.02}, Belief{3, 1, 0, 0.41, 3.25},
        Belief{1, 0.5, 0, 0.42, 2.25}, Belief{1, 2, 0, 0.53, 2.05}, Belief{1, 1, -0.2, 0.91, 1.02},
        Belief{1, 1, 0.2, 0.97, 1.16}}) {
    ServoGoal truth;
    truth.mount = {0.10, 0.28, 0.21};
    const auto seen = [&](const Eigen::Vector3d& p_CB) -> Eigen::Vector3d {
      return belief.diameter_scale * Eigen::Vector3d(p_CB.x(), p_CB.y(), belief.focal_scale * p_CB.z());
    };
    ServoGoal goal = truth;
    goal.mount.pitch_down_rad += belief.pitch_error_rad;
    goal.ball_radius_m *= belief.diameter_scale;
    goal.taught_center_over_radius = seen(truth.desired_p_CB()) / goal.ball_radius_m;
    const auto a_law = law(goal);
    double least = 1e9, greatest = -1e9;
    for (double range_m = 0.5; range_m <= 5; range_m += 0.25) {
      for (double bearing_rad = -0.5; bearing_rad <= 0.5; bearing_rad += 0.05) {
        const Eigen::Vector3d p_WB(range_m * std::cos(bearing_rad), range_m * std::sin(bearing_rad), 0.06);
        const auto output = a_law->command(seen(in_camera(truth, {}, p_WB)), {0, 0, 0});
        ASSERT_TRUE(output);
        const auto errors_after = [&](double t) {
          return errors_of(*a_law, seen(in_camera(truth, integrate({}, output->twist, t), p_WB)));
        };
        const double h = 1e-6;
        const Eigen::Vector2d e = errors_after(0), change = (errors_after(h) - errors_after(-h)) / (2 * h);
        if (e.norm() < 1e-3) continue;
        least = std::min(least, -e.dot(change) / e.squaredNorm());
        greatest = std::max(greatest, -e.dot(change) / e.squaredNorm());
      }
    }
    EXPECT_GT(least, belief.least_rate) << belief.diameter_scale << " " << belief.focal_scale;
    EXPECT_LT(greatest, belief.greatest_rate) << belief.diameter_scale << " " << belief.focal_scale;
  }
}

TEST_P(EveryLaw, IsSingularExactlyAbeamOfTheAxle) {
  RandomEngine engine = random_stream(11, "determinant");
  for (int i = 0; i < scenes; ++i) {
    const ServoGoal goal = random_goal(engine);
    const Eigen::Vector3d p = in_camera(goal, {}, random_p_RB(engine, goal));
    const double ahead_m = ahead_of_axle_m(goal.mount, p), range_m = (goal.mount.X_RC() * p).head<2>().norm();
    const std::map<std::string, double> determinants{
        {"cone", ahead_m / p.squaredNorm()},
        {"visp", std::cos(goal.mount.pitch_down_rad) * ahead_m / (p.z() * p.z())},
        {"sphere", ahead_m / (goal.ball_radius_m * goal.ball_radius_m)},
        {"pose", ahead_m / range_m}};
    const Eigen::Matrix2d J = closed_form(GetParam(), goal).robot_jacobian(p);
    EXPECT_NEAR(J.determinant(), determinants.at(GetParam()), 1e-12 * J.squaredNorm());
  }
}

TEST_P(EveryLaw, PrintsNothing) {
  RandomEngine engine = random_stream(12, "silent");
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  for (int i = 0; i < scenes; ++i) {
    const ServoGoal goal = random_goal(engine);
    const auto a_law = law(goal);
    for (int step = 0; step < 3; ++step) {
      a_law->command(in_camera(goal, {}, random_p_RB(engine, goal)), random_v_CB(engine, goal));
      a_law->command({uniform(engine, -2, 2), uniform(engine, -2, 2), uniform(engine, -2, 2)}, {0, 0, 0});
      a_law->command({0, 0, uniform(engine, -1e-3, 1e-3)}, {0, 0, 0});
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

INSTANTIATE_TEST_SUITE_P(Laws, EveryLaw, testing::ValuesIn(builtin_laws().names()),
                         [](const auto& tested) { return tested.param; });

TEST(ConeLaw, DependsOnTheDirectionAndTheRatioOfDistancesAlone) {
  // The same picture of a ball of twice the size: all lengths doubled but the lever arm's, which is 0 here.
  ServoGoal goal;
  goal.mount.forward_m = 0;
  ServoGoal twice = goal;
  twice.distance_m *= 2;
  twice.mount.up_m *= 2;
  twice.ball_height_m *= 2;
  const auto law = builtin_laws().make({}, goal), law_of_twice = builtin_laws().make({}, twice);
  RandomEngine engine = random_stream(8, "scale");
  for (int i = 0; i < scenes; ++i) {
    const Eigen::Vector3d p_CB = in_camera(goal, {}, random_p_RB(engine, goal));
    EXPECT_NEAR((errors_of(*law, p_CB) - errors_of(*law_of_twice, 2 * p_CB)).norm(), 0, 1e-12);
  }
}

TEST(SphereLaw, TheThirdFeatureNeverChanges) {
  // Why two of the three suffice: levelled, the ball's height over the camera is what no motion moves.
  RandomEngine engine = random_stream(10, "third");
  for (int i = 0; i < scenes; ++i) {
    const ServoGoal goal = random_goal(engine);
    const Eigen::Vector3d p_WB = random_p_RB(engine, goal);
    const Pose2 after =
        integrate({}, {uniform(engine, -1, 1), uniform(engine, -1, 1)}, uniform(engine, 0, 1));
    const Eigen::Matrix3d R_RC = goal.mount.X_RC().linear();
    EXPECT_NEAR((R_RC * in_camera(goal, {}, p_WB)).z(), (R_RC * in_camera(goal, after, p_WB)).z(), 1e-12);
  }
}

TEST(MaxStableGain, IsWhereTheDelayedLoopTurnsUnstable) {
  const double rate_hz = 50;
  for (const int periods : {0, 1, 2, 3, 5, 10}) {
    const double limit = max_stable_gain_per_s(rate_hz, periods / rate_hz);
    const auto last_error = [&](double gain_per_s) {
      std::vector<double> e(static_cast<std::size_t>(periods) + 1, 1.0);
      while (e.size() < 20000 && std::abs(e.back()) < 1e6) {
        e.push_back(e.back() - gain_per_s / rate_hz * e[e.size() - 1 - static_cast<std::size_t>(periods)]);
      }
      return std::abs(e.back());
    };
    EXPECT_LT(last_error(0.98 * limit), 1e-3) << periods;
    EXPECT_GT(last_error(1.02 * limit), 1e3) << periods;
  }
  EXPECT_DOUBLE_EQ(max_stable_gain_per_s(30, 0.01), max_stable_gain_per_s(30, 1.0 / 30));
}

TEST(LawCatalog, NamesEveryFaultOfOptionsAndGoal) {
  LawOptions options;
  options.name = "sonar";
  options.gain_per_s = std::numeric_limits<double>::quiet_NaN();
  ServoGoal goal;
  goal.distance_m = -1;
  goal.mount.up_m = 0;
  goal.ball_radius_m = 0;
  goal.taught_center_over_radius = Eigen::Vector3d(0, 0, -3);
  try {
    builtin_laws().make(options, goal);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.faults().size(), 6u) << error.what();
  }
}

TEST(VispLaw, RefusesAGoalBehindTheCamera) {
  LawOptions options;
  options.name = "visp";
  ServoGoal goal;
  goal.mount.forward_m = 2.0;
  EXPECT_THROW(builtin_laws().make(options, goal), InputError);
}

/// Always the same twist.
class SteadyLaw final : public Law {
 public:
  explicit SteadyLaw(double v_mps) : v_mps_(v_mps) {}
  std::optional<LawOutput> command(const Eigen::Vector3d&, const Eigen::Vector3d&) override {
    return LawOutput{{v_mps_, 0}, 0, 0};
  }

 private:
  double v_mps_;
};

TEST(LawCatalog, HoldsAProgramsOwnLawsBesideOurs) {
  LawCatalog laws = builtin_laws();
  laws.add("steady", [](const LawOptions& options, const ServoGoal& goal) {
    return std::make_unique<SteadyLaw>(options.gain_per_s * goal.distance_m);
  });
  EXPECT_EQ(laws.names(), (std::vector<std::string>{"cone", "visp", "sphere", "pose", "steady"}));
  ServoGoal goal;
  goal.distance_m = 0.5;
  EXPECT_EQ(laws.make({"steady", 3.0}, goal)->command({}, {})->twist.v_mps, 1.5);
  EXPECT_THROW(builtin_laws().make({"steady", 3.0}, goal), InputError) << "another catalog";

  laws.add("cone", [](const LawOptions&, const ServoGoal&) { return std::make_unique<SteadyLaw>(7.0); });
  EXPECT_EQ(laws.names().size(), 5u);
  EXPECT_EQ(laws.make({}, goal)->command({}, {})->twist.v_mps, 7.0) << "replaced";
}

}  // namespace
}  // namespace ballservo
