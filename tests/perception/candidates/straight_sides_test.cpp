#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "perception/candidates/region_outline.hpp"
#include "perception/segmentation/regions.hpp"

namespace ballservo {
namespace {

constexpr int width = 200, height = 160;

// The boundary, in order, of what is inside a shape given in a frame turned about the picture's middle.
std::vector<BoundaryPixel> boundary_of(const std::function<bool(double x, double y)>& inside,
                                       double turn_rad = 0) {
  ClassPictures classes(1);
  classes[0].resize({width, height});
  for (int v = 0; v < height; ++v) {
    classes[0].fill(v, 0, width, false);
    for (int u = 0; u < width; ++u) {
      const double x = u - 99.7, y = v - 79.4;
      const double c = std::cos(turn_rad), s = std::sin(turn_rad);
      if (inside(c * x + s * y, -s * x + c * y)) classes[0].fill(v, u, u + 1, true);
    }
  }
  RegionMap regions;
  regions.update(classes, {width, height});
  std::vector<BoundaryPixel> pixels, all;
  BoundaryChain chain;
  for (int i = 0; i < static_cast<int>(regions.regions().size()); ++i) {
    regions.boundary(i, pixels);
    chain.order(pixels, {width, height});
    all.insert(all.end(), pixels.begin(), pixels.end());
  }
  return all;
}

double straight_fraction(const std::vector<BoundaryPixel>& boundary) {
  std::vector<BoundaryPoint> points;
  for (const BoundaryPixel& p : boundary)
    points.push_back({{static_cast<float>(p.u_px), static_cast<float>(p.v_px)}, {0, 0}});
  StraightSides sides;
  const auto& straight = sides.find(points);
  return static_cast<double>(std::count(straight.begin(), straight.end(), 1)) /
         static_cast<double>(straight.size());
}

TEST(BoundaryChain, KeepsEveryPixelAndFollowsTheOutline) {
  // A disc and, apart from it, a box.
  const auto boundary = boundary_of([](double x, double y) {
    return std::hypot(x, y) < 40 || (std::abs(x - 65) < 10 && std::abs(y) < 30);
  });
  ASSERT_GT(boundary.size(), 300u);
  std::set<std::pair<int, int>> seen;
  int jumps = 0;
  for (std::size_t i = 0; i < boundary.size(); ++i) {
    EXPECT_TRUE(seen.insert({boundary[i].u_px, boundary[i].v_px}).second);
    if (i > 0 && std::max(std::abs(boundary[i].u_px - boundary[i - 1].u_px),
                          std::abs(boundary[i].v_px - boundary[i - 1].v_px)) > 1)
      ++jumps;
  }
  EXPECT_EQ(jumps, 1);
}

TEST(StraightSides, ABoxIsNothingElse) {
  for (const double turn_rad : {0.0, 0.1, 0.3, 0.6, 0.785}) {
    for (const double half_px : {15.0, 30.0, 45.0}) {
      const auto box = boundary_of(
          [&](double x, double y) { return std::abs(x) < half_px && std::abs(y) < 0.8 * half_px; }, turn_rad);
      EXPECT_GT(straight_fraction(box), 0.85) << turn_rad << " " << half_px;
    }
  }
}

TEST(StraightSides, ADiscHasNone) {
  for (const double radius_px : {4.0, 8.0, 15.0, 30.0, 70.0}) {
    const auto disc = boundary_of([&](double x, double y) { return std::hypot(x, y) < radius_px; });
    EXPECT_EQ(straight_fraction(disc), 0) << radius_px;
  }
}

TEST(StraightSides, OfAHalfDiscTheDiameterIsOne) {
  for (const double turn_rad : {0.0, 0.2, 0.9, 2.0, 4.0}) {
    const double radius_px = 30;
    const auto half =
        boundary_of([&](double x, double y) { return y > 0 && std::hypot(x, y) < radius_px; }, turn_rad);
    // 2 r of (2 + pi) r, but for the pixels beside its ends.
    EXPECT_NEAR(straight_fraction(half), 2 / (2 + 3.14159), 0.08) << turn_rad;
  }
}

TEST(StraightSides, NoPointsHaveNone) {
  StraightSides sides;
  EXPECT_TRUE(sides.find({}).empty());
  EXPECT_EQ(sides.find({BoundaryPoint{{1, 1}, {0, 0}}}).front(), 0);
  EXPECT_EQ(sides.find(std::vector<BoundaryPoint>(20)).front(), 0);  // all at one place
}

}  // namespace
}  // namespace ballservo
