// Balls before things of their own colour: their outline is no region's boundary, or little of it.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "perception/candidates/inner_circles.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

const ImageSize size{320, 240};
const cv::Vec3b dark_red(14, 14, 74), darker_red(12, 12, 60), stripe_red(17, 17, 90);

cv::Mat blurred_and_noisy(cv::Mat bgr, std::uint64_t seed) {
  cv::GaussianBlur(bgr, bgr, {}, 0.7);
  RandomEngine engine = random_stream(seed, "own_color_test");
  for (int i = 0; i < 3 * size.width_px * size.height_px; ++i)
    bgr.data[i] = cv::saturate_cast<std::uint8_t>(bgr.data[i] + 2 * standard_normal(engine));
  return bgr;
}

// A box of two faces, of the ball's colour in the shade.
cv::Mat box_of_two_faces() {
  cv::Mat bgr = test::grey_picture(size.width_px, size.height_px);
  cv::rectangle(bgr, cv::Rect(70, 40, 100, 170), cv::Scalar(dark_red), cv::FILLED);
  cv::rectangle(bgr, cv::Rect(170, 40, 60, 170), cv::Scalar(darker_red), cv::FILLED);
  return bgr;
}

bool finds(const std::vector<BallObservation>& balls, const Eigen::Vector2d& center_px, double radius_px) {
  return std::any_of(balls.begin(), balls.end(), [&](const BallObservation& ball) {
    return (ball.outline.center_px - center_px).norm() < 0.1 * radius_px &&
           std::abs(ball.outline.radius_px - radius_px) < 0.1 * radius_px;
  });
}

TEST(OwnColor, ABallInFrontOfABoxIsFoundWhereverItStands) {
  const Detector made = test::detector_for(test::pinhole(size, 400));
  Detector detector(made);  // a copy, which has none of the memory that the other set aside
  int k = 0;
  for (const double u : {100.0, 130.0, 165.0, 200.0, 235.0}) {
    for (const double v : {50.0, 120.0, 200.0}) {
      for (const double radius_px : {20.0, 26.0}) {
        cv::Mat bgr = box_of_two_faces();
        test::paint_shaded_disc(bgr, {u, v}, radius_px, test::red);
        bgr = blurred_and_noisy(bgr, static_cast<std::uint64_t>(++k));
        const auto& balls = detector.detect(bgr);
        EXPECT_EQ(balls.size(), 1u) << u << " " << v << " " << radius_px;
        EXPECT_TRUE(finds(balls, {u, v}, radius_px)) << u << " " << v << " " << radius_px;
      }
    }
  }
}

TEST(OwnColor, FacesAndStripesOfABoxAreNoBalls) {
  Detector detector = test::detector_for(test::pinhole(size, 400));
  for (std::uint64_t k = 0; k < 20; ++k) {
    cv::Mat bgr = test::grey_picture(size.width_px, size.height_px);
    cv::rectangle(bgr, cv::Rect(70, 40, 160, 170), cv::Scalar(stripe_red), cv::FILLED);
    RandomEngine engine = random_stream(k, "own_color_test/stripes");
    for (int i = 0; i < 8; ++i) {
      const cv::Point from(70 + static_cast<int>(uniform_index(engine, 160)),
                           40 + static_cast<int>(uniform_index(engine, 170)));
      const cv::Size extent(6 + static_cast<int>(uniform_index(engine, 50)),
                            6 + static_cast<int>(uniform_index(engine, 50)));
      const double level = uniform(engine, 0.6, 1.4);
      const cv::Rect box = cv::Rect(from, extent) & cv::Rect(70, 40, 160, 170);
      cv::rectangle(bgr, box, cv::Scalar(stripe_red) * level, cv::FILLED);
    }
    EXPECT_TRUE(detector.detect(blurred_and_noisy(bgr, k)).empty()) << k;
  }
}

TEST(OwnColor, BallsOfOneColorThatOverlapAreBothFound) {
  Detector detector = test::detector_for(test::pinhole(size, 400));
  // Of the diameter: apart by all of it, and by so much that a third of the one behind is hidden, which it
  // may be where the light leaves no edge between the two.
  int missed = 0;
  for (const double apart : {1.0, 0.85, 0.7}) {
    for (const double turn_rad : {0.0, 0.8, 1.6, 2.4, 3.2, 4.0, 4.8, 5.6}) {
      const Eigen::Vector2d behind(160, 120),
          before = behind + 56 * apart * Eigen::Vector2d(std::cos(turn_rad), std::sin(turn_rad));
      cv::Mat bgr = test::grey_picture(size.width_px, size.height_px);
      test::paint_shaded_disc(bgr, behind, 28, test::red);
      test::paint_shaded_disc(bgr, before, 28, test::red);
      bgr = blurred_and_noisy(bgr, 1);
      const auto& balls = detector.detect(bgr);
      EXPECT_LE(balls.size(), 2u) << apart << " " << turn_rad;
      EXPECT_TRUE(finds(balls, before, 28)) << apart << " " << turn_rad;
      missed += finds(balls, behind, 28) ? 0 : 1;
    }
  }
  EXPECT_LE(missed, 1);
}

TEST(OutlineScout, FollowsTheEdgeOfADiscAndNoOther) {
  const Camera camera = test::pinhole(size, 400);
  cv::Mat disc(size.height_px, size.width_px, CV_8UC3, cv::Scalar(dark_red));
  test::paint_disc(disc, {159.5, 119.5}, 30, test::red);
  TangentCone near;
  near.alpha_rad = std::atan(33 / 400.0);
  near.axis = Eigen::Vector3d(2, -1, 400).normalized();
  ScoutedOutline found;
  ASSERT_TRUE(scout_outline(disc, camera, near, 5, 0.6, found));
  EXPECT_GE(found.points.size(), 39u) << "of 40 sectors";
  EXPECT_NEAR(std::tan(found.cone.alpha_rad) * 400, 30, 0.3);
  EXPECT_LT(found.cone.axis.head<2>().norm() * 400, 0.3);
  for (const BoundaryPoint& point : found.points) EXPECT_NEAR(point.position_px.norm(), 30, 0.8);

  cv::Mat box(size.height_px, size.width_px, CV_8UC3, cv::Scalar(dark_red));
  cv::rectangle(box, cv::Rect(130, 90, 60, 60), cv::Scalar(test::red), cv::FILLED);
  EXPECT_FALSE(scout_outline(box, camera, near, 5, 0.6, found));
  cv::Mat flat(size.height_px, size.width_px, CV_8UC3, cv::Scalar(dark_red));
  EXPECT_FALSE(scout_outline(flat, camera, near, 5, 0.6, found));
  near.axis = Eigen::Vector3d(-160, -120, 400).normalized();  // three quarters of it outside the picture
  EXPECT_FALSE(scout_outline(disc, camera, near, 5, 0.6, found));
}

}  // namespace
}  // namespace ballservo
