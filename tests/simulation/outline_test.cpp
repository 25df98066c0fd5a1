// The ball's outline in rendered pictures, against the analytic one: by integrals over the picture and pixel
// by pixel.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "calibration/camera/sphere_outline.hpp"
#include "servo/simulation/rendering/camera_renderer.hpp"
#include "servo/simulation/rendering/edge_pixel.hpp"
#include "tests/simulation/dark_room.hpp"

namespace ballservo {
namespace {

struct Sphere {
  Eigen::Vector3d p_C;
  double diameter_m;
};

const std::vector<Sphere>& spheres() {
  static const std::vector<Sphere> all{{{0.003, 0.002, 0.8}, 0.12},         // large, in the middle
                                       {{0.21, -0.13, 0.9}, 0.07},          // off the axis
                                       {{-0.55, 0.36, 1.2}, 0.12},          // in a corner
                                       {{0.901, 0.313, 4.5}, 0.12},         // 6 px
                                       {{-0.7003, -0.2511, 3.0}, 0.0401}};  // 3 px
  return all;
}

/// White balls on black through a lens, all in one picture.
cv::Mat flat_picture(const Camera& camera, const std::vector<Sphere>& balls) {
  World world = test::dark_room();
  for (const Sphere& ball : balls) {
    world.balls.push_back(test::white_ball(test::level_view() * ball.p_C, ball.diameter_m));
  }
  return CameraRenderer(camera, world, {}).radiance({{test::level_view(), 0}});
}

/// Area of a convex polygon inside a pixel (Sutherland and Hodgman, CACM 1974).
double share_of_pixel(std::vector<Eigen::Vector2d> polygon, int column, int row) {
  for (int side = 0; side < 4; ++side) {
    const int axis = side / 2;
    const double sign = side % 2 == 0 ? 1 : -1, limit = (axis == 0 ? column : row) - 0.5 * sign;
    std::vector<Eigen::Vector2d> cut;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const Eigen::Vector2d &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
      const double da = sign * (a[axis] - limit), db = sign * (b[axis] - limit);
      if (da >= 0) cut.push_back(a);
      if ((da >= 0) != (db >= 0)) cut.push_back(a + da / (da - db) * (b - a));
    }
    polygon = std::move(cut);
  }
  double twice = 0;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Eigen::Vector2d &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

struct Integral {
  double area = 0;
  Eigen::Vector2d centroid{0, 0};
};

/// Area and centroid of what `share` gives for the pixels around an outline.
template <typename Share>
Integral integral_around(const OutlineEllipse& outline, const Share& share) {
  Integral sum;
  const int reach = static_cast<int>(1.4 * outline.radius_px) + 4;
  const int u = static_cast<int>(outline.center_px.x()), v = static_cast<int>(outline.center_px.y());
  for (int row = std::max(v - reach, 0); row <= std::min(v + reach, 479); ++row) {
    for (int column = std::max(u - reach, 0); column <= std::min(u + reach, 639); ++column) {
      const double value = share(column, row);
      sum.area += value;
      sum.centroid += value * Eigen::Vector2d(column, row);
    }
  }
  sum.centroid /= sum.area;
  return sum;
}

TEST(Outline, AreaAndCentroidOfAFlatBallAreTheAnalyticOnes) {
  for (const LensModel model : all_lens_models) {
    const Camera camera = test::lens(model);
    const cv::Mat light = flat_picture(camera, spheres());
    for (const Sphere& ball : spheres()) {
      const auto truth = project_sphere(camera, ball.p_C, ball.diameter_m / 2);
      ASSERT_TRUE(truth);
      const auto polygon = project_outline(camera, ball.p_C, ball.diameter_m / 2, 2048);
      const Integral picture =
          integral_around(*truth, [&](int column, int row) { return light.at<cv::Vec3f>(row, column)[1]; });
      const Integral exact =
          integral_around(*truth, [&](int column, int row) { return share_of_pixel(polygon, column, row); });
      const std::string name = std::string(lens_model_name(model)) + " r " + std::to_string(truth->radius_px);
      EXPECT_NEAR(std::sqrt(picture.area / M_PI), truth->radius_px, 5e-4) << name;
      // A centroid of whole pixels errs by itself, by the shares' first moments within the pixels (some 0.01
      // / r).
      EXPECT_LT((picture.centroid - exact.centroid).norm(), 5e-4) << name;
      EXPECT_LT((picture.centroid - truth->center_px).norm(), 5e-4 + 0.025 / truth->radius_px) << name;
    }
  }
}

TEST(Outline, EveryPixelHoldsItsShareToAHundredth) {
  for (const LensModel model : all_lens_models) {
    const Camera camera = test::lens(model);
    const cv::Mat light = flat_picture(camera, spheres());
    for (const Sphere& ball : spheres()) {
      const auto truth = *project_sphere(camera, ball.p_C, ball.diameter_m / 2);
      const auto polygon = project_outline(camera, ball.p_C, ball.diameter_m / 2, 2048);
      double worst = 0;
      integral_around(truth, [&](int column, int row) {
        const double share = share_of_pixel(polygon, column, row);
        worst = std::max(worst, std::abs(light.at<cv::Vec3f>(row, column)[1] - share));
        return share;
      });
      EXPECT_LT(worst, 0.01) << lens_model_name(model) << " r " << truth.radius_px;
    }
  }
}

TEST(Outline, ABallBeyondTheBorderIsCutThere) {
  const Camera camera = test::lens(LensModel::pinhole);
  const Sphere ball{{0.53, 0.0, 0.8}, 0.12};
  const auto truth = *project_sphere(camera, ball.p_C, ball.diameter_m / 2);
  ASSERT_GT(truth.center_px.x() + truth.radius_px, 645);
  const auto polygon = project_outline(camera, ball.p_C, ball.diameter_m / 2, 2048);
  const cv::Mat light = flat_picture(camera, {ball});
  const double expected =
      integral_around(truth, [&](int column, int row) { return share_of_pixel(polygon, column, row); }).area;
  EXPECT_NEAR(cv::sum(light)[1], expected, 0.05);
}

TEST(HalfPlane, ShareGrowsFromNothingToAllAndIsHalfInTheMiddle) {
  for (double angle = 0; angle < 6.3; angle += 0.1) {
    const double x = std::cos(angle), y = std::sin(angle);
    EXPECT_NEAR(half_plane_share(0, x, y, 1), 0.5, 1e-12);
    EXPECT_EQ(half_plane_share(0.8, x, y, 1), 1);
    EXPECT_EQ(half_plane_share(-0.8, x, y, 1), 0);
    double before = 0;
    for (double inside = -0.75; inside < 0.75; inside += 0.01) {
      const double share = half_plane_share(inside, x, y, 1);
      EXPECT_GE(share, before - 1e-12);
      EXPECT_NEAR(share + half_plane_share(-inside, x, y, 1), 1, 1e-12);
      before = share;
    }
  }
}

}  // namespace
}  // namespace ballservo
