#include "servo/simulation/geometric_ball_sensor.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "calibration/files/fault.hpp"
#include "tests/simulation/dark_room.hpp"

namespace ballservo {
namespace {

BallTruth ball_at(const Eigen::Vector3d& p_C) {
  World world = test::dark_room();
  world.balls = {test::white_ball(test::level_view() * p_C, 0.12)};
  return ball_truth(test::lens(LensModel::brown), world, {test::level_view(), 0}).front();
}

TEST(GeometricBallSensor, ErrorsAreThoseThatTheCovarianceSays) {
  const BallTruth truth = ball_at({0.4, 0.2, 2.0});
  const GeometricBallSensor sensor(test::lens(LensModel::brown), {});
  double mahalanobis = 0;
  constexpr int count = 3000;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int k = 0; k < count; ++k) {
    const BallMeasurement m = sensor.measure(truth, 0.12, 0.5, 11, static_cast<std::uint64_t>(k));
    ASSERT_TRUE(m.is_sighting());
    const Eigen::Vector3d error = m.p_CB - truth.p_CB;
    mahalanobis += error.dot(m.covariance_m2.inverse() * error);
    mean += error / count;
  }
  EXPECT_NEAR(mahalanobis / count, 3.0, 0.15);
  EXPECT_LT(mean.norm(), 1e-3);
}

TEST(GeometricBallSensor, ExactWhereAsked) {
  GeometricSensorOptions options;
  options.exact = true;
  const BallTruth truth = ball_at({0.4, 0.2, 2.0});
  EXPECT_EQ(GeometricBallSensor(test::lens(LensModel::brown), options).measure(truth, 0.12, 0, 1, 2).p_CB,
            truth.p_CB);
}

TEST(GeometricBallSensor, SeesNothingWhereNothingIsSeen) {
  const GeometricBallSensor sensor(test::lens(LensModel::brown), {});
  BallTruth truth = ball_at({5, 0, 2.0});
  EXPECT_FALSE(sensor.measure(truth, 0.12, 0, 1, 2).is_sighting());
  truth = ball_at({0, 0, 2.0});
  EXPECT_TRUE(sensor.measure(truth, 0.12, 0, 1, 2).is_sighting());
  truth.visible_fraction = 0.3;
  EXPECT_FALSE(sensor.measure(truth, 0.12, 0, 1, 2).is_sighting());
  truth = ball_at({0, 0, 12.0});  // 2.4 px
  EXPECT_FALSE(sensor.measure(truth, 0.12, 0, 1, 2).is_sighting());
}

TEST(GeometricBallSensor, RefusesOptionsThatCannotBe) {
  GeometricSensorOptions options;
  options.center_sigma_px = -1;
  options.min_visible_fraction = 2;
  try {
    GeometricBallSensor(test::lens(LensModel::pinhole), options);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.faults().size(), 2u);
  }
}

}  // namespace
}  // namespace ballservo
