// The filter of a ball's motion: what it predicts, and whether its covariance says how well.
#include "perception/tracking/track_filter.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "calibration/base/random.hpp"

namespace ballservo {
namespace {

constexpr double dt_s = 1.0 / 30;

TEST(TrackFilter, MeasurementsOfAStandstillGiveItsPlaceAndNoVelocity) {
  BallFeatures features{{0.2, -0.1, 3}, {0.001, 0.001, 0.01}};
  TrackFilter filter(features, 0);
  for (int k = 1; k < 60; ++k) {
    filter.predict(k * dt_s);
    EXPECT_LT(filter.distance2(features), 1);
    filter.correct(features);
  }
  EXPECT_LT((filter.value() - features.value).norm(), 1e-6);
  EXPECT_GT(filter.variance().minCoeff(), 0);
  filter.predict(59 * dt_s + 1);
  EXPECT_LT((filter.value() - features.value).norm(), 1e-4);
}

TEST(TrackFilter, FeaturesAndConeAreTheSameThing) {
  BallObservation ball;
  ball.cone = *TangentCone::of_sphere({0.3, -0.2, 1.1}, 0.05);
  const BallFeatures features = features_of(ball);
  const TangentCone cone = cone_of(features.value);
  EXPECT_LT((cone.axis - ball.cone.axis).norm(), 1e-12);
  EXPECT_NEAR(cone.alpha_rad, ball.cone.alpha_rad, 1e-12);
  EXPECT_LT((position_of(features.value, {0, 0, 0}, {0.05, 0}).p_C - Eigen::Vector3d(0.3, -0.2, 1.1)).norm(),
            1e-12);
}

Eigen::Vector3d normal_vector(RandomEngine& engine) {
  return {standard_normal(engine), standard_normal(engine), standard_normal(engine)};
}

/// A ball whose acceleration is another one every `lasts_s`, in the filter's own quantities.
class Wanderer {
 public:
  Wanderer(double radius, RandomEngine& engine)
      : engine_(engine),
        sigma_(acceleration_radii_s2 * radius, acceleration_radii_s2 * radius, 0),
        velocity_(5 * radius * standard_normal(engine), 5 * radius * standard_normal(engine), 0),
        value_(0.1, -0.05, -std::log(radius)) {}

  void go_on(double duration_s) {
    constexpr double step_s = 1.0 / 300;
    for (double done_s = 0; done_s < duration_s - 1e-9; done_s += step_s) {
      if (held_s_ <= 1e-9)
        acceleration_ = sigma_.cwiseProduct(normal_vector(engine_)), held_s_ = acceleration_lasts_s;
      value_ += step_s * velocity_ + 0.5 * step_s * step_s * acceleration_;
      velocity_ += step_s * acceleration_;
      held_s_ -= step_s;
    }
  }
  BallFeatures measured(const Eigen::Vector3d& sigma) {
    return {value_ + sigma.cwiseProduct(normal_vector(engine_)), sigma};
  }
  const Eigen::Vector3d& value() const { return value_; }

