#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "perception/judgement/outline_support.hpp"

namespace ballservo {
namespace {

constexpr int sectors = 30;

SectorColors all_bounded() {
  SectorColors colors;
  colors.count = sectors;
  colors.values.fill(SectorColor::bounded);
  return colors;
}

// Offsets as a function of the sector's middle angle; what lies beyond 3 px is not seen.
template <typename Offset>
EdgeOffsets offsets_of(const Offset& offset_px) {
  EdgeOffsets offsets;
  offsets.count = sectors;
  for (int i = 0; i < sectors; ++i) {
    const double offset = offset_px(2 * M_PI * (i + 0.5) / sectors);
    offsets[i] = std::abs(offset) < 3 ? static_cast<float>(offset) : std::numeric_limits<float>::quiet_NaN();
  }
  return offsets;
}

// How far a square's side lies outside its inscribed circle.
double square_offset(double angle_rad, double radius_px) {
  const double from_side = std::remainder(angle_rad, M_PI / 2);
  return radius_px / std::cos(from_side) - radius_px;
}

TEST(OutlineShape, ACircleIsRound) {
  const auto shape =
      outline_shape(offsets_of([](double a) { return 0.05 * std::sin(7 * a); }), all_bounded(), 30, 0.7);
  EXPECT_EQ(shape.match, 1);
  EXPECT_EQ(shape.straight, 0);
}

TEST(OutlineShape, ASquareIsStraightAndLeavesItsCircle) {
  for (const double radius_px : {8.0, 15.0, 30.0}) {
    const auto offsets = offsets_of([&](double a) { return square_offset(a, radius_px); });
    SectorColors colors = all_bounded();
    for (int i = 0; i < sectors; ++i) {
      if (std::isnan(offsets[i])) colors[i] = SectorColor::leaking;
    }
    const auto shape = outline_shape(offsets, colors, radius_px, 0.7);
    EXPECT_LT(shape.match, 0.6) << radius_px;
    EXPECT_GT(shape.straight, 0.5) << radius_px;
  }
}

TEST(OutlineShape, WhatIsHiddenSaysNothing) {
  auto offsets = offsets_of([](double a) { return a > M_PI ? 2.5 : 0.0; });
  SectorColors colors = all_bounded();
  for (int i = sectors / 2; i < sectors; ++i) colors[i] = SectorColor::covered;
  EXPECT_EQ(outline_shape(offsets, colors, 30, 0.7).match, 1);
  for (int i = sectors / 2; i < sectors; ++i) colors[i] = SectorColor::leaking;
  EXPECT_NEAR(outline_shape(offsets, colors, 30, 0.7).match, 0.5, 1e-9);
}

TEST(OutlineShape, ASmearedEdgeMayLieFurtherOff) {
  const auto offsets = offsets_of([](double a) { return 1.5 * std::cos(2 * a); });
  EXPECT_LT(outline_shape(offsets, all_bounded(), 30, 0.7).match, 0.5);
  EXPECT_EQ(outline_shape(offsets, all_bounded(), 30, 3).match, 1);
}

}  // namespace
}  // namespace ballservo
