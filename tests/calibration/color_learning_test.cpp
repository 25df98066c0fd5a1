#include <gtest/gtest.h>

#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "calibration/base/fault.hpp"
#include "calibration/color/color_file.hpp"
#include "calibration/teaching/chroma_picture.hpp"
#include "calibration/teaching/class_report.hpp"
#include "calibration/teaching/learn_colors.hpp"
#include "tests/calibration/color_pictures.hpp"
#include "tests/support/faults.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using namespace test;

std::set<std::string> names(const LearntColors& colors) {
  std::set<std::string> result;
  for (const ColorClass& color : colors.table.classes) result.insert(color.name);
  return result;
}

/// The part of the disc's pixels that are of the class.
double disc_fraction(const ColorTable& colors, const cv::Mat& bgr, double cx, double cy, double radius,
                     const std::string& name) {
  int all = 0, of_class = 0;
  for (int y = 0; y < bgr.rows; ++y) {
    for (int x = 0; x < bgr.cols; ++x) {
      if (std::hypot(x - cx, y - cy) > radius) continue;
      const cv::Vec3b& c = bgr.at<cv::Vec3b>(y, x);
      ++all;
      of_class += colors.classify(c[0], c[1], c[2]) == colors.find(name).value_or(200) ? 1 : 0;
    }
  }
  return static_cast<double>(of_class) / all;
}

ColorPicture four_balls() {
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 60, 60, 30, red_paint);
  draw_shaded_ball(picture, 220, 60, 34, green_paint);
  draw_shaded_ball(picture, 80, 170, 28, blue_paint);
  draw_shaded_ball(picture, 240, 170, 36, yellow_paint);
  add_noise(picture, 2, 1);
  return {"four.png", picture};
}

const LearntColors& learnt_from_four_balls() {
  static const LearntColors colors = learn_colors({four_balls()});
  return colors;
}

TEST(Chroma, IsBlindToLuminance) {
  // Two halves of one chroma and different lightness: the same picture, as far as chroma goes.
  cv::Mat chroma(40, 60, CV_32FC2, cv::Scalar(30, -12));
  const cv::Mat modes = smoothed_chroma(chroma);
  EXPECT_LT(cv::norm(modes, chroma, cv::NORM_INF), 1e-4);
  // Greys of every lightness have one chroma.
  cv::Mat ramp(20, 256, CV_8UC3);
  for (int x = 0; x < 256; ++x) ramp.col(x).setTo(cv::Scalar(x, x, x));
  EXPECT_LT(cv::norm(chroma_image(ramp), cv::NORM_INF), 1e-4);
}

TEST(Chroma, KeepsEdgesAndRemovesNoise) {
  cv::Mat picture(60, 80, CV_8UC3, cv::Scalar(60, 60, 200));
  picture.colRange(40, 80).setTo(cv::Scalar(60, 180, 60));
  const cv::Mat clean = chroma_image(picture);
  add_noise(picture, 4, 3);
  const cv::Mat noisy = chroma_image(picture);
  const cv::Mat modes = smoothed_chroma(noisy);
  cv::Mat before = noisy - clean, after = modes - clean;
  EXPECT_LT(cv::norm(after), 0.35 * cv::norm(before));
}

/// Those that are rather balls than not.
std::vector<RoundRegion> likely_balls(const cv::Mat& picture) {
  std::vector<RoundRegion> result;
  for (const RoundRegion& region : find_round_regions(picture).regions) {
    if (region.evidence.log_odds() > 0) result.push_back(region);
  }
  return result;
}

TEST(RoundRegions, ShadingDoesNotSplitABall) {
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 160.3, 119.6, 60, red_paint, 0.1);
  const std::vector<RoundRegion> found = likely_balls(picture);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_LT((found[0].center_px - Eigen::Vector2d(160.3, 119.6)).norm(), 1.0);
  EXPECT_NEAR(found[0].radius_px, 60, 1.5);
  EXPECT_GT(found[0].fit_ratio(), 0.85);
  EXPECT_GT(found[0].evidence.arc, 0.9);
}

