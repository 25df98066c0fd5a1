#include "servo/simulation/world/texture.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ballservo {
namespace {

Rgb texture_color(const Texture& texture, const Eigen::Vector2d& uv_m, const Eigen::Vector2d& patch_m) {
  const Triples colors = texture_colors(texture, {spread(uv_m.x()), spread(uv_m.y())},
                                        {spread(patch_m.x()), spread(patch_m.y())});
  return {colors.x[0], colors.y[0], colors.z[0]};
}

/// Mean colour over a patch by many point samples.
Rgb sampled(const Texture& texture, const Eigen::Vector2d& uv, double side) {
  Rgb sum = Rgb::Zero();
  constexpr int count = 60;
  for (int j = 0; j < count; ++j) {
    for (int i = 0; i < count; ++i) {
      sum += texture_color(texture,
                           uv + side * Eigen::Vector2d((i + 0.5) / count - 0.5, (j + 0.5) / count - 0.5),
                           {1e-6, 1e-6});
    }
  }
  return sum / (count * count);
}

TEST(Texture, APatchShowsTheMeanOfItsPoints) {
  for (const Pattern pattern : {Pattern::checks, Pattern::tiles}) {
    const Texture texture{pattern, {0.8, 0.6, 0.4}, {0.2, 0.1, 0.3}, 0.3};
    for (double u = -1; u < 1; u += 0.173) {
      const Eigen::Vector2d uv(u, 0.7 * u + 0.05);
      const Rgb patch = texture_color(texture, uv, {0.12, 0.12});
      EXPECT_LT((patch - sampled(texture, uv, 0.12)).cwiseAbs().maxCoeff(), 0.06)
          << pattern_name(pattern) << " " << u;
    }
  }
}

TEST(Texture, LargePatchesShowNoPattern) {
  for (const Pattern pattern : all_patterns) {
    const Texture texture{pattern, {0.8, 0.6, 0.4}, {0.2, 0.1, 0.3}, 0.1};
    const Rgb first = texture_color(texture, {0, 0}, {5, 5});
    for (double u = 0.03; u < 3; u += 0.11) {
      EXPECT_LT((texture_color(texture, {u, 1.3 * u}, {5, 5}) - first).cwiseAbs().maxCoeff(), 0.05)
          << pattern_name(pattern);
    }
  }
}

TEST(Texture, ReflectancesStayWithinTheUnitRange) {
  for (const Pattern pattern : all_patterns) {
    const Texture texture{pattern, {1, 1, 1}, {0, 0, 0}, 0.07};
    for (double u = -10; u < 10; u += 0.0371) {
      const Rgb color = texture_color(texture, {u, -0.61 * u}, {0.002, 0.01});
      EXPECT_GE(color.minCoeff(), 0);
      EXPECT_LE(color.maxCoeff(), 1);
    }
  }
}

TEST(Texture, ColourWordsIgnoreTheirNumber) {
  EXPECT_EQ(*color_from_word("red_2"), *color_from_word("red"));
  EXPECT_FALSE(color_from_word("reddish"));
  EXPECT_FALSE(color_from_word(""));
}

}  // namespace
}  // namespace ballservo
