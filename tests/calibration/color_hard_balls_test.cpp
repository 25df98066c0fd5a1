// Balls that are easily missed, and things that are no balls.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "calibration/base/fault.hpp"
#include "calibration/teaching/learn_colors.hpp"
#include "tests/calibration/color_pictures.hpp"

namespace ballservo {
namespace {

using namespace test;

/// A ball that moves by (dx, dy) while the shutter is open.
cv::Mat smeared(double cx, double cy, double radius, double dx, double dy, const Eigen::Vector3d& paint) {
  constexpr int moments = 24;
  cv::Mat sum(240, 320, CV_32FC3, cv::Scalar::all(0));
  for (int i = 0; i < moments; ++i) {
    const double t = (i + 0.5) / moments - 0.5;
    cv::Mat picture = grey_picture();
    draw_shaded_ball(picture, cx + t * dx, cy + t * dy, radius, paint);
    cv::Mat single;
    picture.convertTo(single, CV_32F, 1.0 / moments);
    sum += single;
  }
  cv::Mat result;
  sum.convertTo(result, CV_8U);
  add_noise(result, 2, 3);
  return result;
}

const LearntCircle& only_ball(const LearntColors& colors, const std::string& name) {
  EXPECT_EQ(colors.circles.size(), 1u);
  return colors.circles.at(name).at(0);
}

/// The share of the pixels within `rim` radii that have the first class.
double told_inside(const ColorTable& table, const cv::Mat& picture, const LearntCircle& circle, double rim) {
  int told = 0, looked_at = 0;
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      if ((Eigen::Vector2d(x, y) - circle.center_px).norm() > rim * circle.radius_px) continue;
      const cv::Vec3b c = picture.at<cv::Vec3b>(y, x);
      told += table.classify(c[0], c[1], c[2]) == 1 ? 1 : 0;
      ++looked_at;
    }
  }
  return static_cast<double>(told) / looked_at;
}

TEST(HardBalls, SmearedByMotion) {
  const LearntColors colors = learn_colors({{"throw.png", smeared(160, 120, 24, 60, 24, green_paint)}});
  const LearntCircle& ball = only_ball(colors, "green");
  EXPECT_LT((ball.center_px - Eigen::Vector2d(160, 120)).norm(), 4);
  const cv::Vec3b core = smeared(160, 120, 24, 60, 24, green_paint).at<cv::Vec3b>(120, 160);
  EXPECT_EQ(colors.table.classify(core[0], core[1], core[2]), 1);
  EXPECT_EQ(colors.table.classify(140, 140, 140), no_class);
  ASSERT_EQ(colors.doubts.size(), 1u);
  EXPECT_NE(colors.doubts[0].find("ellipse"), std::string::npos);
}

TEST(HardBalls, AShadowOfItsShapeIsNoBall) {
  cv::Mat picture = grey_picture();
  cv::ellipse(picture, {230, 170}, {34, 24}, 20, 0, 360, {104, 106, 108}, cv::FILLED);
  draw_shaded_ball(picture, 100, 80, 26, green_paint);
  add_noise(picture, 2, 3);
  const LearntColors colors = learn_colors({{"shadow.png", picture}});
  EXPECT_LT((only_ball(colors, "green").center_px - Eigen::Vector2d(100, 80)).norm(), 2);
  const cv::Vec3b shadow = picture.at<cv::Vec3b>(170, 230);
  EXPECT_EQ(colors.table.classify(shadow[0], shadow[1], shadow[2]), no_class);
}

TEST(HardBalls, TenPixelsAcross) {
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 200.4, 77.3, 5.2, red_paint);
  add_noise(picture, 2, 8);
  const LearntColors colors = learn_colors({{"far.png", picture}});
  const LearntCircle& ball = only_ball(colors, "red");
  EXPECT_LT((ball.center_px - Eigen::Vector2d(200.4, 77.3)).norm(), 1);
  EXPECT_NEAR(ball.radius_px, 5.2, 1);
}

TEST(HardBalls, MarbledInOneHue) {
  // Bands of one green in three strengths, as a marbled ball has: no single strength is round.
  cv::Mat picture = grey_picture(), band;
  const Eigen::Vector3d strengths[] = {green_paint, 0.5 * green_paint + 0.2 * grey_paint,
                                       0.3 * green_paint + 0.7 * grey_paint};
  cv::Mat painted[3];
  for (int k = 0; k < 3; ++k) {
    painted[k] = grey_picture();
    draw_shaded_ball(painted[k], 160, 120, 48, strengths[k]);
  }
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x)
      picture.at<cv::Vec3b>(y, x) = painted[(2 * y + x) / 34 % 3].at<cv::Vec3b>(y, x);
  }
  add_noise(picture, 2, 5);
  const LearntCircle ball = only_ball(learn_colors({{"marble.png", picture}}), "green");
  EXPECT_LT((ball.center_px - Eigen::Vector2d(160, 120)).norm(), 3);
  EXPECT_NEAR(ball.radius_px, 48, 4);
}