TEST(RoundRegions, MovesWithThePicture) {
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 100, 90, 30, green_paint);
  cv::Mat moved = grey_picture();
  draw_shaded_ball(moved, 157, 121, 30, green_paint);
  const std::vector<RoundRegion> here = likely_balls(picture);
  const std::vector<RoundRegion> there = likely_balls(moved);
  ASSERT_EQ(here.size(), 1u);
  ASSERT_EQ(there.size(), 1u);
  EXPECT_LT((there[0].center_px - here[0].center_px - Eigen::Vector2d(57, 31)).norm(), 0.01);
}

TEST(RoundRegions, SquaresBarsAndGreyDiscsAreNoBalls) {
  cv::Mat picture = grey_picture();
  cv::rectangle(picture, cv::Rect(20, 20, 70, 70), {40, 40, 200}, cv::FILLED);
  cv::rectangle(picture, cv::Rect(120, 20, 150, 25), {40, 190, 40}, cv::FILLED);
  cv::circle(picture, {200, 150}, 40, {60, 60, 60}, cv::FILLED);
  for (const RoundRegion& region : find_round_regions(picture).regions)
    EXPECT_LT(region.evidence.log_odds(), 0);
}

TEST(RoundRegions, AFistAroundABallIsNoBall) {
  cv::Mat picture = grey_picture();
  cv::circle(picture, {160, 120}, 80, {120, 130, 190}, cv::FILLED, cv::LINE_AA);
  draw_shaded_ball(picture, 150, 105, 40, green_paint);
  double largest_px = 0;
  for (const RoundRegion& region : likely_balls(picture)) largest_px = std::max(largest_px, region.radius_px);
  EXPECT_NEAR(largest_px, 40, 2);
}

TEST(RoundRegions, LargePicturesGiveCoordinatesOfTheOriginal) {
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 160, 120, 50, blue_paint);
  RegionSearchOptions search;
  search.max_working_pixels = 160 * 120;
  const RoundRegions found = find_round_regions(picture, search);
  ASSERT_EQ(found.regions.size(), 1u);
  EXPECT_NEAR(found.scale, 0.5, 1e-9);
  EXPECT_LT((found.regions[0].center_px - Eigen::Vector2d(160, 120)).norm(), 1.0);
  EXPECT_NEAR(found.regions[0].radius_px, 50, 2);
}

TEST(LearnColors, NamesEveryColorOfAPicture) {
  const ColorPicture picture = four_balls();
  const LearntColors& colors = learnt_from_four_balls();
  EXPECT_EQ(names(colors), (std::set<std::string>{"red", "green", "blue", "yellow"}));
  EXPECT_GT(disc_fraction(colors.table, picture.bgr, 60, 60, 27, "red"), 0.95);
  EXPECT_GT(disc_fraction(colors.table, picture.bgr, 220, 60, 31, "green"), 0.95);
  EXPECT_GT(disc_fraction(colors.table, picture.bgr, 80, 170, 25, "blue"), 0.95);
  EXPECT_GT(disc_fraction(colors.table, picture.bgr, 240, 170, 33, "yellow"), 0.95);
  for (const auto& [name, circles] : colors.circles) EXPECT_EQ(circles.size(), 1u) << name;
  for (const ClassReport& report : report_classes(colors.table)) {
    EXPECT_LT(report.background_fraction, 0.002);
    EXPECT_GT(report.kept_fraction, 0.97);
  }
}

TEST(LearnColors, GreyBlackAndWhiteHaveNoClass) {
  const LearntColors& colors = learnt_from_four_balls();
  for (int v = 0; v < 256; ++v) {
    const auto grey = static_cast<std::uint8_t>(v);
    EXPECT_EQ(colors.table.classify(grey, grey, grey), no_class) << v;
  }
  EXPECT_EQ(colors.table.classify(2, 2, 10), no_class);  // nearly black, whatever its hue
}

