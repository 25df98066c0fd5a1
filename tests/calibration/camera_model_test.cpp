// Every lens model: there and back, against OpenCV and ViSP, against finite differences, at its limits.
#include <gtest/gtest.h>
#include <visp3/core/vpCameraParameters.h>
#include <visp3/core/vpMeterPixelConversion.h>
#include <visp3/core/vpPixelMeterConversion.h>

#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>

#include "calibration/base/fault.hpp"
#include "calibration/camera/camera.hpp"
#include "tests/calibration/camera_examples.hpp"
#include "tests/support/faults.hpp"

namespace ballservo {
namespace {

using test::camera_examples;
using test::camera_parameters;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Pixels all over the picture and a little beyond.
std::vector<Eigen::Vector2d> pixel_grid() {
  std::vector<Eigen::Vector2d> pixels;
  for (double v = -4; v <= 484; v += 11.3)
    for (double u = -4; u <= 644; u += 12.7) pixels.emplace_back(u, v);
  return pixels;
}

class EveryCamera : public testing::TestWithParam<test::CameraExample> {
 protected:
  const Camera camera{GetParam().parameters};
};

INSTANTIATE_TEST_SUITE_P(Models, EveryCamera, testing::ValuesIn(camera_examples()),
                         [](const auto& example) { return example.param.name; });

TEST_P(EveryCamera, RoundTripsOverThePictureToMachinePrecision) {
  for (const Eigen::Vector2d& pixel : pixel_grid()) {
    const auto ray = camera.unproject(pixel);
    ASSERT_TRUE(ray) << pixel.transpose();
    EXPECT_NEAR(ray->norm(), 1, 1e-15);
    const auto back = camera.project(*ray);
    ASSERT_TRUE(back);
    EXPECT_LT((*back - pixel).norm(), 1e-11) << pixel.transpose();
  }
}

TEST_P(EveryCamera, ANearbyRayChangesNothing) {
  for (const Eigen::Vector2d& pixel : pixel_grid()) {
    const auto ray = camera.unproject(pixel);
    for (const Eigen::Vector2d& other :
         {Eigen::Vector2d(pixel + Eigen::Vector2d(1, 0)), Eigen::Vector2d(320, 240)}) {
      const auto guess = camera.unproject(other);
      const auto again = camera.unproject(pixel, *guess);
      ASSERT_TRUE(again);
      EXPECT_LT((*again - *ray).norm(), 1e-13);
    }
  }
}

TEST_P(EveryCamera, TheScaleOfThePointDoesNotMatter) {
  for (const double scale : {1e-6, 0.3, 7.0, 1e9}) {
    const Eigen::Vector3d p_C(0.21, -0.13, 0.9);
    EXPECT_LT((*camera.project(scale * p_C) - *camera.project(p_C)).norm(), 1e-10);
  }
}

TEST_P(EveryCamera, JacobianAgreesWithFiniteDifferences) {
  for (const Eigen::Vector2d& pixel : pixel_grid()) {
    const Eigen::Vector3d p_C = 1.7 * *camera.unproject(pixel);
    const auto jacobian = camera.project_jacobian(p_C);
    ASSERT_TRUE(jacobian);
    constexpr double step_m = 1e-5;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d step = step_m * Eigen::Vector3d::Unit(axis);
      const auto above = camera.project(p_C + step), below = camera.project(p_C - step);
      if (!above || !below) continue;
      EXPECT_LT(((*above - *below) / (2 * step_m) - jacobian->col(axis)).norm(), 1e-4 * jacobian->norm())
          << pixel.transpose();
    }
    // Along the ray nothing moves.
    EXPECT_LT((*jacobian * p_C).norm(), 1e-9 * jacobian->norm());
  }
}

TEST_P(EveryCamera, TheAxisReachesThePrincipalPoint) {
  const auto& p = camera.parameters();
  EXPECT_LT((*camera.project({0, 0, 2}) - Eigen::Vector2d(p.cx_px, p.cy_px)).norm(), 1e-12);
  EXPECT_LT((*camera.unproject({p.cx_px, p.cy_px}) - Eigen::Vector3d::UnitZ()).norm(), 1e-15);
  const auto jacobian = camera.project_jacobian({0, 0, 2});
  ASSERT_TRUE(jacobian);
  EXPECT_NEAR((*jacobian)(0, 0), p.fx_px / 2, 1e-9);
  EXPECT_NEAR((*jacobian)(1, 1), p.fy_px / 2, 1e-9);
}

TEST_P(EveryCamera, WhatCannotBeSeenIsNothing) {
  for (const Eigen::Vector3d& p_C : {Eigen::Vector3d(not_a_number, 0, 1), Eigen::Vector3d(0, infinity, 1),
                                     Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0, 0, -1)}) {
    EXPECT_FALSE(camera.project(p_C)) << p_C.transpose();
    EXPECT_FALSE(camera.project_jacobian(p_C)) << p_C.transpose();
  }
  EXPECT_FALSE(camera.unproject({not_a_number, 3}));
  EXPECT_FALSE(camera.unproject({3, -infinity}));
}

