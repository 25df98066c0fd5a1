// How two cameras disagree: the rotation between their frames, what is left of it, and when that means
// something.
#include "calibration/ball/camera_difference.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibration/ball/ball_uncertainty.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/random.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "tests/calibration/camera_examples.hpp"

namespace ballservo {
namespace {

using test::camera_parameters;

const Eigen::MatrixXd unknown;

CameraParameters brown() {
  return camera_parameters(LensModel::brown, 533, {-0.2845, 0.0565, 1.1e-3, -5e-4, 0.0946});
}

/// What calibrations find: a focal length of which fx and fy err together, a principal point, coefficients
/// that err against each other.
Eigen::MatrixXd example_covariance() {
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(9, 9);
  root.diagonal() << 0.4, 0.1, 0.8, 0.7, 2e-3, 3e-3, 1e-4, 1e-4, 4e-3;
  root(1, 0) = 0.4, root(5, 4) = -8e-3, root(8, 4) = 0.01, root(6, 3) = 2e-4;
  return root * root.transpose();
}

CameraParameters drawn(const CameraParameters& parameters, const Eigen::MatrixXd& covariance,
                       RandomEngine& engine) {
  const Eigen::MatrixXd root = covariance_root(covariance);
  Eigen::VectorXd z(root.cols());
  for (Eigen::Index i = 0; i < z.size(); ++i) z(i) = standard_normal(engine);
  return with_parameter_vector(parameters, parameter_vector(parameters) + root * z);
}

CameraDifferenceOptions coarse() {
  CameraDifferenceOptions options;
  options.columns = 9;
  return options;
}

TEST(CameraDifferenceTest, NoneBetweenACameraAndItself) {
  for (const auto& example : test::camera_examples()) {
    const Camera camera(example.parameters);
    const auto d = compare_cameras(camera, unknown, camera, unknown);
    EXPECT_LT(d.shift_px.max, 1e-9) << example.name;
    EXPECT_LT(d.ball_m.max, 1e-12) << example.name;
    EXPECT_LT(d.rotation_rad.norm(), 1e-12) << example.name;
    EXPECT_EQ(d.places.size(), static_cast<std::size_t>(d.columns * d.rows));
    EXPECT_FALSE(d.chance);
  }
}

TEST(CameraDifferenceTest, AMovedPrincipalPointIsARotation) {
  CameraParameters p = camera_parameters(LensModel::pinhole, 5000, {});
  const Camera a(p);
  p.cx_px += 2, p.cy_px -= 1;
  const auto d = compare_cameras(a, unknown, Camera(p), unknown);
  EXPECT_NEAR(d.rotation_rad.y(), -2.0 / 5000, 1e-6);
  EXPECT_NEAR(d.rotation_rad.x(), -1.0 / 5050, 1e-6);
  EXPECT_LT(d.shift_px.max, 0.02);
  EXPECT_GT(d.shift_px.max, 1e-4);
  EXPECT_LT(d.ball_m.max, 1e-4);  // untouched by the 0.4 mm that the turn itself makes of it
}

TEST(CameraDifferenceTest, ALongerFocalLengthPutsTheBallFurther) {
  CameraParameters p = camera_parameters(LensModel::pinhole, 600, {});
  const Camera a(p);
  p.fx_px *= 1.01, p.fy_px *= 1.01;
  CameraDifferenceOptions options;
  options.range_m = 2;
  const auto d = compare_cameras(a, unknown, Camera(p), unknown, options);
  const auto nearest =
      std::min_element(d.places.begin(), d.places.end(), [](const auto& left, const auto& right) {
        const Eigen::Vector2d middle(322.3, 238.1);
        return (left.pixel_px - middle).norm() < (right.pixel_px - middle).norm();
      });
  ASSERT_TRUE(nearest->ball_m);
  EXPECT_NEAR(nearest->ball_m->z(), 0.02, 1e-4);
  // Seen by the longer lens, everything lies further out, by 1 % of the distance from the centre.
  const DifferencePlace& corner = d.places.front();
  ASSERT_TRUE(corner.shift_px);
  EXPECT_NEAR(corner.shift_px->x(), -0.01 * 322.3, 0.05);
  EXPECT_FALSE(corner.ball_m);
}

TEST(CameraDifferenceTest, CornersThatDriftApartDoNotTurnTheRest) {
  // Two calibrations of one camera from seven and six pictures, whose boards did not reach the corners: there
  // the lenses part by hundreds of pixels, and more on the left, which is further from the principal point.
  CameraParameters p;
  p.model = LensModel::brown;
  p.size = {640, 480};
  p.fx_px = 533.98, p.fy_px = 534.17, p.cx_px = 339.52, p.cy_px = 234.59;
  p.coefficients = {-0.30330, 0.18976, 0.0013877, -0.00021267, -0.15833};
  const Camera a(p);
  p.fx_px = 533.09, p.fy_px = 533.26, p.cx_px = 344.46, p.cy_px = 232.18;
  p.coefficients = {-0.25006, -0.23863, 0.00048718, -0.00019812, 0.70765};
  const auto d = compare_cameras(a, unknown, Camera(p), unknown);
  EXPECT_GT(d.shift_px.max, 100);
  EXPECT_LT(d.shift_px.median, 0.4);
  for (const DifferencePlace& place : d.places)
    if ((place.pixel_px - Eigen::Vector2d(342, 233)).norm() < 100 && place.shift_px) {
      EXPECT_LT(place.shift_px->norm(), 0.5) << place.pixel_px.transpose();
    }
}

TEST(CameraDifferenceTest, TheOtherWayRoundIsAsLarge) {
  RandomEngine engine = random_stream(3, "difference");
  const Camera a(brown()), b(drawn(brown(), example_covariance(), engine));
  const auto forth = compare_cameras(a, unknown, b, unknown), back = compare_cameras(b, unknown, a, unknown);
  EXPECT_NEAR(forth.ball_m.rms, back.ball_m.rms, 0.05 * forth.ball_m.rms);
  EXPECT_NEAR(forth.shift_px.rms, back.shift_px.rms, 0.05 * forth.shift_px.rms);
  EXPECT_LT((forth.rotation_rad + back.rotation_rad).norm(), 1e-3 * forth.rotation_rad.norm());
}

TEST(CameraDifferenceTest, ChanceIsHowOftenItHappens) {
  // Pairs of calibrations of one camera: the chances are spread evenly from 0 to 1, and the mean square is
  // what was foretold.
  const Eigen::MatrixXd covariance = example_covariance();
  constexpr int pairs = 40;
  int below_10_percent = 0, below_half = 0;
  double squares = 0;
  for (int k = 0; k < pairs; ++k) {
    RandomEngine engine = random_stream(0, "pairs of calibrations", static_cast<std::uint64_t>(k));
    const Camera a(drawn(brown(), covariance, engine)), b(drawn(brown(), covariance, engine));
    CameraDifferenceOptions options;
    options.columns = 5;
    const auto d = compare_cameras(a, covariance, b, covariance, options);
    ASSERT_TRUE(d.chance && d.ball_sigma_rms_m);
    below_10_percent += *d.chance < 0.1;
    below_half += *d.chance < 0.5;
    squares += *d.sigmas_rms * *d.sigmas_rms;
  }
  // Four standard deviations of the counts.
  EXPECT_NEAR(below_10_percent, 0.1 * pairs, 4 * std::sqrt(0.09 * pairs));
  EXPECT_NEAR(below_half, 0.5 * pairs, 4 * std::sqrt(0.25 * pairs));
  EXPECT_NEAR(squares / pairs, 1, 4 * std::sqrt(2.0 / pairs));
}

TEST(CameraDifferenceTest, MoreThanTheUncertaintiesAllow) {
  const Eigen::MatrixXd covariance = example_covariance();
  CameraParameters refocused = brown();
  refocused.fx_px *= 1.01, refocused.fy_px *= 1.01;
  const Camera a(brown()), b(refocused);
  const auto d = compare_cameras(a, covariance, b, covariance, coarse());
  ASSERT_TRUE(d.chance);
  EXPECT_LT(*d.chance, 1e-3);
  EXPECT_GT(d.ball_m.rms, 5 * *d.ball_sigma_rms_m);
  const auto one = compare_cameras(a, covariance, b, unknown, coarse());
  EXPECT_FALSE(one.chance);
  EXPECT_NEAR(*one.ball_sigma_rms_m * std::sqrt(2), *d.ball_sigma_rms_m, 0.02 * *d.ball_sigma_rms_m);
  EXPECT_EQ(*compare_cameras(a, covariance, a, covariance, coarse()).chance, 1);
}

TEST(CameraDifferenceTest, WhatCannotBeCompared) {
  const Camera a(brown());
  CameraParameters other = brown();
  other.size = {480, 640};
  EXPECT_THROW(compare_cameras(a, unknown, Camera(other), unknown), InputError);
  CameraDifferenceOptions huge;
  huge.diameter_m = 1.9;
  EXPECT_THROW(compare_cameras(a, unknown, a, unknown, huge), InputError);
  for (const double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    CameraDifferenceOptions options;
    options.diameter_m = bad;
    EXPECT_THROW(options.validate(), InputError);
    options = {};
    options.range_m = bad;
    EXPECT_THROW(options.validate(), InputError);
  }
}

}  // namespace
}  // namespace ballservo