TEST(LearnColors, ANearlyBlackDiscIsNoClass) {
  ColorPicture picture = four_balls();
  cv::circle(picture.bgr, {150, 115}, 26, {11, 6, 30}, cv::FILLED);  // some hue, hardly any light
  EXPECT_EQ(names(learn_colors({picture})), (std::set<std::string>{"red", "green", "blue", "yellow"}));
}

TEST(LearnColors, AnotherLightIsStillTheSameBall) {
  const LearntColors& colors = learnt_from_four_balls();
  cv::Mat dim = grey_picture();
  draw_shaded_ball(dim, 160, 120, 40, 0.6 * red_paint);
  EXPECT_GT(disc_fraction(colors.table, dim, 160, 120, 36, "red"), 0.9);
}

TEST(LearnColors, RedSurvivesTheWrapOfHue) {
  // Reds on both sides of hue 0, in one picture: one of them at 350 degrees, the other at 10.
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 90, 120, 40, {0.28, 0.05, 0.6});
  draw_shaded_ball(picture, 230, 120, 40, {0.24, 0.05, 0.6});
  const LearntColors colors = learn_colors({{"wrap.png", picture}});
  ASSERT_EQ(colors.circles.size(), 1u);
  EXPECT_EQ(colors.circles.begin()->second.size(), 2u);
}

TEST(LearnColors, BallsOfOneWordAreNumberedByTheirSize) {
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 80, 120, 30, {0.03, 0.30, 0.10});   // grass
  draw_shaded_ball(picture, 220, 120, 50, {0.22, 0.35, 0.02});  // bottle
  const LearntColors colors = learn_colors({{"greens.png", picture}});
  ASSERT_EQ(names(colors), (std::set<std::string>{"green", "green_2"}));
  EXPECT_NEAR(colors.circles.at("green")[0].radius_px, 50, 3);
}

TEST(LearnColors, NothingColoredIsARefusal) {
  cv::Mat picture = grey_picture();
  EXPECT_THROW(learn_colors({{"grey.png", picture}}), Refusal);
  add_noise(picture, 10, 5);
  EXPECT_THROW(learn_colors({{"noise.png", picture}}), Refusal);
  EXPECT_THROW(learn_colors({{"dot.png", cv::Mat(1, 1, CV_8UC3, cv::Scalar(0, 0, 255))}}), Refusal);
  EXPECT_THROW(learn_colors({{"red.png", cv::Mat(60, 60, CV_8UC3, cv::Scalar(0, 0, 200))}}), Refusal);
}

TEST(LearnColors, AColorThatIsMostlyElsewhereIsNoBall) {
  // A fingertip is round, but most of the skin is not.
  cv::Mat picture = grey_picture();
  const cv::Scalar skin(90, 120, 190);
  cv::rectangle(picture, cv::Rect(20, 150, 280, 80), skin, cv::FILLED);
  cv::circle(picture, {160, 60}, 18, skin, cv::FILLED);
  EXPECT_THROW(learn_colors({{"hand.png", picture}}), Refusal);
}

TEST(LearnColors, SamePicturesSameBytes) {
  const std::string once = color_file_bytes(learnt_from_four_balls().table);
  EXPECT_EQ(once, color_file_bytes(learn_colors({four_balls()}).table));
}

TEST(LearnColors, ColorsOfTheBackgroundAreLeftToIt) {
  // A ball that shades off into the wall's own tint: the wall must not become ball.
  cv::Mat picture(240, 320, CV_8UC3, cv::Scalar(110, 135, 150));
  draw_shaded_ball(picture, 160, 120, 45, yellow_paint, 0.05);
  add_noise(picture, 2, 9);
  const LearntColors colors =
      learn_classes({{"wall.png", picture}}, {{"ball", {0}, PointedBall{{160, 120}, 52}}});
  EXPECT_LT(report_classes(colors.table)[0].background_fraction, 0.01);
  EXPECT_GT(disc_fraction(colors.table, picture, 160, 120, 30, "ball"), 0.7);
}

