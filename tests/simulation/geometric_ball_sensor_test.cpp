#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "calibration/base/fault.hpp"
#include "servo/simulation/robot/geometric_sensors.hpp"
#include "tests/simulation/dark_room.hpp"

namespace ballservo {
namespace {

BallTruth ball_at(const Eigen::Vector3d& p_C) {
  World world = test::dark_room();
  world.balls = {test::white_ball(test::level_view() * p_C, 0.12)};
  return ball_truth(test::lens(LensModel::brown), world, {test::level_view(), 0}).front();
}

GeometricBallSensor sensor(const GeometricSensorOptions& options, int seed) {
  static const Camera camera = test::lens(LensModel::brown);  // takes longer to make than to use
  return {camera, options, static_cast<std::uint64_t>(seed)};
}

TEST(GeometricBallSensor, ErrorsAreThoseThatTheCovarianceSays) {
  const BallTruth truth = ball_at({0.4, 0.2, 2.0});
  double mahalanobis = 0;
  constexpr int count = 3000;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int seed = 0; seed < count; ++seed) {
    const BallMeasurement m = sensor({}, seed).measure(truth, 0.12, 0.5, 7);
    ASSERT_TRUE(m.is_sighting());
    const Eigen::Vector3d error = m.p_CB - truth.p_CB;
    mahalanobis += error.dot(m.covariance_m2.inverse() * error);
    mean += error / count;
  }
  EXPECT_NEAR(mahalanobis / count, 3.0, 0.15);
  EXPECT_LT(mean.norm(), 2e-3);
}

TEST(GeometricBallSensor, TheShareOfTheBiasStaysThroughoutARun) {
  const BallTruth truth = ball_at({0.4, 0.2, 2.0});
  for (const double share : {0.0, 0.4, 1.0}) {
    GeometricSensorOptions options;
    options.bias_share = share;
    double lasting = 0, all = 0;
    for (int seed = 0; seed < 1000; ++seed) {
      const GeometricBallSensor run = sensor(options, seed);
      const double first = (run.measure(truth, 0.12, 0, 3).p_CB - truth.p_CB).z();
      const double second = (run.measure(truth, 0.12, 1, 33).p_CB - truth.p_CB).z();
      lasting += first * second;
      all += 0.5 * (first * first + second * second);
    }
    EXPECT_NEAR(lasting / all, share, 0.1);
  }
}

TEST(GeometricBallSensor, ExactWhereAsked) {
  GeometricSensorOptions options;
  options.exact = true;
  const BallTruth truth = ball_at({0.4, 0.2, 2.0});
  EXPECT_EQ(sensor(options, 1).measure(truth, 0.12, 0, 2).p_CB, truth.p_CB);
}

TEST(GeometricBallSensor, SeesNothingWhereNothingIsSeen) {
  const GeometricBallSensor eye = sensor({}, 1);
  BallTruth truth = ball_at({5, 0, 2.0});
  EXPECT_FALSE(eye.measure(truth, 0.12, 0, 2).is_sighting());
  truth = ball_at({0, 0, 2.0});
  EXPECT_TRUE(eye.measure(truth, 0.12, 0, 2).is_sighting());
  truth.visible_fraction = 0.3;
  EXPECT_FALSE(eye.measure(truth, 0.12, 0, 2).is_sighting());
  truth = ball_at({0, 0, 12.0});  // 2.4 px
  EXPECT_FALSE(eye.measure(truth, 0.12, 0, 2).is_sighting());
}

TEST(GeometricBallSensor, RefusesOptionsThatCannotBe) {
  GeometricSensorOptions options;
  options.center_sigma_px = -1;
  options.bias_share = 1.1;
  options.min_visible_fraction = 2;
  try {
    sensor(options, 1);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.faults().size(), 3u);
  }
}

}  // namespace
}  // namespace ballservo
