#include "app/comparison/estimators/methods.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <set>

#include "app/comparison/estimators/algebraic_circles.hpp"
#include "app/comparison/estimators/peers.hpp"
#include "calibration/base/random.hpp"

namespace ballservo {
namespace {

std::vector<RingPixel> arc(const UndistortedCircle& circle, double arc_rad, double noise_px,
                           RandomEngine& engine) {
  std::vector<RingPixel> ring;
  for (int k = 0; k < 60; ++k) {
    const double angle = arc_rad * k / 60, radius = circle.radius_px + noise_px * standard_normal(engine);
    ring.push_back(
        {circle.center_px + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)), 1.0 + k % 3, 0, 0});
  }
  return ring;
}

TEST(AlgebraicCircles, AreExactOnExactPoints) {
  RandomEngine engine = random_stream(1, "algebraic");
  const UndistortedCircle truth{{312.3, -77.9}, 24.6};
  for (const double arc_rad : {2 * M_PI, 0.8 * M_PI, 0.2 * M_PI}) {
    const std::vector<RingPixel> ring = arc(truth, arc_rad, 0, engine);
    for (const auto& circle : {kasa_circle(ring), taubin_circle(ring)}) {
      ASSERT_TRUE(circle);
      EXPECT_LT((circle->center_px - truth.center_px).norm(), 1e-7);
      EXPECT_NEAR(circle->radius_px, truth.radius_px, 1e-7);
    }
  }
}

// On short noisy arcs a smaller circle has smaller algebraic distances (Chernov, "Circular and linear
// regression", 2010): Kasa's is too small, Taubin's by much less.
TEST(AlgebraicCircles, KasaIsTooSmallOnShortArcsAndTaubinMuchLess) {
  const UndistortedCircle truth{{0, 0}, 30};
  double kasa = 0, taubin = 0;
  constexpr int rounds = 400;
  for (int round = 0; round < rounds; ++round) {
    RandomEngine engine = random_stream(2, "algebraic", static_cast<std::uint64_t>(round));
    const std::vector<RingPixel> ring = arc(truth, 0.45 * M_PI, 0.6, engine);
    kasa += (kasa_circle(ring)->radius_px - truth.radius_px) / rounds;
    taubin += (taubin_circle(ring)->radius_px - truth.radius_px) / rounds;
  }
  EXPECT_LT(kasa, -1);
  EXPECT_LT(std::abs(taubin), 0.3 * std::abs(kasa));
}

TEST(AlgebraicCircles, HaveNoAnswerWhereThereIsNone) {
  std::vector<RingPixel> line;
  for (int k = 0; k < 20; ++k) line.push_back({{1.0 * k, 2.0 * k}, 1, 0, 0});
  EXPECT_FALSE(kasa_circle(line));
  EXPECT_FALSE(taubin_circle(line));
  EXPECT_FALSE(kasa_circle({}));
  EXPECT_FALSE(taubin_circle({{{0, 0}, 1, 0, 0}, {{1, 0}, 1, 0, 0}}));
  std::vector<RingPixel> one_place(9, RingPixel{{3, 4}, 1, 0, 0});
  EXPECT_FALSE(taubin_circle(one_place));
  std::vector<RingPixel> bad(5, RingPixel{{std::nan(""), 4}, 1, 0, 0});
  EXPECT_FALSE(kasa_circle(bad));
}

TEST(FitMethods, AreNamedOnceAndHoldThePromisedOnes) {
  std::set<std::string> names;
  for (const FitMethod& method : fit_methods()) {
    EXPECT_TRUE(names.insert(method.name).second) << method.name;
    EXPECT_FALSE(method.minimises.empty());
    EXPECT_EQ(find_fit_method(method.name), &method);
  }
  for (const char* name :
       {"vote", "paper_one_step", "paper_converged", "paper_robust", "sphere_one_step", "sphere_converged",
        "hough_gradient", "hough_gradient_alt", "hsv_contour", "vpdot2"})
    EXPECT_EQ(names.count(name), 1u) << name;
  EXPECT_EQ(find_fit_method("best"), nullptr);
}

TEST(VpDot2, FindsARedDiscFromAClickOnIt) {
  cv::Mat picture(200, 260, CV_8UC3, cv::Scalar(120, 120, 110));
  cv::circle(picture, {130, 90}, 30, {20, 20, 200}, cv::FILLED, cv::LINE_AA);
  for (const VpDot2Settings& settings :
       {VpDot2Settings{true, 0.65, {80, 30}}, VpDot2Settings{true, 0, {80, 30}}}) {
    const auto blob = vpdot2_blob(picture, 0, {135, 85}, settings);
    ASSERT_TRUE(blob);
    EXPECT_LT((blob->center_px - Eigen::Vector2d(130, 90)).norm(), 0.5);
    EXPECT_NEAR(blob->radius_px, 30, 1.5);
    EXPECT_FALSE(vpdot2_blob(picture, 0, {5, 5}, settings));
    EXPECT_FALSE(vpdot2_blob(picture, 0, {-1, 500}, settings));
  }
}

}  // namespace
}  // namespace ballservo