TEST(LearnClasses, AColorWordSettlesWhich) {
  const std::vector<ColorPicture> pictures = {four_balls()};
  for (const std::string word : {"red", "yellow"}) {
    const LearntColors colors = learn_classes(pictures, {{word, {0}, {}}});
    EXPECT_EQ(names(colors), std::set<std::string>{word});
    EXPECT_EQ(colors.circles.at(word).size(), 1u);
  }
  const LearntColors both = learn_classes(pictures, {{"red", {0}, {}}, {"blue", {0}, {}}});
  EXPECT_NEAR(both.circles.at("red")[0].center_px.x(), 60, 2);
  EXPECT_NEAR(both.circles.at("blue")[0].center_px.x(), 80, 2);
}

TEST(LearnClasses, AnyOtherNameIsRefusedWithWhatWouldSettleIt) {
  try {
    learn_classes({four_balls()}, {{"target", {0}, {}}});
    FAIL();
  } catch (const Refusal& refusal) {
    const std::string text = refusal.what();
    for (const char* part :
         {"red", "green", "blue", "yellow", "--at target=60,60,3", "--at target=240,170,3"}) {
      EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
    }
  }
  // With one colour in sight any name will do.
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 160, 120, 40, blue_paint);
  EXPECT_EQ(names(learn_classes({{"one.png", picture}}, {{"target", {0}, {}}})),
            std::set<std::string>{"target"});
}

TEST(LearnClasses, AWordInANameIsMeant) {
  for (const std::string name : {"blue", "dark_blue", "navy_2"}) {
    const LearntColors learnt = learn_classes({four_balls()}, {{name, {0}, {}}});
    EXPECT_LT((learnt.circles.at(name).at(0).center_px - Eigen::Vector2d(80, 170)).norm(), 2) << name;
    EXPECT_TRUE(learnt.doubts.empty()) << name;
  }
}

TEST(LearnClasses, AnyNameTakesTheClearestBallWithAWarningWhereOthersAreSure) {
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 90, 120, 50, blue_paint);
  draw_shaded_ball(picture, 240, 120, 14, red_paint);
  const auto learnt = [&](const char* name) {
    return learn_classes({{"two.png", picture}}, {{name, {0}, {}}});
  };
  ASSERT_EQ(learnt("ball").doubts.size(), 1u);
  EXPECT_NE(learnt("ball").doubts[0].find("--at ball=240,120,14"), std::string::npos)
      << learnt("ball").doubts[0];
  EXPECT_TRUE(learnt("blue").doubts.empty());
  EXPECT_TRUE(learnt("red_one").doubts.empty());
}

TEST(LearnClasses, AWrongWordOrRadiusForABallPointedAtIsWarnedOf) {
  const auto doubts = [](const char* name, const PointedBall& at) {
    return learn_classes({four_balls()}, {{name, {0}, at}}).doubts;
  };
  EXPECT_TRUE(doubts("green", {{220, 60}, 34}).empty());
  EXPECT_TRUE(doubts("ball", {{220, 60}, 34}).empty());
  ASSERT_EQ(doubts("red", {{220, 60}, 34}).size(), 1u);
  EXPECT_NE(doubts("red", {{220, 60}, 34})[0].find("rather green"), std::string::npos);
  ASSERT_EQ(doubts("green", {{220, 60}, 60}).size(), 1u);
  EXPECT_NE(doubts("green", {{220, 60}, 60})[0].find("of its circle has its colour"), std::string::npos);
}

TEST(LearnClasses, AWordForNothingInSightIsRefused) {
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 160, 120, 40, blue_paint);
  EXPECT_THROW(learn_classes({{"blue.png", picture}}, {{"yellow", {0}, {}}}), Refusal);
  EXPECT_THROW(learn_classes({{"grey.png", grey_picture()}}, {{"yellow", {0}, {}}}), Refusal);
}

