// Balls whose rim is too dark to have the class's colour, with things in the hand's place over it: their
// region is less than they are, but their outline is in the picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "calibration/base/fault.hpp"
#include "perception/tracking/tracker.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

const ImageSize size{320, 240};
const cv::Vec3b rim_grey(52, 54, 66), ball_red(34, 32, 88), wall(150, 150, 150), finger(60, 70, 84);

struct Scene {
  Eigen::Vector2d center_px{160, 120};
  double radius_px = 32;
  bool fingers = true;
  double least_core = 0.76, most_core = 0.88;  // of the radius: what of it has the colour
};

cv::Mat picture(const Scene& scene, std::uint64_t seed) {
  RandomEngine engine = random_stream(seed, "frayed_region_test");
  // The colour is strong in a patch of arcs, and fades around it.
  cv::Mat ball(size.height_px, size.width_px, CV_8UC3, cv::Scalar(rim_grey));
  for (int i = 0; i < 5; ++i) {
    const double turn_rad = uniform(engine, 0, 6.28), away = uniform(engine, 0.05, 0.2) * scene.radius_px;
    test::paint_disc(ball, scene.center_px + away * Eigen::Vector2d(std::cos(turn_rad), std::sin(turn_rad)),
                     uniform(engine, scene.least_core, scene.most_core) * scene.radius_px, ball_red);
  }
  cv::GaussianBlur(ball, ball, {}, 0.1 * scene.radius_px);
  cv::Mat bgr(size.height_px, size.width_px, CV_8UC3, cv::Scalar(wall)),
      cover = cv::Mat::zeros(bgr.size(), CV_8UC3);
  test::paint_disc(cover, scene.center_px, scene.radius_px, {255, 255, 255});
  for (int i = 0; i < 3 * size.width_px * size.height_px; ++i)
    bgr.data[i] =
        cv::saturate_cast<std::uint8_t>(bgr.data[i] + cover.data[i] * (ball.data[i] - bgr.data[i]) / 255);
  if (scene.fingers) {
    for (const double turn_rad : {0.1, 2.6}) {
      const Eigen::Vector2d tip =
          scene.center_px + scene.radius_px * Eigen::Vector2d(std::cos(turn_rad), std::sin(turn_rad));
      test::paint_disc(bgr, tip, 0.3 * scene.radius_px, finger);
    }
  }
  cv::GaussianBlur(bgr, bgr, {}, 0.9);
  for (int i = 0; i < 3 * size.width_px * size.height_px; ++i)
    bgr.data[i] = cv::saturate_cast<std::uint8_t>(bgr.data[i] + 2 * standard_normal(engine));
  return bgr;
}

bool is_at(const OutlineEllipse& outline, const Scene& scene) {
  return (outline.center_px - scene.center_px).norm() < 0.06 * scene.radius_px &&
         std::abs(outline.radius_px - scene.radius_px) < 0.06 * scene.radius_px;
}

// `px` around the picture's middle.
ExpectedBall expected_at(const Eigen::Vector2d& px, double radius_px, double reach_px) {
  const Eigen::Vector2d from_middle = px - Eigen::Vector2d(159.5, 119.5);
  return {1,
          {Eigen::Vector3d(from_middle.x(), from_middle.y(), 400).normalized(), std::atan(radius_px / 400)},
          reach_px};
}

TEST(FrayedRegion, ItsBallIsFoundByTheOutlineAroundIt) {
  Detector detector = test::detector_for(test::pinhole(size, 400));
  int found = 0, others = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Scene scene;
    for (const BallObservation& ball : detector.detect(picture(scene, seed)))
      ++(is_at(ball.outline, scene) ? found : others);
  }
  EXPECT_GE(found, 13);
  EXPECT_EQ(others, 0);
}

// As in dim light, or in pictures compressed much: no colour anywhere near the outline.
TEST(FrayedRegion, ABallWhoseColorEndsWellInsideIsFoundByTheOutlineThatEnclosesIt) {
  Detector detector = test::detector_for(test::pinhole(size, 400));
  int found = 0, others = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Scene scene;
    scene.least_core = 0.6;
    scene.most_core = 0.7;
    for (const BallObservation& ball : detector.detect(picture(scene, seed)))
      ++(is_at(ball.outline, scene) ? found : others);
  }
  EXPECT_GE(found, 16);
  EXPECT_LE(others, 2);  // the coloured core, where it is a disc itself
}

