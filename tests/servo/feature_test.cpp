// The ball as ViSP's visual features: interaction matrices against finite differences, and what vpServo asks
// of a feature.
#include <gtest/gtest.h>
#include <visp3/core/vpExponentialMap.h>
#include <visp3/core/vpHomogeneousMatrix.h>
#include <visp3/visual_features/vpFeatureException.h>
#include <visp3/vs/vpServo.h>

#include <functional>
#include <memory>

#include "servo/features/ball_feature.hpp"
#include "tests/servo/random_scene.hpp"

namespace ballservo {
namespace {

using test::random_goal;

constexpr int feature_scenes = 300;

struct FeatureCase {
  std::string name;
  std::function<std::unique_ptr<BallFeature>(const ServoGoal&)> make;
};

class EveryFeature : public testing::TestWithParam<FeatureCase> {};

Eigen::Vector3d random_p_CB(RandomEngine& engine) {
  return {uniform(engine, -2, 2), uniform(engine, -1, 1), uniform(engine, 0.3, 5)};
}

/// Where the ball is in the camera's frame after the camera has moved for a while at (v, w), by ViSP's
/// exponential map.
Eigen::Vector3d seen_after(const Eigen::Vector3d& p_CB, const vpColVector& camera_velocity, double time_s) {
  const vpHomogeneousMatrix moved = vpExponentialMap::direct(camera_velocity, time_s).inverse();
  Eigen::Vector3d p;
  for (unsigned int i = 0; i < 3; ++i)
    p[i] = moved[i][0] * p_CB.x() + moved[i][1] * p_CB.y() + moved[i][2] * p_CB.z() + moved[i][3];
  return p;
}

TEST_P(EveryFeature, InteractionMatrixIsTheDerivativeAlongTheCamerasSixVelocities) {
  RandomEngine engine = random_stream(1, "interaction");
  for (int i = 0; i < feature_scenes; ++i) {
    const ServoGoal goal = random_goal(engine);
    const Eigen::Vector3d p_CB = random_p_CB(engine);
    const auto feature = GetParam().make(goal), after = GetParam().make(goal), before = GetParam().make(goal);
    feature->buildFrom(p_CB);
    const vpMatrix L = feature->interaction();
    ASSERT_EQ(L.getRows(), 3u);
    ASSERT_EQ(L.getCols(), 6u);
    const double h = 1e-4;
    for (unsigned int dof = 0; dof < 6; ++dof) {
      vpColVector velocity(6);
      velocity[dof] = 1;
      // Richardson's extrapolation of two central differences.
      vpColVector slope[2];
      for (int k = 0; k < 2; ++k) {
        const double step = h * (k + 1);
        after->buildFrom(seen_after(p_CB, velocity, step));
        before->buildFrom(seen_after(p_CB, velocity, -step));
        slope[k] = after->error(*before) / (2 * step);
      }
      const vpColVector derivative = slope[0] * (4.0 / 3) - slope[1] * (1.0 / 3);
      for (unsigned int row = 0; row < 3; ++row)
        EXPECT_NEAR(L[row][dof], derivative[row], 1e-6 * (1 + std::abs(derivative[row])))
            << "scene " << i << " dof " << dof;
    }
  }
}

TEST_P(EveryFeature, SelectsRowsInTheirOrder) {
  RandomEngine engine = random_stream(2, "select");
  const ServoGoal goal = random_goal(engine);
  const auto s = GetParam().make(goal), desired = GetParam().make(goal);
  s->buildFrom(random_p_CB(engine));
  desired->buildFrom(random_p_CB(engine));
  const vpMatrix L = s->interaction();
  const vpColVector e = s->error(*desired), value = s->get_s();
  for (unsigned int select = 1; select < 8; ++select) {
    const vpMatrix rows = s->interaction(select);
    const vpColVector some = s->error(*desired, select), values = s->get_s(select);
    ASSERT_EQ(rows.getRows(), s->getDimension(select));
    ASSERT_EQ(some.size(), s->getDimension(select));
    unsigned int filled = 0;
    for (unsigned int row = 0; row < 3; ++row) {
      if ((select & vpBasicFeature::FEATURE_LINE[row]) == 0) continue;
      EXPECT_EQ(some[filled], e[row]);
      EXPECT_EQ(values[filled], value[row]);
      for (unsigned int column = 0; column < 6; ++column) EXPECT_EQ(rows[filled][column], L[row][column]);
      ++filled;
    }
  }
}

// vpServo duplicates a feature that is given without a desired one, and empties the copy.
TEST_P(EveryFeature, ServesInATaskWithoutADesiredFeature) {
  RandomEngine engine = random_stream(3, "duplicate");
  const auto s = GetParam().make(random_goal(engine));
  s->buildFrom(random_p_CB(engine));
  std::unique_ptr<vpBasicFeature> copy(s->duplicate());
  EXPECT_EQ(copy->get_s(), s->get_s());
  EXPECT_EQ(copy->interaction(), s->interaction());
  vpServo task;  // not vpServo(type): ViSP 3.5 leaves the threshold of the pseudo-inverse uninitialised there
  task.setServo(vpServo::EYEINHAND_CAMERA);
  task.setInteractionMatrixType(vpServo::CURRENT);
  task.addFeature(*s);
  EXPECT_EQ(task.computeError(), s->get_s());
  task.kill();
}

TEST_P(EveryFeature, AnswersInWordsToWhatItIsNotDefinedFor) {
  const auto s = GetParam().make({});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  testing::internal::CaptureStdout();
  EXPECT_THROW(s->buildFrom({nan, 0, 1}), vpFeatureException);
  vpColVector wrong(2);
  const auto other = GetParam().make({});
  s->buildFrom({0.1, 0.2, 1});
  EXPECT_NO_THROW(s->error(*other));
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "") << "prints unasked";
  testing::internal::CaptureStdout();
  s->print();
  EXPECT_NE(testing::internal::GetCapturedStdout(), "");
}

INSTANTIATE_TEST_SUITE_P(
    Features, EveryFeature,
    testing::Values(
        FeatureCase{"cone", [](const ServoGoal&) { return std::make_unique<ConeFeature>(); }},
        FeatureCase{
            "cone_levelled",
            [](const ServoGoal& goal) { return std::make_unique<ConeFeature>(goal.mount.X_RC().linear()); }},
        FeatureCase{
            "sphere",
            [](const ServoGoal& goal) { return std::make_unique<SphereFeature>(goal.ball_radius_m); }},
        FeatureCase{"sphere_levelled",
                    [](const ServoGoal& goal) {
                      return std::make_unique<SphereFeature>(goal.ball_radius_m, goal.mount.X_RC().linear());
                    }},
        FeatureCase{"floor",
                    [](const ServoGoal& goal) { return std::make_unique<FloorFeature>(goal.mount.X_RC()); }}),
    [](const auto& tested) { return tested.param.name; });

TEST(ConeFeature, TheBallsSizeCancelsInTheError) {
  // The same picture of a ball of twice the size: twice as far.
  RandomEngine engine = random_stream(4, "size");
  for (int i = 0; i < feature_scenes; ++i) {
    const Eigen::Vector3d p_CB = random_p_CB(engine), desired_p_CB = random_p_CB(engine);
    ConeFeature s, desired, s_of_twice, desired_of_twice;
    s.buildFrom(p_CB);
    desired.buildFrom(desired_p_CB);
    s_of_twice.buildFrom(2 * p_CB);
    desired_of_twice.buildFrom(2 * desired_p_CB);
    EXPECT_NEAR((s.error(desired) - s_of_twice.error(desired_of_twice)).frobeniusNorm(), 0, 1e-14);
  }
}

TEST(ConeFeature, IsThatOfTheConeThatTouchesTheBall) {
  const double radius_m = 0.06, half_angle_rad = 0.1;
  ConeFeature s, desired;
  s.buildFrom(radius_m / std::sin(half_angle_rad) * Eigen::Vector3d::UnitZ());
  desired.buildFrom(radius_m / std::sin(2 * half_angle_rad) *
                    Eigen::Vector3d(0, std::sin(-0.3), std::cos(0.3)));
  const vpColVector e = s.error(desired);
  EXPECT_NEAR(e[0], std::log(std::sin(2 * half_angle_rad) / std::sin(half_angle_rad)), 1e-14);
  EXPECT_NEAR(e[1], 0, 1e-14);
  EXPECT_NEAR(e[2], -0.3, 1e-14) << "the ball was to be 0.3 rad above the axis";
}

TEST(ConeFeature, AzimuthErrorsTurnTheShorterWay) {
  ConeFeature s, desired;
  s.buildFrom({0.1, 0, -1});
  desired.buildFrom({-0.1, 0, -1});
  EXPECT_NEAR(s.error(desired)[1], 2 * std::atan(0.1), 1e-12);
}

TEST(ConeFeature, IsNotDefinedStraightAboveTheCamera) {
  ConeFeature s;
  EXPECT_FALSE(s.defined_at({0, -1, 0}));
  EXPECT_THROW(s.buildFrom({0, -1, 0}), vpFeatureException);
}

TEST(SphereFeature, HasTheMatrixOfThePaper) {
  RandomEngine engine = random_stream(5, "paper");
  for (int i = 0; i < feature_scenes; ++i) {
    const double radius_m = uniform(engine, 0.02, 0.3);
    const Eigen::Vector3d p = random_p_CB(engine), o = p / radius_m;
    SphereFeature s(radius_m);
    s.buildFrom(p);
    const double paper[3][6] = {{-1 / radius_m, 0, 0, 0, -o.z(), o.y()},
                                {0, -1 / radius_m, 0, o.z(), 0, -o.x()},
                                {0, 0, -1 / radius_m, -o.y(), o.x(), 0}};
    const vpMatrix L = s.interaction();
    for (unsigned int row = 0; row < 3; ++row) {
      EXPECT_NEAR(s[row], o[row], 1e-14 * o.norm());
      for (unsigned int column = 0; column < 6; ++column)
        EXPECT_NEAR(L[row][column], paper[row][column], 1e-12 * o.norm());
    }
  }
}

}  // namespace
}  // namespace ballservo