TEST(LearnClasses, ANeighbouringWordTakesTheBallThatStandsAloneWithAWarning) {
  // An orange ball, called red, beside a red square and a red disc cut in two: the ball is meant.
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 100, 90, 30, {0.03, 0.2, 0.8});
  cv::rectangle(picture, cv::Rect(190, 40, 50, 50), {40, 40, 190}, cv::FILLED);
  cv::ellipse(picture, {220, 180}, {30, 30}, 0, 0, 180, {40, 40, 190}, cv::FILLED);
  add_noise(picture, 2, 7);
  const LearntColors colors = learn_classes({{"orange.png", picture}}, {{"red", {0}, {}}});
  ASSERT_EQ(colors.circles.at("red").size(), 1u);
  EXPECT_LT((colors.circles.at("red")[0].center_px - Eigen::Vector2d(100, 90)).norm(), 1);
  ASSERT_EQ(colors.doubts.size(), 1u);
  EXPECT_NE(colors.doubts[0].find("rather orange"), std::string::npos) << colors.doubts[0];
}

TEST(LearnClasses, ANeighboursFarEndIsTakenWhereItsBallStandsAlone) {
  // A blue near purple, called cyan, beside a cyan square.
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 100, 90, 30, {0.5, 0.1, 0.03});
  cv::rectangle(picture, cv::Rect(190, 140, 50, 50), {170, 160, 60}, cv::FILLED);
  add_noise(picture, 2, 7);
  const LearntColors colors = learn_classes({{"blue.png", picture}}, {{"cyan", {0}, {}}});
  ASSERT_EQ(colors.circles.at("cyan").size(), 1u);
  EXPECT_LT((colors.circles.at("cyan")[0].center_px - Eigen::Vector2d(100, 90)).norm(), 1);
  EXPECT_FALSE(colors.doubts.empty());
}

TEST(LearnClasses, AWordDoesNotTakeASquareNorAGreyPatch) {
  cv::Mat picture = grey_picture();
  cv::rectangle(picture, cv::Rect(190, 40, 40, 40), {40, 40, 190}, cv::FILLED);
  cv::circle(picture, {100, 150}, 25, {128, 133, 146}, cv::FILLED, cv::LINE_AA);
  add_noise(picture, 2, 7);
  for (const std::string name : {"red", "orange", "ball"})
    EXPECT_THROW(learn_classes({{"none.png", picture}}, {{name, {0}, {}}}), Refusal) << name;
}

TEST(LearnColors, APictureThatTeachesNothingIsNamed) {
  ColorPicture without{"without.png", grey_picture()};
  cv::rectangle(without.bgr, cv::Rect(40, 40, 200, 60), {130, 60, 30}, cv::FILLED);
  add_noise(without.bgr, 2, 5);
  EXPECT_TRUE(learn_colors({four_balls()}).doubts.empty());
  const LearntColors colors = learn_colors({four_balls(), without});
  ASSERT_EQ(colors.doubts.size(), 1u);
  EXPECT_NE(colors.doubts[0].find("nothing was learnt from without.png:"), std::string::npos);
  EXPECT_EQ(learn_colors({{"grey.png", grey_picture()}, four_balls()}).table.classes.size(), 4u);
}

// The wall of one picture has the colour of the ball in another.
TEST(LearnColors, ABallOfAnotherPicturesWallIsLearnt) {
  ColorPicture red{"red.png", grey_picture()}, green{"green.png", grey_picture()};
  cv::rectangle(red.bgr, cv::Rect(0, 0, 320, 60), {46, 178, 66}, cv::FILLED);
  cv::rectangle(green.bgr, cv::Rect(0, 0, 320, 60), {52, 52, 210}, cv::FILLED);
  draw_shaded_ball(red.bgr, 160, 150, 30, red_paint);
  draw_shaded_ball(green.bgr, 160, 150, 22, green_paint);
  for (ColorPicture* picture : {&red, &green}) add_noise(picture->bgr, 2, 4);
  const LearntColors colors = learn_colors({red, green});
  EXPECT_EQ(names(colors), (std::set<std::string>{"red", "green"}));
  EXPECT_NEAR(colors.circles.at("green")[0].radius_px, 22, 1);
}

