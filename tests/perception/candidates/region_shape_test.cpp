#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>

#include "perception/candidates/region_outline.hpp"

namespace ballservo {
namespace {

constexpr double focal_px = 400;

struct Drawn {
  std::vector<BoundaryPixel> outline;
  std::vector<BoundaryPoint> points;
  int pixels = 0;
};

// The boundary pixels of what `inside` says, in a window about `middle`. The lens magnifies so far beyond its
// focal length (as one of pincushion distortion does near the corners).
Drawn draw(const Eigen::Vector2d& middle_px, int reach_px,
           const std::function<bool(const Eigen::Vector2d&)>& inside, float magnified = 1) {
  Drawn drawn;
  const auto at = [&](int u, int v) { return inside(Eigen::Vector2d(u, v)); };
  for (int dv = -reach_px; dv <= reach_px; ++dv) {
    for (int du = -reach_px; du <= reach_px; ++du) {
      const int u = static_cast<int>(middle_px.x()) + du, v = static_cast<int>(middle_px.y()) + dv;
      if (!at(u, v)) continue;
      ++drawn.pixels;
      if (at(u - 1, v) && at(u + 1, v) && at(u, v - 1) && at(u, v + 1)) continue;
      drawn.outline.push_back({u, v, {0, 0}});
      drawn.points.push_back(
          {Eigen::Vector2f(static_cast<float>(u), static_cast<float>(v)) / magnified, {0, 0}});
    }
  }
  return drawn;
}

RegionShape shape_of(const Drawn& drawn) {
  return region_shape(drawn.outline, drawn.points, drawn.pixels, focal_px);
}

bool looks_other(const Drawn& drawn) { return is_no_balls(shape_of(drawn)); }

// A sphere's outline around a direction, as the pixels whose rays lie in its cone.
Drawn ball_at(const Eigen::Vector2d& middle_px, double alpha_rad, double hidden_from_px = 1e9) {
  const Eigen::Vector3d axis = Eigen::Vector3d(middle_px.x(), middle_px.y(), focal_px).normalized();
  return draw(middle_px, 90, [&](const Eigen::Vector2d& p) {
    const bool on_ball = Eigen::Vector3d(p.x(), p.y(), focal_px).normalized().dot(axis) > std::cos(alpha_rad);
    return on_ball && p.x() - middle_px.x() < hidden_from_px;
  });
}

Drawn disc_aslant(double long_px, double axis_ratio, double turned_rad) {
  const Eigen::Vector2d middle_px(20, -35);
  return draw(middle_px, 90, [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d q = Eigen::Rotation2Dd(turned_rad) * (p - middle_px);
    return std::hypot(q.x(), q.y() / axis_ratio) < long_px;
  });
}

TEST(RegionShape, ABallIsRoundWhereverItStands) {
  for (const Eigen::Vector2d& middle : {Eigen::Vector2d(0, 0), Eigen::Vector2d(300, -200)}) {
    const Drawn ball = ball_at(middle, 0.1);
    const RegionShape shape = shape_of(ball);
    EXPECT_GT(shape.axis_ratio, 0.97) << middle.x();
    EXPECT_LT(shape.ellipse_residual_px, 0.4);
    EXPECT_FALSE(is_no_balls(shape));
  }
}

TEST(RegionShape, AHiddenPartMakesNoOtherThingOfABall) {
  for (double from_px = -24; from_px < 40; from_px += 4)
    EXPECT_FALSE(looks_other(ball_at({10, 5}, 0.1, from_px))) << from_px;
}

TEST(RegionShape, ADiscAslantIsAnEllipse) {
  for (const double turned_rad : {0.0, 0.4, 1.2}) {
    for (const double ratio : {0.4, 0.6, 0.75, 0.79})
      EXPECT_TRUE(looks_other(disc_aslant(25, ratio, turned_rad))) << turned_rad << " " << ratio;
    for (const double ratio : {0.86, 0.95})  // as of a ball that moves
      EXPECT_FALSE(looks_other(disc_aslant(25, ratio, turned_rad))) << turned_rad << " " << ratio;
  }
}

TEST(RegionShape, ABoxFillsItsRectangle) {
  for (const double turned_rad : {0.0, 0.3, 0.7}) {
    const Drawn box = draw({0, 0}, 60, [&](const Eigen::Vector2d& p) {
      const Eigen::Vector2d q = Eigen::Rotation2Dd(turned_rad) * p;
      return std::abs(q.x()) < 22 && std::abs(q.y()) < 13;
    });
    EXPECT_TRUE(looks_other(box)) << turned_rad;
  }
}

TEST(RegionShape, ALensThatMagnifiesMakesNoBoxOfABall) {
  const auto disc = [](const Eigen::Vector2d& p) { return p.norm() < 30; };
  const Drawn ball = draw({0, 0}, 40, disc, 1.15f);
  EXPECT_NEAR(shape_of(ball).box_fill, 0.785, 0.05);
  EXPECT_FALSE(looks_other(ball));
}

TEST(RegionShape, SmallDiscsAndBoxesAreTold) {
  for (double size_px = 5.2; size_px < 10; size_px += 0.2) {
    EXPECT_FALSE(looks_other(draw({0, 0}, 20, [&](const Eigen::Vector2d& p) { return p.norm() < size_px; })))
        << size_px;
    EXPECT_TRUE(looks_other(draw({0, 0}, 20, [&](const Eigen::Vector2d& p) {
      return p.cwiseAbs().maxCoeff() < size_px;
    }))) << size_px;
  }
}

TEST(RegionShape, AFewPixelsTellNothing) {
  EXPECT_FALSE(looks_other(disc_aslant(2.4, 0.6, 0)));
  EXPECT_FALSE(looks_other({}));
}

}  // namespace
}  // namespace ballservo