TEST(HardBalls, TakenInTooLittleLight) {
  // A faint green (chroma 15) on grey, at half its sRGB values: chroma 8 at most.
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 200, 90, 28, {0.040, 0.080, 0.046}, 0.4);
  picture.convertTo(picture, -1, 0.5);
  add_noise(picture, 1, 8);
  const LearntColors colors = learn_colors({{"dusk.png", picture}});
  const LearntCircle& ball = only_ball(colors, "green");
  EXPECT_LT((ball.center_px - Eigen::Vector2d(200, 90)).norm(), 1);
  EXPECT_NEAR(ball.radius_px, 28, 1.5);
  EXPECT_GT(told_inside(colors.table, picture, ball, 0.85), 0.87);
  EXPECT_EQ(told_inside(colors.table, picture, {0, 0, {100, 180}, 50}, 1), 0);
}

TEST(HardBalls, TakenWithMuchNoise) {
  // The grey wall's noise has more pixels of the ball's colours than the ball.
  cv::Mat picture(480, 640, CV_8UC3, cv::Scalar::all(140));
  draw_shaded_ball(picture, 200, 90, 28, {0.07, 0.13, 0.08}, 0.4);
  add_noise(picture, 8, 8);
  const LearntColors colors = learn_colors({{"night.png", picture}});
  const LearntCircle& ball = only_ball(colors, "green");
  EXPECT_LT((ball.center_px - Eigen::Vector2d(200, 90)).norm(), 1.5);
  EXPECT_NEAR(ball.radius_px, 28, 2);
  // Learnt with their noise: smoothed samples would miss most of the ball's pixels.
  EXPECT_GT(told_inside(colors.table, picture, ball, 0.9), 0.9);
  EXPECT_LT(told_inside(colors.table, picture, {0, 0, {450, 300}, 100}, 1), 0.15);
}

TEST(HardBalls, ABlackDiscWithATintIsNoBall) {
  RoundRegion disc;
  disc.center_px = {160, 120};
  disc.radius_px = 30;
  RoundRegions found;
  found.regions = {disc};
  const auto candidates_of = [&](const cv::Scalar& bgr) {
    cv::Mat picture = grey_picture();
    cv::circle(picture, {160, 120}, 30, bgr, cv::FILLED);
    return ball_candidates({"knob.png", picture}, 0, found).size();
  };
  EXPECT_EQ(candidates_of({24, 30, 25}), 0u);
  EXPECT_EQ(candidates_of({40, 60, 42}), 1u);
}

TEST(HardBalls, ASpeckOfTheBallsColorDoesNotCount) {
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 100, 120, 45, yellow_paint);
  cv::circle(picture, {260, 60}, 6, {40, 200, 215}, cv::FILLED);
  add_noise(picture, 2, 5);
  const LearntColors colors = learn_colors({{"speck.png", picture}});
  ASSERT_EQ(colors.circles.at("yellow").size(), 1u);
  EXPECT_NEAR(colors.circles.at("yellow")[0].radius_px, 45, 3);
}

TEST(HardBalls, PipsBesideABallAreNoClassOfTheirOwn) {
  const auto picture_of = [](double ball_radius_px) {
    cv::Mat picture = grey_picture();
    for (int i = 0; i < 6; ++i) draw_shaded_ball(picture, 30 + 22 * i, 200, 5.4, red_paint);
    draw_shaded_ball(picture, 200, 90, ball_radius_px, green_paint);
    add_noise(picture, 2, 5);
    return picture;
  };
  EXPECT_EQ(learn_colors({{"near.png", picture_of(30)}}).circles.count("red"), 0u);
  EXPECT_EQ(learn_colors({{"far.png", picture_of(9)}}).circles.count("red"), 1u);
}

/// The outline of a thing that is round but for `wave_px`.
std::vector<cv::Point> wavy_outline(double radius_px, double wave_px) {
  std::vector<cv::Point> outline;
  for (int i = 0; i < 360; ++i) {
    const double angle = i * CV_PI / 180, r = radius_px + wave_px * std::sin(7 * angle);
    outline.emplace_back(cvRound(160 + r * std::cos(angle)), cvRound(120 + r * std::sin(angle)));
  }
  return outline;
}

void expect_the_red_ball(cv::Mat picture) {
  draw_shaded_ball(picture, 120, 90, 11, red_paint);
  add_noise(picture, 2, 5);
  const LearntColors colors = learn_colors({{"carpet.png", picture}});
  ASSERT_EQ(colors.circles.count("red"), 1u);
  EXPECT_LT((colors.circles.at("red")[0].center_px - Eigen::Vector2d(120, 90)).norm(), 1);
}

TEST(HardBalls, BeforeALargeThingThatIsHardlyRound) {
  cv::Mat picture = grey_picture();
  cv::fillPoly(picture, std::vector{wavy_outline(95, 7.5)}, {60, 150, 60});
  expect_the_red_ball(picture);
}

