#include "calibration/circles/circle_vote.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ballservo {
namespace {

// Integer boundary pixels of a circle's arc, as a segmentation gives them.
std::vector<Eigen::Vector2f> arc(const Eigen::Vector2d& center, double radius, double part = 1) {
  std::vector<Eigen::Vector2f> points;
  const int count = static_cast<int>(2 * M_PI * radius * part);
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * part * i / count;
    const Eigen::Vector2d p = center + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    points.emplace_back(static_cast<float>(std::round(p.x())), static_cast<float>(std::round(p.y())));
  }
  return points;
}

std::optional<CircleEstimate> estimate(const std::vector<Eigen::Vector2f>& points, std::uint64_t seed = 0) {
  CircleVoter voter;
  auto engine = random_stream(seed, "circle_vote_test");
  std::vector<BoundaryPoint> boundary;
  for (const Eigen::Vector2f& p : points) boundary.push_back({p, {0, 0}});
  return voter.estimate(boundary, engine);
}

TEST(Circumcenter, IsEquallyFarFromItsPoints) {
  auto engine = random_stream(1, "circumcenter");
  for (int i = 0; i < 1000; ++i) {
    const auto draw = [&] { return Eigen::Vector2d(uniform(engine, -1e3, 1e3), uniform(engine, -1e3, 1e3)); };
    const Eigen::Vector2d a = draw(), b = draw(), c = draw();
    const auto center = circumcenter(a, b, c);
    if (!center) continue;
    EXPECT_NEAR((*center - a).norm(), (*center - b).norm(), 1e-6 * (*center - a).norm());
    EXPECT_NEAR((*center - a).norm(), (*center - c).norm(), 1e-6 * (*center - a).norm());
  }
}

TEST(Circumcenter, CollinearOrRepeatedPointsHaveNone) {
  EXPECT_FALSE(circumcenter({0, 0}, {1, 1}, {2, 2}));
  EXPECT_FALSE(circumcenter({0, 0}, {0, 0}, {2, 1}));
  EXPECT_FALSE(circumcenter({0, 0}, {std::nan(""), 0}, {2, 1}));
}

TEST(CircleVote, FindsACircle) {
  for (const double radius : {8.0, 30.0, 90.0}) {
    const auto circle = estimate(arc({200.3, 120.7}, radius));
    ASSERT_TRUE(circle);
    EXPECT_LT((circle->center_px - Eigen::Vector2d(200.3, 120.7)).norm(), 1.0);
    EXPECT_NEAR(circle->radius_px, radius, 0.7);
    EXPECT_TRUE(circle->stopped);
  }
}

TEST(CircleVote, MovesWithThePicture) {
  auto points = arc({60, 50}, 20);
  const auto before = estimate(points);
  for (Eigen::Vector2f& p : points) p += Eigen::Vector2f(37, -12);
  const auto after = estimate(points);
  EXPECT_LT((after->center_px - before->center_px - Eigen::Vector2d(37, -12)).norm(), 1e-4);
  EXPECT_NEAR(after->radius_px, before->radius_px, 1e-4);
}

TEST(CircleVote, FindsAHalfHiddenCircle) {
  const auto circle = estimate(arc({100, 100}, 30, 0.45));
  ASSERT_TRUE(circle);
  EXPECT_LT((circle->center_px - Eigen::Vector2d(100, 100)).norm(), 3);
}

TEST(CircleVote, QualityTellsRoundFromNot) {
  std::vector<Eigen::Vector2f> rectangle;
  for (int i = 0; i < 60; ++i) {
    rectangle.emplace_back(static_cast<float>(i), 0.f);
    rectangle.emplace_back(static_cast<float>(i), 25.f);
  }
  for (int i = 0; i < 25; ++i) {
    rectangle.emplace_back(0.f, static_cast<float>(i));
    rectangle.emplace_back(60.f, static_cast<float>(i));
  }
  // The paper: typically four times larger for a round region.
  EXPECT_GT(estimate(arc({50, 50}, 27))->quality(), 4 * estimate(rectangle)->quality());
}

TEST(CircleVote, SameSeedSameAnswer) {
  const auto a = estimate(arc({50, 60}, 22), 5), b = estimate(arc({50, 60}, 22), 5);
  EXPECT_EQ(a->center_px, b->center_px);
  EXPECT_EQ(a->votes, b->votes);
}

TEST(CircleVote, TooFewOrDegeneratePointsHaveNoCircle) {
  EXPECT_FALSE(estimate({}));
  EXPECT_FALSE(estimate(std::vector<Eigen::Vector2f>(5, {1, 2})));
  EXPECT_FALSE(estimate(std::vector<Eigen::Vector2f>(50, {1, 2})));
  std::vector<Eigen::Vector2f> line;
  for (int i = 0; i < 50; ++i) line.emplace_back(static_cast<float>(i), 3.f);
  EXPECT_FALSE(estimate(line));
}

}  // namespace
}  // namespace ballservo