TEST_P(EveryCamera, InsideItsAngleTheLensNeverFolds) {
  const double edge = std::min(camera.max_angle_rad(), 1.5);
  for (double azimuth = 0; azimuth < 6.28; azimuth += 0.3) {
    const Eigen::Vector2d direction(std::cos(azimuth), std::sin(azimuth));
    double last = 0;
    for (double angle = 0.01; angle < edge; angle += 0.01) {
      const auto pixel =
          camera.project({std::sin(angle) * direction.x(), std::sin(angle) * direction.y(), std::cos(angle)});
      ASSERT_TRUE(pixel);
      const double distance =
          (*pixel - Eigen::Vector2d(camera.parameters().cx_px, camera.parameters().cy_px)).norm();
      EXPECT_GT(distance, last);
      last = distance;
    }
    if (camera.max_angle_rad() < 3) {
      const double beyond = camera.max_angle_rad() + 1e-6;
      EXPECT_FALSE(camera.project(
          {std::sin(beyond) * direction.x(), std::sin(beyond) * direction.y(), std::cos(beyond)}));
    }
  }
}

std::vector<cv::Point3d> points_in_view() {
  std::vector<cv::Point3d> points;
  for (double y = -0.42; y <= 0.42; y += 0.06)
    for (double x = -0.57; x <= 0.57; x += 0.06) points.emplace_back(x, y, 1.0);
  return points;
}

cv::Matx33d camera_matrix(const CameraParameters& p) {
  return {p.fx_px, 0, p.cx_px, 0, p.fy_px, p.cy_px, 0, 0, 1};
}

TEST(CameraAgainstOpenCv, BrownConrady) {
  for (const auto& example : camera_examples()) {
    const auto& p = example.parameters;
    if (p.model != LensModel::brown && p.model != LensModel::brown8) continue;
    const Camera camera(p);
    std::vector<cv::Point2d> expected;
    const std::vector<double> k(p.coefficients.begin(), p.coefficients.begin() + coefficient_count(p.model));
    const auto points = points_in_view();
    cv::projectPoints(points, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), camera_matrix(p), k, expected);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto pixel = camera.project({points[i].x, points[i].y, points[i].z});
      ASSERT_TRUE(pixel);
      EXPECT_NEAR(pixel->x(), expected[i].x, 1e-10);
      EXPECT_NEAR(pixel->y(), expected[i].y, 1e-10);
    }
  }
}

TEST(CameraAgainstOpenCv, KannalaBrandtIsItsFisheye) {
  for (const auto& example : camera_examples()) {
    const auto& p = example.parameters;
    if (p.model != LensModel::kannala_brandt) continue;
    const Camera camera(p);
    std::vector<cv::Point2d> expected;
    const auto points = points_in_view();
    cv::fisheye::projectPoints(
        points, expected, cv::Affine3d(), camera_matrix(p),
        cv::Vec4d(p.coefficients[0], p.coefficients[1], p.coefficients[2], p.coefficients[3]));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto pixel = camera.project({points[i].x, points[i].y, points[i].z});
      ASSERT_TRUE(pixel);
      EXPECT_NEAR(pixel->x(), expected[i].x, 1e-9);
      EXPECT_NEAR(pixel->y(), expected[i].y, 1e-9);
    }
  }
}

TEST(CameraAgainstVisp, KduIsTheDefinition) {
  for (const double kdu : {0.33, -0.06, 0.0}) {
    const CameraParameters p = camera_parameters(LensModel::visp, 535, {kdu});
    const Camera camera(p);
    vpCameraParameters visp;
    visp.initPersProjWithDistortion(p.fx_px, p.fy_px, p.cx_px, p.cy_px, 0.123, kdu);
    for (const Eigen::Vector2d& pixel : pixel_grid()) {
      double x = 0, y = 0;
      vpPixelMeterConversion::convertPoint(visp, pixel.x(), pixel.y(), x, y);
      const auto ray = camera.unproject(pixel);
      ASSERT_TRUE(ray);
      EXPECT_NEAR(ray->x() / ray->z(), x, 1e-14);
      EXPECT_NEAR(ray->y() / ray->z(), y, 1e-14);
      // And what ViSP says the ray is, projects back to the pixel: the kud beside it plays no part.
      EXPECT_LT((*camera.project({x, y, 1}) - pixel).norm(), 1e-11);
    }
  }
}