TEST(FrayedRegion, TheStagesShowTheEdgesOfTheOutlineThatWasFound) {
  Detector detector = test::detector_for(test::pinhole(size, 400));
  int shown = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Scene scene;
    DetectionStages stages;
    detector.detect(picture(scene, seed), {}, &stages);
    for (const auto& candidate : stages.candidates) {
      if (!candidate.accepted) continue;
      int on_outline = 0;
      for (const Eigen::Vector2d& p : candidate.ring_px)
        on_outline += std::abs((p - scene.center_px).norm() - scene.radius_px) < 1 ? 1 : 0;
      EXPECT_GT(on_outline, 0.8 * static_cast<double>(candidate.ring_px.size())) << seed;
      ++shown;
    }
  }
  EXPECT_GE(shown, 13);
}

// The comparison's methods start from it, so that it may not be what the edges say.
TEST(FrayedRegion, TheVoteOfItsBallIsWhatTheVotesSaidOfTheRegion) {
  Detector detector = test::detector_for(test::pinhole(size, 400));
  int found_around = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Scene scene;
    scene.least_core = 0.6;
    scene.most_core = 0.7;
    DetectionStages stages;
    for (const BallObservation& ball : detector.detect(picture(scene, seed), {}, &stages)) {
      ASSERT_TRUE(ball.vote) << seed;
      EXPECT_TRUE(std::any_of(stages.candidates.begin(), stages.candidates.end(),
                              [&](const DetectionStages::Candidate& c) {
                                return c.accepted && c.estimate.votes > 0 &&
                                       c.estimate.votes == ball.vote->votes &&
                                       c.estimate.center_px == ball.vote->center_px &&
                                       c.estimate.radius_px == ball.vote->radius_px;
                              }))
          << seed;
      found_around += ball.start.radius_px > ball.vote->radius_px;
    }
  }
  EXPECT_GE(found_around, 10);
}

TEST(FrayedRegion, AnExpectedBallIsFoundFromFarther) {
  Detector detector = test::detector_for(test::pinhole(size, 400));
  int near = 0, far = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Scene scene;
    const cv::Mat bgr = picture(scene, seed);
    const auto expected = [&](double reach_px) {
      const auto ball =
          detector.find_expected(bgr, {100, 60, 120, 120},
                                 expected_at(scene.center_px + Eigen::Vector2d(8, -5), 30, reach_px), false);
      return ball && is_at(ball->outline, scene);
    };
    near += expected(5);
    far += expected(13);
  }
  EXPECT_LE(near, 10);
  EXPECT_GE(far, 17);
}

// As where what carries it stopped: more than half a radius beside the prediction.
TEST(FrayedRegion, AnExpectedBallIsFoundBesideItsPlace) {
  Detector detector = test::detector_for(test::pinhole(size, 400));
  int at_its_place = 0, beside = 0;
  for (int k = 0; k < 20; ++k) {
    const Scene scene;
    const cv::Mat bgr = picture(scene, static_cast<std::uint64_t>(k));
    const Eigen::Vector2d off_px = 18 * Eigen::Vector2d(std::cos(0.31 * k), std::sin(0.31 * k));
    ExpectedBall expected = expected_at(scene.center_px + off_px, 32, 5);
    const auto is_found = [&] {
      const auto ball = detector.find_expected(bgr, {70, 30, 180, 180}, expected, false);
      return ball && is_at(ball->outline, scene);
    };
    at_its_place += is_found();
    expected.spread_px = 18;
    beside += is_found();
    EXPECT_FALSE(detector.find_expected(bgr, {70, 30, 180, 180}, expected, false,
                                        [](const BallObservation&) { return false; }));
  }
  EXPECT_LE(at_its_place, 2);
  EXPECT_GE(beside, 17);
}

// Finger tips all around hide two thirds of its rim.
TEST(FrayedRegion, AnExpectedBallIsFoundByAThirdOfItsOutline) {
  Detector detector = test::detector_for(test::pinhole(size, 400));
  constexpr int tips = 9;
  int found = 0;
  for (int index = 0; index < 24; ++index) {
    const Scene scene;
    const double tip_px = (0.23 + 0.01 * (index % 4)) * scene.radius_px;
    cv::Mat bgr(size.height_px, size.width_px, CV_8UC3, cv::Scalar(wall));
    test::paint_disc(bgr, scene.center_px, scene.radius_px, test::red);
    for (int tip = 0; tip < tips; ++tip) {
      const double angle = 0.025 * index + 6.2832 / tips * tip;
      const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
      test::paint_disc(bgr, scene.center_px + scene.radius_px * direction, tip_px, finger);
    }
    cv::GaussianBlur(bgr, bgr, {}, 0.9);
    const ExpectedBall expected = expected_at(scene.center_px + Eigen::Vector2d(1.5, -1), 32, 5);
    const auto ball = detector.find_expected(bgr, {100, 60, 120, 120}, expected, false);
    found += ball && is_at(ball->outline, scene);
  }
  EXPECT_GE(found, 12);
}

