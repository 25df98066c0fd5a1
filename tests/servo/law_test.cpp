#include <gtest/gtest.h>

#include <cmath>

#include "servo/features/builtin_laws.hpp"
#include "servo/features/feature_law.hpp"
#include "tests/servo/random_scene.hpp"

namespace ballservo {
namespace {

using test::in_camera;
using test::random_goal;
using test::random_p_RB;

constexpr int scenes = 300;

std::unique_ptr<FeatureLaw> feature_law(const LawOptions& options, const ServoGoal& goal) {
  return std::unique_ptr<FeatureLaw>(dynamic_cast<FeatureLaw*>(builtin_laws().make(options, goal).release()));
}

class EveryLaw : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<FeatureLaw> law(const ServoGoal& goal, double gain_per_s = 1.0) const {
    return feature_law({GetParam(), gain_per_s}, goal);
  }
};

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
    const auto J = a_law->robot_jacobian(in_camera(goal, {}, p_WB));
    ASSERT_TRUE(J);
    const double h = 1e-5;
    const Twist2 directions[2] = {{1, 0}, {0, 1}};
    for (int column = 0; column < 2; ++column) {
      const auto after = a_law->errors(in_camera(goal, integrate({}, directions[column], h), p_WB));
      const auto before = a_law->errors(in_camera(goal, integrate({}, directions[column], -h), p_WB));
      const Eigen::Vector2d difference = (*after - *before) / (2 * h);
      EXPECT_NEAR((J->col(column) - difference).norm(), 0, 1e-7 * (1 + J->norm())) << "scene " << i;
    }
  }
}

TEST_P(EveryLaw, BallJacobianIsTheDerivativeOfTheErrorsByTheBallsPlace) {
  RandomEngine engine = random_stream(3, "ball_jacobian");
  for (int i = 0; i < scenes; ++i) {
    const ServoGoal goal = random_goal(engine);
    const Eigen::Vector3d p_CB = in_camera(goal, {}, random_p_RB(engine, goal));
    const auto a_law = law(goal);
    const auto L = a_law->ball_jacobian(p_CB);
    ASSERT_TRUE(L);
    const double h = 1e-6;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(axis);
      const Eigen::Vector2d difference =
          (*a_law->errors(p_CB + step) - *a_law->errors(p_CB - step)) / (2 * h);
      EXPECT_NEAR((L->col(axis) - difference).norm(), 0, 1e-6 * (1 + L->norm())) << "scene " << i;
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
    const Eigen::Vector2d e = *a_law->errors(p_CB);
    const auto at = [&](double t) {
      return *a_law->errors(in_camera(goal, integrate({}, output->twist, t), p_WB + t * v_W));
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

INSTANTIATE_TEST_SUITE_P(Laws, EveryLaw, testing::ValuesIn(builtin_laws().names()),
                         [](const auto& tested) { return tested.param; });

// What vpServo's own matrices give is the closed form of visp_law.hpp.
TEST(VispLaw, IsTheClosedForm) {
  RandomEngine engine = random_stream(7, "closed_form");
  for (int i = 0; i < scenes; ++i) {
    const ServoGoal goal = random_goal(engine);
    LawOptions options;
    options.name = "visp";
    options.gain_per_s = 0.7;
    const auto law = feature_law(options, goal);
    const Eigen::Vector3d p = in_camera(goal, {}, random_p_RB(engine, goal));
    const double x = p.x() / p.z(), y = p.y() / p.z(), z = p.z(), l = goal.mount.forward_m;
    const double s = std::sin(goal.mount.pitch_down_rad), c = std::cos(goal.mount.pitch_down_rad);
    Eigen::Matrix2d J;
    J << c * x / z, (1 + x * x) * c - y * s + l / z,  //
        -c / z, -x * c;
    EXPECT_NEAR((*law->robot_jacobian(p) - J).norm(), 0, 1e-12 * J.norm());
    EXPECT_NEAR(J.determinant(), c * ahead_of_axle_m(goal.mount, p) / (z * z), 1e-12 * J.squaredNorm());
    const Eigen::Vector3d desired = goal.desired_p_CB();
    const Eigen::Vector2d e(x - desired.x() / desired.z(), std::log(z / desired.z()));
    const Eigen::Vector2d u = -0.7 * J.inverse() * e;
    const auto output = law->command(p, {0, 0, 0});
    ASSERT_TRUE(output);
    EXPECT_NEAR(output->twist.v_mps, u.x(), 1e-9 * (1 + u.norm()));
    EXPECT_NEAR(output->twist.w_radps, u.y(), 1e-9 * (1 + u.norm()));
  }
}

TEST(ConeLaw, DependsOnTheDirectionAndTheRatioOfDistancesAlone) {
  // The same picture of a ball of twice the size: all lengths doubled but the lever arm's, which is 0 here.
  ServoGoal goal;
  goal.mount.forward_m = 0;
  ServoGoal twice = goal;
  twice.distance_m *= 2;
  twice.mount.up_m *= 2;
  twice.ball_height_m *= 2;
  const auto law = feature_law({}, goal), law_of_twice = feature_law({}, twice);
  RandomEngine engine = random_stream(8, "scale");
  for (int i = 0; i < scenes; ++i) {
    const Eigen::Vector3d p_CB = in_camera(goal, {}, random_p_RB(engine, goal));
    EXPECT_NEAR((*law->errors(p_CB) - *law_of_twice->errors(2 * p_CB)).norm(), 0, 1e-12);
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