 private:
  RandomEngine& engine_;
  double held_s_ = 0;
  Eigen::Vector3d sigma_, velocity_, value_, acceleration_{0, 0, 0};
};

/// Mean squared error of a prediction over its variance, across the picture (1: honest), after half a second
/// of pictures and then `unseen_s` without, over many motions.
double normalized_error(double rate_hz, double unseen_s) {
  constexpr int motions = 400;
  constexpr double radius = 0.05;
  RandomEngine engine = random_stream(5, "wanderers");
  const Eigen::Vector3d sigma(0.03 * radius, 0.03 * radius, 0.03);
  double sum = 0;
  for (int motion = 0; motion < motions; ++motion) {
    Wanderer ball(radius, engine);
    TrackFilter filter(ball.measured(sigma), 0);
    double time_s = 0;
    const auto next = [&] {
      ball.go_on(1 / rate_hz);
      filter.predict(time_s += 1 / rate_hz);
    };
    while (time_s < 0.5 - 1e-9) next(), filter.correct(ball.measured(sigma));
    while (time_s < 0.5 + unseen_s - 1e-9) next();
    const Eigen::Vector3d error = ball.value() - filter.value(), variance = filter.variance();
    sum += 0.5 * (error.x() * error.x() / variance.x() + error.y() * error.y() / variance.y()) / motions;
  }
  return sum;
}

TEST(TrackFilter, ThePredictionsCovarianceIsTheirErrorAtAnyRate) {
  // 800 squared normal draws: their mean has a sigma of 5 %. Held for a while, an acceleration moves the ball
  // less within that while than white noise does: by 3/4 of its variance.
  for (const double rate_hz : {15.0, 30.0, 60.0}) {
    for (const double unseen_s : {1 / rate_hz, 0.2, 0.4, 0.8}) {
      const double error = normalized_error(rate_hz, unseen_s);
      EXPECT_GT(error, 0.6) << rate_hz << " Hz, " << unseen_s << " s";
      EXPECT_LT(error, 1.25) << rate_hz << " Hz, " << unseen_s << " s";
    }
  }
}

/// Measurements of a ball under constant acceleration (radii, s), every thirtieth of a second; the filter
/// after them.
TrackFilter filter_of(const Eigen::Vector2d& velocity, const Eigen::Vector2d& acceleration, int pictures,
                      double sigma_radii, RandomEngine& engine) {
  constexpr double radius = 0.05;
  const auto measured = [&](int k) {
    const double time_s = k * dt_s;
    const Eigen::Vector2d place = radius * (time_s * velocity + 0.5 * time_s * time_s * acceleration);
    const Eigen::Vector3d sigma(sigma_radii * radius, sigma_radii * radius, sigma_radii);
    const Eigen::Vector3d value(place.x(), place.y(), -std::log(radius));
    return BallFeatures{value + sigma.cwiseProduct(normal_vector(engine)), sigma};
  };
  TrackFilter filter(measured(0), 0);
  for (int k = 1; k < pictures; ++k) {
    filter.predict(k * dt_s);
    if (k == 1 && filter.distance2(measured(k)) > 9)
      filter.correct_after_jump(measured(k));
    else
      filter.correct(measured(k));
  }
  return filter;
}

TEST(TrackFilter, AThrownBallIsPredictedOnItsArcAndARollingOneOnItsLine) {
  constexpr double radius = 0.05, unseen_s = 0.2;
  for (const bool thrown : {true, false}) {
    const Eigen::Vector2d velocity = thrown ? Eigen::Vector2d(50, -70) : Eigen::Vector2d(15, 0);
    const Eigen::Vector2d acceleration(0, thrown ? 280 : 0);
    int near = 0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      RandomEngine engine = random_stream(seed, "throw");
      TrackFilter filter = filter_of(velocity, acceleration, 12, 0.04, engine);
      filter.lose();
      const double time_s = 11 * dt_s + unseen_s;
      filter.predict(time_s);
      const Eigen::Vector2d place = radius * (time_s * velocity + 0.5 * time_s * time_s * acceleration);
      near += (filter.value().head<2>() - place).norm() < radius;
    }
    EXPECT_GE(near, 36) << (thrown ? "thrown" : "rolling");
  }
}

TEST(TrackFilter, OfALostBallsVelocityNoiseDoesNotCount) {
  constexpr double radius = 0.05;
  double drift = 0, untouched = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    RandomEngine engine = random_stream(seed, "lost");
    TrackFilter filter = filter_of({0, 0}, {0, 0}, 4, 0.1, engine);
    untouched += filter.velocity().head<2>().norm() / radius / 40;
    filter.lose();
    drift += filter.velocity().head<2>().norm() / radius / 40;
  }
  EXPECT_LT(drift, 0.3 * untouched);
}

// Behind something, over the border: what is seen of it last seems to shrink.
TEST(TrackFilter, ALostBallKeepsItsSize) {
  constexpr double radius = 0.05;
  const Eigen::Vector3d sigma(0.02 * radius, 0.02 * radius, 0.02);
  TrackFilter filter({{0, 0, -std::log(radius)}, sigma}, 0);
  for (int k = 1; k < 12; ++k) {
    filter.predict(k * dt_s);
    const int hidden = std::max(0, k - 8);
    filter.correct({{15 * k * dt_s * radius, 0, -std::log(radius) + 0.03 * hidden * hidden}, sigma});
  }
  const double last = filter.value().z();
  EXPECT_GT(std::abs(filter.velocity().z()), 0.2);
  filter.lose();
  for (int k = 12; k < 42; ++k) filter.predict(k * dt_s);
  EXPECT_NEAR(filter.value().z(), last, 0.02);
  EXPECT_GT(filter.value().x(), 40 * dt_s * 15 * radius * 0.8);
}

TEST(TrackFilter, ManyShortPredictionsAreOneLongOne) {
  const BallFeatures features{{0.2, -0.1, 3}, {0.001, 0.001, 0.01}};
  TrackFilter one(features, 0), many(features, 0);
  one.predict(0.6);
  for (int k = 1; k <= 36; ++k) many.predict(k / 60.0);
  EXPECT_LT((one.value() - many.value()).norm(), 1e-12);
  EXPECT_LT((one.variance() - many.variance()).cwiseQuotient(one.variance()).cwiseAbs().maxCoeff(), 1e-9);
}

}  // namespace
}  // namespace ballservo
