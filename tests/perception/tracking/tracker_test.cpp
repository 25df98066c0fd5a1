#include "perception/tracking/tracker.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "calibration/base/fault.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

const ImageSize size{320, 240};
constexpr double dt_s = 1.0 / 30;

Tracker make_tracker() { return Tracker(test::detector_for(test::pinhole(size, 400), 0.05)); }

cv::Mat picture_with(const std::vector<Eigen::Vector2d>& centers, double radius_px = 16) {
  cv::Mat bgr = test::grey_picture();
  for (const Eigen::Vector2d& center : centers) test::paint_shaded_disc(bgr, center, radius_px, test::red);
  return bgr;
}

TEST(Tracker, ConfirmsAfterThreePicturesAndKeepsTheIdentity) {
  Tracker tracker = make_tracker();
  int id = 0;
  for (int k = 0; k < 12; ++k) {
    const auto& tracks = tracker.update(picture_with({{60.0 + 5 * k, 100}}), k * dt_s);
    ASSERT_EQ(tracks.size(), 1u);
    if (k == 0) id = tracks[0].id;
    EXPECT_EQ(tracks[0].id, id);
    EXPECT_EQ(tracks[0].state, k < 2 ? TrackState::tentative : TrackState::confirmed);
    EXPECT_NEAR(tracks[0].ball.outline.center_px.x(), 60 + 5 * k, 0.05);
  }
}

TEST(Tracker, ALensThatIsNotQuiteTheStatedOneMakesNoBallDoubtful) {
  cv::Mat wide = test::grey_picture(339), bgr;
  test::paint_shaded_disc(wide, {160, 110}, 30, test::red);
  cv::resize(wide, bgr, {320, 240}, 0, 0, cv::INTER_AREA);
  Tracker tracker = make_tracker();
  for (int k = 0; k < 12; ++k) {
    const auto& tracks = tracker.update(bgr, k * dt_s);
    ASSERT_EQ(tracks.size(), 1u);
    EXPECT_GT(tracks[0].ball.quality, 0.9) << k;
  }
}

TEST(Tracker, CoastsThroughAShortOcclusionAndKnowsTheBallAgain) {
  Tracker tracker = make_tracker();
  double last_trace = 0;
  for (int k = 0; k < 30; ++k) {
    const Eigen::Vector2d at(60.0 + 5 * k, 100);
    const bool hidden = k >= 10 && k < 18;
    const auto& tracks = tracker.update(hidden ? test::grey_picture() : picture_with({at}), k * dt_s);
    ASSERT_EQ(tracks.size(), 1u) << k;
    EXPECT_EQ(tracks[0].id, 1);
    if (hidden) {
      EXPECT_EQ(tracks[0].state, TrackState::coasting);
      EXPECT_LT((tracks[0].ball.outline.center_px - at).norm(), 6);
      // The longer unseen, the less is known.
      EXPECT_GT(tracks[0].ball.position->covariance_m2.trace(), last_trace);
      last_trace = tracks[0].ball.position->covariance_m2.trace();
    } else if (k > 2) {
      EXPECT_EQ(tracks[0].state, TrackState::confirmed);
    }
  }
}

TEST(Tracker, ADetectionCountsOnce) {
  // Seen and predicted an instant later, a ball is known as well as its own fit says, not better.
  Tracker tracker = make_tracker();
  // So long ago that it says nothing of the place.
  for (const double time_s : {0.0, 2.0}) tracker.update(picture_with({{160, 120}}), time_s);
  const auto seen = tracker.update(picture_with({{160, 120}}), 4).at(0);
  const auto predicted = tracker.update(test::grey_picture(), 4 + 1e-6).at(0);
  ASSERT_EQ(predicted.state, TrackState::coasting);
  const BallFeatures measured = features_of(seen.ball);
  const Eigen::Vector3d fitted =
      position_of(measured.value, measured.sigma.cwiseAbs2(), {0.05, 0}).covariance_m2.diagonal();
  const Eigen::Vector3d known = predicted.ball.position->covariance_m2.diagonal();
  EXPECT_NEAR(known.x() / fitted.x(), 1, 0.1);
  EXPECT_NEAR(known.y() / fitted.y(), 1, 0.1);
  EXPECT_NEAR(known.z() / fitted.z(), 1, 0.1);
}

TEST(Tracker, GivesUpABallThatStaysAway) {
  Tracker tracker = make_tracker();
  for (int k = 0; k < 5; ++k) tracker.update(picture_with({{160, 120}}), k * dt_s);
  for (int k = 5; k < 60; ++k) tracker.update(test::grey_picture(), k * dt_s);
  EXPECT_TRUE(tracker.update(test::grey_picture(), 60 * dt_s).empty());
}