// Of a colour that covers a part of the picture some speck is round by chance; a ball as large as a fist is
// not.
TEST(LearnClasses, ARoundSpeckOfAColorThatIsElsewhereTeachesNothing) {
  for (const double radius_px : {5.0, 20.0}) {
    ColorPicture picture{"specks.png", grey_picture()};
    const double side_px = 4 * radius_px;
    cv::rectangle(picture.bgr, cv::Rect2d(20, 20, side_px, 2 * side_px), {130, 60, 30}, cv::FILLED);
    draw_shaded_ball(picture.bgr, 240, 120, radius_px, blue_paint);
    add_noise(picture.bgr, 2, 4);
    const auto learn = [&] { learn_classes({picture}, {{"blue", {0}, {}}}); };
    if (radius_px < 10)
      EXPECT_THROW(learn(), Refusal);
    else
      EXPECT_NO_THROW(learn());
  }
}

// Clearer balls of other colours, in one picture each.
TEST(LearnClasses, TheBallThatMostPicturesShowIsMeant) {
  std::vector<ColorPicture> pictures;
  for (const Eigen::Vector3d& other : {green_paint, blue_paint, yellow_paint}) {
    ColorPicture& picture = pictures.emplace_back(ColorPicture{"one.png", grey_picture()});
    draw_shaded_ball(picture.bgr, 90, 120, 22, red_paint);
    draw_shaded_ball(picture.bgr, 230, 120, 45, other);
    add_noise(picture.bgr, 2, pictures.size());
  }
  const LearntColors colors = learn_classes(pictures, {{"ball", {0, 1, 2}, {}}});
  ASSERT_EQ(colors.circles.at("ball").size(), 3u);
  for (const LearntCircle& circle : colors.circles.at("ball")) EXPECT_NEAR(circle.center_px.x(), 90, 2);
  EXPECT_THROW(learn_classes(pictures, {{"ball", {0}, {}}}), Refusal);
}

TEST(LearnClasses, ThePointedBallIsTheOneLearnt) {
  const ColorPicture picture = four_balls();
  const LearntColors colors = learn_classes({picture}, {{"target", {0}, PointedBall{{80, 170}, 26}}});
  EXPECT_GT(disc_fraction(colors.table, picture.bgr, 80, 170, 24, "target"), 0.95);
  EXPECT_LT(disc_fraction(colors.table, picture.bgr, 60, 60, 27, "target"), 0.01);
  EXPECT_EQ(colors.circles.at("target")[0].center_px, Eigen::Vector2d(80, 170));
}

// A flat disc of its colour, and a worse ball: the user would have pointed at them.
TEST(LearnClasses, BesideThePointedBallOnlyOneAsClearIsLearnt) {
  ColorPicture picture{"beside.png", grey_picture()};
  draw_shaded_ball(picture.bgr, 80, 80, 36, red_paint);
  cv::circle(picture.bgr, {230, 80}, 20, {40, 40, 190}, cv::FILLED, cv::LINE_AA);
  add_noise(picture.bgr, 2, 4);
  const std::vector<ClassRequest> pointed = {{"ball", {0}, PointedBall{{80, 80}, 36}}};
  EXPECT_EQ(learn_classes({picture}, pointed).circles.at("ball").size(), 1u);
  draw_shaded_ball(picture.bgr, 220, 170, 34, red_paint);
  EXPECT_EQ(learn_classes({picture}, pointed).circles.at("ball").size(), 2u);
}