TEST(HardBalls, BeforeAPatternThatIsRound) {
  cv::Mat picture(240, 320, CV_8UC3, cv::Scalar(112, 145, 112));
  cv::polylines(picture, std::vector{wavy_outline(95, 0)}, true, {140, 140, 140}, 3);
  expect_the_red_ball(picture);
}

/// A green ball, a bar of its colour, and something red that is hardly round, with or without a red bar.
cv::Mat ball_beside_its_color(double ball_radius_px, cv::Size green_bar, cv::Size red_bar) {
  cv::Mat picture = grey_picture();
  cv::fillPoly(picture, std::vector{wavy_outline(24, 2)}, {50, 50, 170});
  cv::rectangle(picture, {{250, 20}, red_bar}, {50, 50, 170}, cv::FILLED);
  draw_shaded_ball(picture, 60, 60, ball_radius_px, green_paint, 0.9);
  cv::rectangle(picture, {{20, 150}, green_bar}, picture.at<cv::Vec3b>(60, 60), cv::FILLED);
  add_noise(picture, 2, 5);
  return picture;
}

TEST(HardBalls, BesideMoreOfItsColorABallIsLearntBeforeWhatIsHardlyRound) {
  const cv::Mat picture = ball_beside_its_color(22, {30, 75}, {0, 0});
  const LearntColors colors = learn_colors({{"bar.png", picture}});
  EXPECT_LT((only_ball(colors, "green").center_px - Eigen::Vector2d(60, 60)).norm(), 1);
}

TEST(HardBalls, BesideMuchMoreOfItsColorABallMustBePointedAt) {
  const cv::Mat picture = ball_beside_its_color(10, {130, 80}, {60, 60});
  try {
    learn_colors({{"bar.png", picture}});
    FAIL();
  } catch (const Refusal& refusal) {
    EXPECT_NE(std::string(refusal.what()).find("--at NAME=60,60,1"), std::string::npos) << refusal.what();
  }
}

TEST(HardBalls, BarsAndBoxesAreNotSmearedBalls) {
  cv::Mat picture = grey_picture();
  cv::rectangle(picture, cv::Rect(40, 40, 70, 45), {40, 40, 200}, cv::FILLED);
  cv::rectangle(picture, cv::Rect(190, 120, 45, 80), {40, 190, 40}, cv::FILLED);
  EXPECT_THROW(learn_colors({{"boxes.png", picture}}), Refusal);
}

TEST(HardBalls, PicturesOfTheBackgroundTakeItsColorAway) {
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 160, 120, 45, yellow_paint, 0.05);
  add_noise(picture, 2, 5);
  const cv::Vec3b shade = picture.at<cv::Vec3b>(150, 185), light = picture.at<cv::Vec3b>(108, 148);
  cv::Mat curtain(240, 320, CV_8UC3, cv::Scalar(shade[0], shade[1], shade[2]));
  add_noise(curtain, 3, 6);
  const auto claimed = [&](const LearntColors& colors) {
    int count = 0;
    for (const cv::Vec3b& c : cv::Mat_<cv::Vec3b>(curtain))
      count += colors.table.classify(c[0], c[1], c[2]) != no_class;
    return static_cast<double>(count) / static_cast<double>(curtain.total());
  };
  const LearntColors without = learn_colors({{"ball.png", picture}});
  const LearntColors with = learn_colors({{"ball.png", picture}}, {}, {{"curtain.png", curtain}});
  EXPECT_GT(claimed(without), 0.9);
  EXPECT_LT(claimed(with), 0.05);
  EXPECT_EQ(with.table.classify(light[0], light[1], light[2]), 1);
}

TEST(HardBalls, GreyPicturesAreRefusedByName) {
  cv::Mat grey = grey_picture(), ball = grey_picture();
  draw_shaded_ball(grey, 160, 120, 40, grey_paint);
  draw_shaded_ball(ball, 160, 120, 40, red_paint);
  const auto learn = [](const std::vector<ColorPicture>& pictures, bool bare) {
    return bare ? learn_colors(pictures) : learn_classes(pictures, {{"red", {0, 1}, {}}});
  };
  for (const bool bare : {true, false}) {
    try {
      learn({{"dusk.png", grey}, {"night.png", grey}}, bare);
      FAIL();
    } catch (const Refusal& refusal) {
      EXPECT_EQ(std::string(refusal.what()).find("dusk.png, night.png: grey"), 0u) << refusal.what();
    }
    const LearntColors colors = learn({{"ball.png", ball}, {"night.png", grey}}, bare);
    EXPECT_NE(colors.doubts.at(0).find("from night.png:"), std::string::npos) << colors.doubts[0];
  }
  try {
    learn_classes({{"ball.png", ball}, {"night.png", grey}}, {{"red", {0}, {}}, {"blue", {1}, {}}});
    FAIL();
  } catch (const Refusal& refusal) {
    EXPECT_EQ(std::string(refusal.what()).find("night.png: grey"), 0u) << refusal.what();
  }
}

}  // namespace
}  // namespace ballservo