TEST(FrayedRegion, NothingIsExpectedIntoAnEmptyPlace) {
  Detector detector = test::detector_for(test::pinhole(size, 400));
  const cv::Rect window(80, 40, 160, 160);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    cv::Mat bgr = picture({{400, 120}, 32}, seed);
    ExpectedBall expected = expected_at({160, 120}, 32, 5);
    expected.spread_px = 20;
    EXPECT_FALSE(detector.find_expected(bgr, window, expected, false)) << "wall " << seed;
    cv::rectangle(bgr, cv::Rect(130, 85, 60, 70), cv::Scalar(test::red), cv::FILLED);
    cv::GaussianBlur(bgr, bgr, {}, 0.9);
    EXPECT_FALSE(detector.find_expected(bgr, window, expected, false)) << "box " << seed;
    test::paint_disc(bgr, {160, 120}, 50, rim_grey);
    test::paint_disc(bgr, {160, 120}, 32, finger);
    EXPECT_FALSE(detector.find_expected(bgr, window, expected, false)) << "a disc of another colour " << seed;
  }
  const cv::Mat bgr = picture({}, 1);
  EXPECT_FALSE(detector.find_expected(bgr, {-50, -50, 10, 10}, expected_at({160, 120}, 32, 5), false));
  EXPECT_FALSE(detector.find_expected(bgr, window, expected_at({1e7, 120}, 32, 5), false));
  ExpectedBall of_no_class = expected_at({160, 120}, 32, 5);
  for (const ClassIndex color_class : {no_class, ClassIndex{9}}) {
    of_no_class.color_class = color_class;
    EXPECT_FALSE(detector.find_expected(bgr, window, of_no_class, false));
  }
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(detector.find_expected(bgr, window, expected_at({160, 120}, 32, infinite), false));
  EXPECT_FALSE(detector.find_expected(bgr, window, expected_at({160, 120}, infinite, 5), false));
  for (const double spread_px : {-1.0, infinite, std::numeric_limits<double>::quiet_NaN()}) {
    ExpectedBall expected = expected_at({160, 120}, 32, 5);
    expected.spread_px = spread_px;
    const auto ball = detector.find_expected(bgr, window, expected, false);
    EXPECT_TRUE(!ball || is_at(ball->outline, {})) << spread_px;
  }
}

// Whether by votes or from where it was expected: the same edges, the same ball.
TEST(FrayedRegion, AnExpectedBallIsTheVotedOne) {
  Detector detector = test::detector_for(test::pinhole(size, 400));
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    cv::Mat bgr = test::grey_picture(size.width_px, size.height_px);
    RandomEngine engine = random_stream(seed, "expected");
    const Eigen::Vector2d center_px(uniform(engine, 60, 260), uniform(engine, 60, 180));
    test::paint_shaded_disc(bgr, center_px, 24, test::red);
    cv::GaussianBlur(bgr, bgr, {}, 0.8);
    const auto voted = detector.detect(bgr);
    ASSERT_EQ(voted.size(), 1u);
    const OutlineEllipse by_votes = voted[0].outline;
    const auto ball = detector.find_expected(bgr, {{0, 0}, bgr.size()},
                                             expected_at(center_px + Eigen::Vector2d(2, -1.5), 25, 5), true);
    ASSERT_TRUE(ball);
    EXPECT_LT((ball->outline.center_px - by_votes.center_px).norm(), 0.02);
    EXPECT_NEAR(ball->outline.radius_px, by_votes.radius_px, 0.02);
  }
}

TEST(FrayedRegion, ATrackFollowsItsBallThere) {
  Tracker tracker(test::detector_for(test::pinhole(size, 400)));
  int followed = 0;
  for (int k = 0; k < 30; ++k) {
    Scene scene;
    scene.center_px = {60 + 6.0 * k + 10 * std::sin(0.9 * k), 120 + 20 * std::sin(0.35 * k)};
    for (const Track& track :
         tracker.update(picture(scene, 100u + static_cast<std::uint64_t>(k)), k / 30.0)) {
      if (track.state == TrackState::coasting) continue;
      EXPECT_TRUE(is_at(track.ball.outline, scene)) << k;
      ++followed;
    }
  }
  EXPECT_GE(followed, 22);
}

}  // namespace
}  // namespace ballservo
