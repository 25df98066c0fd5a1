// The ray table against the lens itself.
#include <gtest/gtest.h>

#include <cmath>

#include "calibration/camera/ray_table.hpp"
#include "tests/calibration/camera_examples.hpp"

namespace ballservo {
namespace {

class EveryRayTable : public testing::TestWithParam<test::CameraExample> {
 protected:
  const Camera camera{GetParam().parameters};
  const RayTable table{camera};
};

INSTANTIATE_TEST_SUITE_P(Models, EveryRayTable, testing::ValuesIn(test::camera_examples()),
                         [](const auto& example) { return example.param.name; });

TEST_P(EveryRayTable, HoldsTheRayOfEveryPixelAndOfItsMargin) {
  for (int v = -6; v <= 485; v += 7) {
    for (int u = -6; u <= 645; u += 7) {
      const Eigen::Vector3d* ray = table.pixel_ray(u, v);
      ASSERT_TRUE(ray) << u << " " << v;
      EXPECT_NEAR(ray->norm(), 1, 1e-14);
      EXPECT_LT((*camera.project(*ray) - Eigen::Vector2d(u, v)).norm(), 1e-9);
    }
  }
}

TEST_P(EveryRayTable, UndistortedPixelsAreThoseOfAPinhole) {
  for (const auto& [u, v] : {std::pair{0, 0}, {639, 479}, {100, 400}, {320, 240}, {-3, 481}}) {
    const auto ray = camera.unproject(Eigen::Vector2d(u, v));
    const auto undistorted = table.undistorted_px(u, v);
    ASSERT_EQ(undistorted.has_value(), ray->z() > std::cos(85 / 57.29577951308232));
    if (!undistorted) continue;
    const Eigen::Vector2d expected = camera.focal_px() / ray->z() * ray->head<2>();
    EXPECT_LT((undistorted->cast<double>() - expected).norm(), 1e-6 * (1 + expected.norm()));
  }
}

TEST_P(EveryRayTable, OutsideThereIsNothing) {
  for (const auto& [u, v] : {std::pair{-50, 10}, {10, -50}, {700, 10}, {10, 540}, {-7, 0}, {0, 486}})
    EXPECT_FALSE(table.pixel_ray(u, v)) << u << " " << v;
  EXPECT_FALSE(table.undistorted_px(-50, 10));
  EXPECT_FALSE(table.undistorted_px(700, 10));
}

TEST(RayTable, AtTheRimOfTheLensItsTableAgreesWithTheLens) {
  // A barrel that folds inside the picture.
  const Camera camera(test::camera_parameters(LensModel::brown, 300, {-0.4}));
  const RayTable table(camera);
  int inside = 0, outside = 0;
  for (int v = 0; v < 480; ++v) {
    for (int u = 480; u <= 520; ++u) {
      const Eigen::Vector3d* ray = table.pixel_ray(u, v);
      ASSERT_EQ(ray != nullptr, camera.unproject(Eigen::Vector2d(u, v)).has_value()) << u << " " << v;
      ++(ray ? inside : outside);
      if (ray) {
        EXPECT_LT((*camera.project(*ray) - Eigen::Vector2d(u, v)).norm(), 1e-6) << u << " " << v;
      }
    }
  }
  EXPECT_GT(inside, 20);
  EXPECT_GT(outside, 20);
}

TEST(RayTable, TinyPicturesHaveTables) {
  CameraParameters p;
  p.size = {1, 1};
  p.fx_px = p.fy_px = 3;
  EXPECT_TRUE(RayTable(Camera(p)).pixel_ray(0, 0));
}

}  // namespace
}  // namespace ballservo
