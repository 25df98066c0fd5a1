#include "perception/judgement/occluding_edge.hpp"

#include <gtest/gtest.h>

#include <array>

#include "calibration/base/random.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

const Eigen::Vector2d center_px(160, 120);
constexpr double radius_px = 30;
const cv::Vec3b card(200, 190, 60);

// A wall of squares, each a little another grey.
cv::Mat wall(int contrast) {
  cv::Mat bgr = test::grey_picture();
  RandomEngine engine = random_stream(3, "wall");
  for (int v = 0; v < bgr.rows; v += 12) {
    for (int u = 0; u < bgr.cols; u += 12) {
      const double level = 120 + contrast * standard_normal(engine);
      bgr(cv::Rect(u, v, 12, 12) & cv::Rect({0, 0}, bgr.size())) = cv::Scalar::all(level);
    }
  }
  return bgr;
}

// A flat red disc, of which a line at that angle and distance from the centre (radii) leaves one side.
void paint_half(cv::Mat& bgr, double angle, double distance) {
  const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
  test::paint(bgr, test::red, [&](const Eigen::Vector2d& p) {
    return (p - center_px).norm() <= radius_px && (p - center_px).dot(normal) < distance * radius_px;
  });
}
void paint_card(cv::Mat& bgr, double angle, double distance) {
  const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
  test::paint(bgr, card, [&](const Eigen::Vector2d& p) {
    const double beyond = (p - center_px).dot(normal) - distance * radius_px;
    return beyond >= 0 && beyond < 80;
  });
}

bool is_behind(const cv::Mat& bgr) {
  BitPicture red;
  red.resize(bgr.size());
  for (int v = 0; v < bgr.rows; ++v)
    for (int u = 0; u < bgr.cols; ++u)
      red.fill(v, u, u + 1, bgr.at<cv::Vec3b>(v, u)[2] > 2 * bgr.at<cv::Vec3b>(v, u)[1]);
  return is_behind_straight_edge(bgr, {1, red, {0, 0}}, {center_px, radius_px});
}

struct Cut {
  double angle, distance;
};
constexpr std::array<Cut, 8> cuts{
    {{0.3, -0.25}, {0.9, 0}, {2, -0.25}, {2.6, 0}, {3.5, 0.2}, {4, -0.4}, {5, 0}, {5.5, -0.25}}};

TEST(OccludingEdge, GoesOnBeyondTheBall) {
  for (const int contrast : {0, 6}) {
    for (const Cut& cut : cuts) {
      cv::Mat bgr = wall(contrast);
      paint_half(bgr, cut.angle, cut.distance);
      EXPECT_FALSE(is_behind(bgr)) << contrast << ' ' << cut.angle;
      paint_card(bgr, cut.angle, cut.distance);
      EXPECT_TRUE(is_behind(bgr)) << contrast << ' ' << cut.angle;
    }
  }
}

// On one side alone something else may happen to end there.
TEST(OccludingEdge, GoesOnAtBothEnds) {
  cv::Mat bgr = test::grey_picture();
  paint_half(bgr, 0, 0);
  cv::rectangle(bgr, {160, 0}, {319, 89}, cv::Scalar(card), cv::FILLED);
  EXPECT_FALSE(is_behind(bgr));
}

// The chord is where the colour ends: another line through the outline is none.
TEST(OccludingEdge, IsWhereTheColorEnds) {
  for (double angle = 0; angle < 6.2; angle += 2 * M_PI / 72) {
    cv::Mat bgr = test::grey_picture();
    paint_card(bgr, angle, 0.61);
    test::paint_disc(bgr, center_px, radius_px, test::red);
    EXPECT_FALSE(is_behind(bgr)) << angle;
  }
}

// A matt sphere in a lamp's light, or a flat disc, with the shadow of something unseen slantwise across; to
// the right of its middle is a card.
cv::Mat in_half_shadow(bool is_sphere) {
  cv::Mat bgr = test::grey_picture();
  const Eigen::Vector3d lamp = Eigen::Vector3d(-0.9, -0.3, 0.4).normalized();
  test::paint_disc(bgr, center_px, radius_px, test::red);
  for (int v = 0; v < bgr.rows; ++v) {
    for (int u = 0; u < bgr.cols; ++u) {
      const Eigen::Vector2d n = (Eigen::Vector2d(u, v) - center_px) / radius_px;
      if (n.norm() > 1) continue;
      const Eigen::Vector3d normal(n.x(), n.y(), std::sqrt(1 - n.squaredNorm()));
      const double lit = is_sphere ? std::max(0.0, normal.dot(lamp)) : 0.8;
      const bool in_shadow = n.y() > 0.8 * n.x() + 0.6;
      bgr.at<cv::Vec3b>(v, u) = test::red * (0.3 + (in_shadow ? 0 : 0.9 * lit));
    }
  }
  cv::rectangle(bgr, {160, 0}, {319, 239}, cv::Scalar(card), cv::FILLED);
  cv::GaussianBlur(bgr, bgr, {}, 0.7);
  return bgr;
}

TEST(OccludingEdge, SpeaksForAHalfHiddenBallInAShadowButForNoDisc) {
  DetectorOptions options;
  options.response = ResponseChoice::srgb;
  Detector detector(std::make_shared<const RayTable>(test::pinhole({320, 240}, 500)), test::red_and_green(),
                    options);
  const auto balls = detector.detect(in_half_shadow(true));
  ASSERT_EQ(balls.size(), 1u);
  EXPECT_LT((balls[0].outline.center_px - center_px).norm(), 0.05 * radius_px);
  EXPECT_TRUE(detector.detect(in_half_shadow(false)).empty());
}

}  // namespace
}  // namespace ballservo