TEST(LearnClasses, FaultsOfTheRequestAreAllNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const std::vector<ColorPicture> pictures = {four_balls()};
  const auto faults = [&](const std::vector<ClassRequest>& requests) -> std::size_t {
    try {
      return test::faults_of([&] { learn_classes(pictures, requests); }).size();
    } catch (const Refusal&) {
      return 100;
    }
  };
  const auto at = [&](double x, double y, double r) { return faults({{"a", {0}, PointedBall{{x, y}, r}}}); };
  EXPECT_EQ(at(60, 60, 30), 0u);
  EXPECT_EQ(at(-1, 60, 30), 1u);
  EXPECT_EQ(at(320, 60, 30), 1u);
  EXPECT_EQ(at(60, 240, 30), 1u);
  EXPECT_EQ(at(nan, 60, 30), 1u);
  EXPECT_EQ(at(60, inf, 30), 1u);
  EXPECT_EQ(at(60, 60, 0), 1u);
  EXPECT_EQ(at(60, 60, -5), 1u);
  EXPECT_EQ(at(60, 60, nan), 1u);
  EXPECT_EQ(at(60, 60, 1e9), 1u);
  EXPECT_EQ(at(nan, nan, nan), 2u);
  EXPECT_EQ(at(150, 120, 10), 100u);  // grey: a refusal, not a fault
  EXPECT_EQ(faults({{"Bad", {0}, {}}, {"b", {}, {}}, {"c", {0}, PointedBall{{-9, 0}, 5}}, {"b", {0}, {}}}),
            4u);
}

/// The folder of opencv-doc's examples, or a skipped test.
TEST(LearnColors, Smarties) {
  const auto folder = opencv_doc_dir();
  if (!folder) GTEST_SKIP() << "opencv-doc is not installed";
  const cv::Mat picture = cv::imread((*folder / "smarties.png").string());
  ASSERT_FALSE(picture.empty());
  const LearntColors colors = learn_colors({{"smarties.png", picture}});
  EXPECT_EQ(names(colors), (std::set<std::string>{"red", "orange", "green", "blue"}));
}

TEST(LearnClasses, TheWordThatIsOursComesBeforeItsNeighbour) {
  const auto folder = opencv_doc_dir();
  if (!folder) GTEST_SKIP() << "opencv-doc is not installed";
  const cv::Mat picture = cv::imread((*folder / "smarties.png").string());
  // Red reaches into orange, and has more sweets.
  for (const auto& [word, u, v] : {std::tuple("orange", 205.0, 211.0), std::tuple("red", 287.0, 213.0)}) {
    const LearntColors colors = learn_classes({{"smarties.png", picture}}, {{word, {0}, std::nullopt}});
    EXPECT_GT(disc_fraction(colors.table, picture, u, v, 20, word), 0.7) << word;
  }
}

TEST(LearnColors, YellowBallsBesideThingsOfTheirColor) {
  const auto folder = shared_data_dir();
  if (!folder) GTEST_SKIP() << "no pictures beside the project";
  const cv::Mat still_2 = cv::imread((*folder / "balls_powercell/powercell_test_2.png").string());
  const cv::Mat still_5 = cv::imread((*folder / "balls_powercell/powercell_test_5.png").string());
  ASSERT_FALSE(still_2.empty() || still_5.empty());
  const LearntColors colors = learn_colors({{"still_2.png", still_2}});
  ASSERT_EQ(names(colors), std::set<std::string>{"yellow"});
  EXPECT_GT(disc_fraction(colors.table, still_2, 279.7, 87.7, 30, "yellow"), 0.9);
  EXPECT_GT(disc_fraction(colors.table, still_2, 88.7, 211.2, 47, "yellow"), 0.9);
  EXPECT_GT(disc_fraction(colors.table, still_5, 414.6, 205.5, 36, "yellow"), 0.8);
}

}  // namespace
}  // namespace ballservo