TEST(CameraAgainstVisp, PinholeAndKannalaBrandt) {
  for (const auto& example : camera_examples()) {
    const auto& p = example.parameters;
    const Camera camera(p);
    vpCameraParameters visp;
    if (p.model == LensModel::pinhole)
      visp.initPersProjWithoutDistortion(p.fx_px, p.fy_px, p.cx_px, p.cy_px);
    else if (p.model == LensModel::kannala_brandt)
      visp.initProjWithKannalaBrandtDistortion(
          p.fx_px, p.fy_px, p.cx_px, p.cy_px,
          {p.coefficients[0], p.coefficients[1], p.coefficients[2], p.coefficients[3], 0.7});
    else
      continue;
    for (const cv::Point3d& point : points_in_view()) {
      double u = 0, v = 0;
      vpMeterPixelConversion::convertPoint(visp, point.x, point.y, u, v);
      const auto pixel = camera.project({point.x, point.y, point.z});
      ASSERT_TRUE(pixel);
      EXPECT_NEAR(pixel->x(), u, 1e-9) << example.name;
      EXPECT_NEAR(pixel->y(), v, 1e-9) << example.name;
    }
  }
}

TEST(CameraLimits, AFoldingVispLensEndsWhereItsCubicTurns) {
  const Camera camera(camera_parameters(LensModel::visp, 300, {-0.5}));
  const double fold = 1 / std::sqrt(1.5);  // 1 + 3 kdu r^2 = 0
  EXPECT_NEAR(camera.max_angle_rad(), std::atan(fold * (1 - 0.5 * fold * fold)), 1e-9);
  EXPECT_TRUE(camera.unproject({322.3 + 300 * (fold - 1e-6), 238.1}));
  EXPECT_FALSE(camera.unproject({322.3 + 300 * (fold + 1e-6), 238.1}));
}

TEST(CameraLimits, ABarrelThatFoldsHasNoRayBeyond) {
  // r (1 - 0.4 r^2) turns at r = sqrt(1 / 1.2).
  const Camera camera(camera_parameters(LensModel::brown, 300, {-0.4}));
  const double fold = std::sqrt(1 / 1.2);
  EXPECT_NEAR(camera.max_angle_rad(), std::atan(fold), 1e-9);
  const double furthest_px = 300 * fold * (1 - 0.4 * fold * fold);
  EXPECT_TRUE(camera.unproject({322.3 + furthest_px - 1e-3, 238.1}));
  EXPECT_FALSE(camera.unproject({322.3 + furthest_px + 1e-3, 238.1}));
}

TEST(CameraLimits, ARationalLensEndsBeforeItsPole) {
  // 1 - 0.5 r^2 in the denominator: a pole at r = sqrt(2), beyond which points come back from infinity.
  const Camera camera(camera_parameters(LensModel::brown8, 300, {0, 0, 0, 0, 0, -0.5, 0, 0}));
  EXPECT_LE(camera.max_angle_rad(), std::atan(std::sqrt(2.0)) + 1e-9);
  EXPECT_GT(camera.max_angle_rad(), std::atan(1.3));
}

TEST(CameraLimits, AFisheyeSeesBehindItself) {
  const Camera camera(camera_parameters(LensModel::kannala_brandt, 100, {}));
  const Eigen::Vector3d behind(1, 0.2, -0.5);
  const auto pixel = camera.project(behind);
  ASSERT_TRUE(pixel);
  EXPECT_LT((*camera.unproject(*pixel) - behind.normalized()).norm(), 1e-12);
}

TEST(CameraParametersCheck, NamesEveryFault) {
  CameraParameters p;
  p.model = LensModel::brown;
  p.size = {0, 70000};
  p.fx_px = not_a_number, p.fy_px = -533, p.cx_px = infinity, p.cy_px = not_a_number;
  p.coefficients = {not_a_number, 0, infinity, 0, 0, 0, 3, 0};
  const auto faults = test::faults_of([&] { Camera(p, "bad.yaml"); });
  EXPECT_EQ(faults.size(), 9u);
  for (const Fault& fault : faults) EXPECT_EQ(fault.place.rfind("bad.yaml", 0), 0u);
}

TEST(CameraParametersCheck, FocalLengthsAboveZeroAndPrincipalPointNearThePicture) {
  for (const double focal : {0.0, -1.0, not_a_number, infinity}) {
    CameraParameters p = camera_parameters(LensModel::pinhole, 500, {});
    p.fy_px = focal;
    EXPECT_THROW(Camera{p}, InputError) << focal;
  }
  CameraParameters p = camera_parameters(LensModel::pinhole, 500, {});
  p.cx_px = 640 + 641;
  EXPECT_THROW(Camera{p}, InputError);
  p.cx_px = 640 + 639;
  EXPECT_NO_THROW(Camera{p});
}

TEST(LensModels, NamesGoThereAndBack) {
  for (const LensModel model : all_lens_models) {
    EXPECT_EQ(lens_model_from_name(lens_model_name(model)), model);
    EXPECT_EQ(coefficient_names(model).size(), static_cast<std::size_t>(coefficient_count(model)));
  }
  EXPECT_FALSE(lens_model_from_name("fisheye"));
}

TEST(LongLensCamera, ABallsOutlineIsACircle) {
  const Camera camera = long_lens_camera({641, 481});
  EXPECT_LT((*camera.project({0, 0, 1}) - Eigen::Vector2d(320, 240)).norm(), 1e-9);
  EXPECT_DOUBLE_EQ(camera.focal_px(), 6.41e6);
}

}  // namespace
}  // namespace ballservo
