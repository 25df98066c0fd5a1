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

TEST_P(EveryRayTable, InterpolatesToAThousandthOfAPixel) {
  for (double v = -3; v <= 482; v += 3.37) {
    for (double u = -3; u <= 642; u += 3.71) {
      const auto ray = table.ray({u, v});
      ASSERT_TRUE(ray) << u << " " << v;
      EXPECT_NEAR(ray->norm(), 1, 1e-14);
      EXPECT_LT((*camera.project(*ray) - Eigen::Vector2d(u, v)).norm(), 1e-4);
    }
  }
}

TEST_P(EveryRayTable, JacobianUndoesTheProjections) {
  for (double v = 0; v <= 479; v += 23.9) {
    for (double u = 0; u <= 639; u += 31.7) {
      const auto ray = table.ray({u, v});
      const auto jacobian = table.ray_jacobian({u, v});
      ASSERT_TRUE(ray && jacobian);
      const auto forward = camera.project_jacobian(*ray);
      ASSERT_TRUE(forward);
      EXPECT_LT((*forward * *jacobian - Eigen::Matrix2d::Identity()).norm(), 1e-4);
      EXPECT_LT((ray->transpose() * *jacobian).norm(), 1e-12);  // a unit ray only turns
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
  for (const auto& [u, v] : {std::pair{-50.0, 10.0},
                             {10.0, -50.0},
                             {700.0, 10.0},
                             {10.0, 540.0},
                             {std::nan(""), 10.0},
                             {10.0, std::nan("")},
                             {1e300, 0.0}}) {
    EXPECT_FALSE(table.ray({u, v}));
    EXPECT_FALSE(table.ray_jacobian({u, v}));
  }
  EXPECT_FALSE(table.undistorted_px(-50, 10));
  EXPECT_FALSE(table.undistorted_px(700, 10));
}

TEST(RayTable, AtTheRimOfTheLensItsTableAgreesWithTheLens) {
  // A barrel that folds inside the picture: some of the interpolation's neighbours are missing at its rim.
  const Camera camera(test::camera_parameters(LensModel::brown, 300, {-0.4}));
  const RayTable table(camera);
  int inside = 0, outside = 0;
  for (double u = 480; u <= 520; u += 0.37) {
    const auto ray = table.ray({u, 238.1});
    const auto exact = camera.unproject(Eigen::Vector2d(u, 238.1));
    EXPECT_EQ(ray.has_value(), exact.has_value()) << u;
    if (ray && exact) {
      ++inside;
      const bool at_the_rim = !camera.unproject(Eigen::Vector2d(u + 4, 238.1));
      EXPECT_LT((*camera.project(*ray) - Eigen::Vector2d(u, 238.1)).norm(), at_the_rim ? 1e-2 : 1e-3) << u;
      EXPECT_TRUE(table.ray_jacobian({u, 238.1})) << u;
    } else {
      ++outside;
    }
  }
  EXPECT_GT(inside, 20);
  EXPECT_GT(outside, 20);
}

TEST(RayTable, TinyPicturesHaveTables) {
  CameraParameters p;
  p.size = {1, 1};
  p.fx_px = p.fy_px = 3;
  EXPECT_TRUE(RayTable(Camera(p)).ray({0, 0}));
}

}  // namespace
}  // namespace ballservo