// What was seen for an instant is no reason to expect it for a second.
TEST(Tracker, PredictsABallOnlyThriceAsLongAsItWasFollowed) {
  for (const int pictures : {4, 10}) {
    Tracker tracker = make_tracker();
    for (int k = 0; k < pictures; ++k) tracker.update(picture_with({{160, 120}}), k * dt_s);
    int predicted = 0;
    for (int k = pictures; k < 60; ++k)
      predicted += static_cast<int>(tracker.update(test::grey_picture(), k * dt_s).size());
    EXPECT_NEAR(predicted, 3 * (pictures - 1), 1);
  }
}

// A knock that outruns the filter, after which the ball is too unclear to be known at once.
TEST(Tracker, ABallThatIsBelievedAnewNearAMissingOneIsThatOne) {
  Tracker tracker = make_tracker();
  int newcomers = 0;
  for (int k = 0; k < 30; ++k) {
    const bool knocked = k >= 20;
    cv::Mat bgr = test::grey_picture();
    test::paint_shaded_disc(bgr, {knocked ? 148.0 : 60.0, 100}, 16, test::red);
    if (knocked) {
      test::paint_disc(bgr, {148, 100}, 11, {200, 200, 200});
      bgr(cv::Rect(156, 60, 40, 80)).setTo(cv::Scalar(60, 90, 70));
    }
    const auto& tracks = tracker.update(bgr, k * dt_s);
    ASSERT_FALSE(tracks.empty());
    EXPECT_EQ(tracks[0].id, 1);
    if (tracks.size() == 1) continue;
    ++newcomers;
    EXPECT_EQ(tracks[0].state, TrackState::coasting);
    EXPECT_EQ(tracks[1].state, TrackState::tentative);
  }
  EXPECT_GE(newcomers, 2);
  const auto& tracks = tracker.update(test::grey_picture(), 1);
  ASSERT_EQ(tracks.size(), 1u);
  EXPECT_NEAR(tracks[0].ball.outline.center_px.x(), 148, 0.5);
}

TEST(Tracker, NotOneThatWasThereBeforeTheOtherWentMissingNorOneFarAway) {
  for (const double x_px : {124.0, 250.0}) {
    const int appears = x_px < 200 ? 20 : 21;  // believed two pictures later
    Tracker tracker = make_tracker();
    for (int k = 0; k < 26; ++k) {
      std::vector<Eigen::Vector2d> centers;
      if (k < 21) centers.push_back({60, 100});
      if (k >= appears) centers.push_back({x_px, 100});
      tracker.update(picture_with(centers), k * dt_s);
    }
    const auto& tracks = tracker.update(picture_with({{x_px, 100}}), 26 * dt_s);
    ASSERT_EQ(tracks.size(), 2u) << x_px;
    EXPECT_EQ(tracks[0].state, TrackState::coasting);
    EXPECT_EQ(tracks[1].state, TrackState::confirmed);
  }
}

TEST(Tracker, IsNotTakenInByANearbyBallOfTheSameColour) {
  Tracker tracker = make_tracker();
  int passing = 0;
  for (int k = 0; k < 40; ++k) {
    // One rests at x = 200; the other passes above it and is hidden for a while.
    std::vector<Eigen::Vector2d> centers{{200, 140}};
    const bool hidden = k >= 22 && k < 27;
    if (!hidden) centers.push_back({40.0 + 6 * k, 100});
    const auto& tracks = tracker.update(picture_with(centers, 12), k * dt_s);
    if (k == 0) passing = tracks[0].ball.outline.center_px.x() < 100 ? tracks[0].id : tracks[1].id;
  }
  const auto& tracks = tracker.update(picture_with({{200, 140}, {280, 100}}, 12), 40 * dt_s);
  ASSERT_EQ(tracks.size(), 2u);
  for (const Track& track : tracks) EXPECT_EQ(track.id == passing, track.ball.outline.center_px.x() > 240);
}

TEST(Tracker, IgnoresRepeatedAndBackwardTimes) {
  Tracker tracker = make_tracker();
  tracker.update(picture_with({{100, 100}}), 0);
  tracker.update(picture_with({{103, 100}}), dt_s);
  const double x = tracker.update(picture_with({{200, 100}}), dt_s).at(0).ball.outline.center_px.x();
  EXPECT_NEAR(x, 103, 0.1);
  EXPECT_NEAR(tracker.update(picture_with({{200, 100}}), 0.5 * dt_s).at(0).ball.outline.center_px.x(), 103,
              0.1);
  EXPECT_NEAR(tracker.update(picture_with({{200, 100}}), std::nan("")).at(0).ball.outline.center_px.x(), 103,
              0.1);
}

}  // namespace
}  // namespace ballservo
