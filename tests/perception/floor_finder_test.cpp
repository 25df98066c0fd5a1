// Where the floor ends, in painted pictures.
#include "perception/floor_finder.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "calibration/base/fault.hpp"
#include "calibration/base/random.hpp"

namespace ballservo {
namespace {

constexpr int width = 320, height = 240;

/// Upright paths from the bottom row upwards, every second pixel; the lowest 40 rows are certain.
std::vector<FloorPath> upright_paths() {
  std::vector<FloorPath> paths;
  for (int u = 5; u < width; u += 10) {
    FloorPath path;
    for (int v = height - 1; v > 60; v -= 2) path.pixels.emplace_back(u, v);
    path.certain = 20;
    paths.push_back(path);
  }
  return paths;
}

int row_of(std::size_t index) { return height - 1 - 2 * static_cast<int>(index); }

/// Planks of a few tones of one colour with dark joints, under light that falls off, and noise.
cv::Mat planks(const cv::Scalar& bgr, std::uint64_t seed, double light = 1.0) {
  RandomEngine engine = random_stream(seed, "planks");
  cv::Mat picture(height, width, CV_8UC3);
  for (int left = 0; left < width; left += 40) {
    const double tone = uniform(engine, 0.8, 1.15) * light;
    cv::rectangle(picture, {left, 0, 40, height}, bgr * tone, cv::FILLED);
    cv::line(picture, {left, 0}, {left, height}, bgr * (0.4 * light), 2);
  }
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      auto& pixel = picture.at<cv::Vec3b>(v, u);
      const double far = 0.75 + 0.25 * v / height;
      for (int c = 0; c < 3; ++c)
        pixel[c] = cv::saturate_cast<std::uint8_t>(pixel[c] * far + 2.0 * standard_normal(engine));
    }
  }
  return picture;
}

const cv::Scalar wood(50, 90, 140), grey(120, 120, 120);

TEST(FloorFinder, BareFloorHasNoEdge) {
  for (const cv::Scalar& color : {wood, grey}) {
    FloorFinder finder(upright_paths());
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const cv::Mat picture = planks(color, seed / 3);
      for (const FloorEdge& edge : finder.look(picture)) EXPECT_EQ(edge.end, 90u);
    }
  }
}

TEST(FloorFinder, ThingsOfAnotherColourOrAnotherLightEndItToAPixelOfThePath) {
  const std::vector<cv::Scalar> things{
      {150, 30, 20}, {100, 100, 100}, {200, 200, 200}, {20, 25, 60}, {8, 9, 12}};
  for (const cv::Scalar& thing : things) {
    FloorFinder finder(upright_paths());
    finder.look(planks(wood, 3));
    cv::Mat picture = planks(wood, 3);
    const int top = 120, bottom = 160, left = 100, right = 200;
    cv::rectangle(picture, cv::Point(left, top), cv::Point(right, bottom), thing, cv::FILLED);
    const auto& edges = finder.look(picture);
    ASSERT_EQ(edges.size(), 32u);
    for (std::size_t k = 0; k < edges.size(); ++k) {
      const int u = 5 + 10 * static_cast<int>(k);
      if (u > left + 10 && u < right - 10) {
        EXPECT_NEAR(row_of(edges[k].end), bottom, 3) << u << " of " << thing;
        EXPECT_NEAR(row_of(edges[k].again), top, 5) << u << " of " << thing;
      } else if (u < left - 10 || u > right + 10) {
        EXPECT_EQ(edges[k].end, 90u) << u << " of " << thing;
      }
    }
  }
}

TEST(FloorFinder, SpecksAreNothing) {
  FloorFinder finder(upright_paths());
  cv::Mat picture = planks(wood, 3);
  finder.look(picture);
  for (int k = 0; k < 20; ++k)
    cv::rectangle(picture, cv::Rect(5 + 10 * (k + 5), 90 + 7 * (k % 5), 4, 4), {250, 40, 40}, cv::FILLED);
  for (const FloorEdge& edge : finder.look(picture)) EXPECT_EQ(edge.end, 90u);
}

TEST(FloorFinder, TheKnownBallIsFloor) {
  FloorFinder finder(upright_paths());
  finder.look(planks(wood, 3));
  cv::Mat picture = planks(wood, 3);
  cv::circle(picture, {160, 140}, 20, {20, 20, 200}, cv::FILLED);
  EXPECT_LT(finder.look(picture)[15].end, 90u);
  const OutlineEllipse ball{{160, 140}, 20};
  for (const FloorEdge& edge : finder.look(picture, &ball)) EXPECT_EQ(edge.end, 90u);
}

TEST(FloorFinder, FollowsLightThatChangesSlowly) {
  FloorFinder finder(upright_paths());
  for (int frame = 0; frame <= 240; ++frame) finder.look(planks(wood, 3, 1.0 - 0.6 * frame / 240));
  for (const FloorEdge& edge : finder.look(planks(wood, 3, 0.4))) EXPECT_EQ(edge.end, 90u);
}

TEST(FloorFinder, SaysNothingOfPicturesThatItCannotRead) {
  FloorFinder finder(upright_paths());
  EXPECT_TRUE(finder.look(cv::Mat()).empty());
  EXPECT_TRUE(finder.look(cv::Mat::zeros(height, width, CV_8UC1)).empty());
  EXPECT_TRUE(finder.look(cv::Mat::zeros(height / 2, width, CV_8UC3)).empty());
  EXPECT_FALSE(finder.look(planks(wood, 3)).empty());
  EXPECT_TRUE(finder.look(cv::Mat::zeros(height, width, CV_8UC3)).empty())
      << "a black picture: no floor at all";
  EXPECT_FALSE(finder.look(planks(wood, 3)).empty()) << "and what is known of the floor is not lost";
  EXPECT_TRUE(FloorFinder({}).look(planks(wood, 3)).empty());
}

}  // namespace
}  // namespace ballservo
