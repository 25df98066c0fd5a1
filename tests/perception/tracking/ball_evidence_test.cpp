// A ball is believed by evidence, against what else the scene shows of its size.
#include "perception/tracking/ball_evidence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "perception/tracking/tracker.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

BallEvidence seen(double radius_px, double log_odds, int pictures) {
  BallEvidence evidence;
  for (int k = 0; k < pictures; ++k) evidence.see(radius_px, log_odds);
  return evidence;
}

TEST(BallEvidence, AClearBallIsBelievedAtTheThirdPicture) {
  for (const double radius_px : {8.0, 30.0, 100.0}) {
    EXPECT_FALSE(seen(radius_px, 17, 2).suffices(0)) << radius_px;
    EXPECT_TRUE(seen(radius_px, 17, 3).suffices(0)) << radius_px;
  }
}

TEST(BallEvidence, OfWhatIsSmallAndUnclearMorePicturesAreAsked) {
  EXPECT_FALSE(seen(4, 7, 20).suffices(0));
  EXPECT_TRUE(seen(6.5, 14, 3).suffices(0)) << "a ball far away";
  EXPECT_TRUE(seen(25, 7, 4).suffices(0));
}

TEST(BallEvidence, ASecondLookSpeaksAgainstWhatIsLargeToo) {
  EXPECT_FALSE(seen(35, -4, 100).suffices(0));
  EXPECT_TRUE(seen(35, 3, 20).suffices(0)) << "a ball in a bad picture";
}

TEST(BallEvidence, ASecondLookSpeaksForABallAndNoMoreThanSoMuch) {
  EXPECT_FALSE(seen(22, 5, 6).suffices(0.1));
  EXPECT_TRUE(seen(22, 10, 6).suffices(0.1));
  EXPECT_FALSE(seen(22, 100, 6).suffices(6));
}

TEST(BallEvidence, WhatSecondLooksSpeakClearlyAgainstIsUnlikelyUntilTheyDoNot) {
  BallEvidence evidence = seen(22, -9, 1);
  EXPECT_TRUE(evidence.is_unlikely());
  for (int k = 0; k < 3; ++k) evidence.see(22, 17);
  EXPECT_FALSE(evidence.is_unlikely());
  EXPECT_FALSE(seen(22, 3, 1).is_unlikely());
}

TEST(BallEvidence, WhatIsUnlikelyIsNotBelievedForBeingLargeNorForStaying) {
  EXPECT_TRUE(seen(60, 5, 50).suffices(0));
  EXPECT_FALSE(seen(60, -6, 1000).suffices(0));
}

TEST(BallEvidence, ATrackThatGoesOverToAnotherThingIsThatThing) {
  BallEvidence evidence = seen(22, 17, 500);
  for (int k = 0; k < 40; ++k) evidence.see(22, -10);
  EXPECT_TRUE(evidence.is_unlikely());
}

TEST(BallEvidence, WhatItsMotionSmearsSpeaksNotAgainstABall) {
  BallEvidence flying, still;
  for (int k = 0; k < 4; ++k) {
    flying.see(22, -3, k > 0);
    still.see(22, -3);
  }
  EXPECT_TRUE(flying.suffices(0));
  EXPECT_FALSE(still.suffices(0));
}

// A ball that turns into a flat slice of a disc; and one that is hidden so far by sheets above and below it.
TEST(BallEvidence, ATrackEndsWhenItsLooksSpeakAgainstABall) {
  const ImageSize size{320, 240};
  const Eigen::Vector2d center_px(160, 120);
  for (const bool is_ball : {true, false}) {
    Tracker tracker(
        Detector(std::make_shared<const RayTable>(long_lens_camera(size)), test::red_and_green(), {}), {});
    for (int k = 0; k < 40; ++k) {
      cv::Mat bgr = test::grey_picture();
      if (is_ball || k < 4)
        test::paint_shaded_disc(bgr, center_px, 20, test::red);
      else
        test::paint_disc(bgr, center_px, 20, test::red);
      if (k >= 4) {
        cv::Mat(bgr, {0, 130, 320, 110}).setTo(is_ball ? cv::Scalar(90, 100, 60) : cv::Scalar(test::grey));
        cv::Mat(bgr, {0, 0, 320, 106}).setTo(is_ball ? cv::Scalar(60, 100, 90) : cv::Scalar(test::grey));
      }
      cv::GaussianBlur(bgr, bgr, {}, 0.7);
      const std::vector<Track>& tracks = tracker.update(bgr, k / 30.0);
      if (k == 3) {
        ASSERT_EQ(tracks.at(0).state, TrackState::confirmed);
      }
      if (k == 39) {
        EXPECT_EQ(tracks.size(), is_ball ? 1u : 0u);
      }
    }
  }
}

TEST(BallEvidence, AmongLookAlikesHowLongItStaysSaysNothing) {
  EXPECT_TRUE(seen(5, 14, 5).suffices(0));
  EXPECT_FALSE(seen(5, 14, 1000).suffices(4));
  EXPECT_TRUE(seen(40, 17, 3).suffices(0.5));
}

TEST(BallEvidence, WhatIsMissedIsSoonRefuted) {
  BallEvidence evidence = seen(20, 12, 1);
  evidence.miss();
  EXPECT_FALSE(evidence.is_refuted()) << "a ball is missed now and then";
  evidence.miss();
  EXPECT_TRUE(evidence.is_refuted());
  evidence = seen(9, 10, 3);
  EXPECT_TRUE(evidence.suffices(0));
  evidence.miss();
  EXPECT_FALSE(evidence.suffices(0));
}

TEST(LookAlikes, AThingIsNotItsOwnAndOthersAreOfItsSizeAndClass) {
  LookAlikes look_alikes(2);
  const int pictures = 10;
  for (int k = 1; k <= pictures; ++k) {
    look_alikes.begin();
    for (int thing = 0; thing < 3; ++thing) look_alikes.add(1, seen(5, 0, k));
  }
  const BallEvidence one_of_them = seen(5, 0, pictures + 1);
  const double doubt = one_of_them.doubt();
  EXPECT_NEAR(look_alikes.near(1, one_of_them), 2 * doubt, 0.01);
  EXPECT_NEAR(look_alikes.near(1, seen(5, 0, 1)), 3 * doubt, 0.01);
  EXPECT_EQ(look_alikes.near(1, seen(40, 0, 1)), 0);
  EXPECT_EQ(look_alikes.near(2, seen(5, 0, 1)), 0);
  EXPECT_EQ(look_alikes.near(no_class, seen(5, 0, 1)), 0);
}

// A speck of the ball's colour that stays where it is, as a leaf does, and a ball.
TEST(BallEvidence, OfASpeckAndABallTheTrackerBelievesTheBall) {
  Tracker tracker(test::detector_for(test::pinhole({320, 240}, 400)));
  int tentative = 0;
  for (int k = 0; k < 12; ++k) {
    cv::Mat bgr = test::grey_picture();
    test::paint_disc(bgr, {160.0 + 2 * k, 120}, 20, test::red);
    test::paint_disc(bgr, {120, 200}, 5, 0.42 * test::red + 0.3 * test::grey);
    cv::GaussianBlur(bgr, bgr, {}, 0.7);
    for (const Track& track : tracker.update(bgr, k / 30.0)) {
      const bool is_ball = track.ball.outline.radius_px > 12;
      EXPECT_TRUE(is_ball || track.state == TrackState::tentative) << k;
      EXPECT_TRUE(!is_ball || k < 6 || track.state == TrackState::confirmed) << k << ", it is flat";
      tentative += is_ball ? 0 : 1;
    }
  }
  EXPECT_EQ(tentative, 12) << "the speck looks like a ball";
}

// Two discs that are alike, one of which turns out to be a ball: it is looked at again now and then.
TEST(BallEvidence, WhatIsClearAndNotBelievedMayBecomeABall) {
  Tracker tracker(test::detector_for(test::pinhole({320, 240}, 400)));
  const auto is_confirmed = [](const Track& track) { return track.state == TrackState::confirmed; };
  for (int k = 0; k < 45; ++k) {
    cv::Mat bgr = test::grey_picture();
    test::paint_disc(bgr, {90, 120}, 20, test::red);
    const auto paint = k < 15 ? test::paint_disc : test::paint_shaded_disc;
    paint(bgr, {230, 120}, 20, test::red);
    cv::GaussianBlur(bgr, bgr, {}, 0.7);
    const std::vector<Track>& tracks = tracker.update(bgr, k / 30.0);
    const auto first = std::find_if(tracks.begin(), tracks.end(), is_confirmed);
    if (first == tracks.end()) continue;
    EXPECT_GE(k, 15);
    EXPECT_NEAR(first->ball.outline.center_px.x(), 230, 0.5);
    return;
  }
  FAIL() << "none is believed";
}

// A speck that would be a ball in a dimmer light than the taught one, beside a ball that is flat.
TEST(Tracker, ASpeckSpeaksForNoOtherLight) {
  Tracker tracker(test::detector_for(test::pinhole({320, 240}, 400)));
  cv::Mat bgr = test::grey_picture();
  test::paint_disc(bgr, {160, 120}, 20, test::red);
  test::paint(bgr, 0.7 * test::red, [&](const Eigen::Vector2d& p) {
    const double along = p.x() - 120, across = p.y() - 200 - 0.2 * along;
    return std::hypot(along, across) < 4.8;
  });
  cv::GaussianBlur(bgr, bgr, {}, 0.7);
  const auto& tracks = tracker.update(bgr, 0);
  ASSERT_EQ(tracks.size(), 1u);
  EXPECT_NEAR(tracks[0].ball.outline.radius_px, 20, 0.1);
}

}  // namespace
}  // namespace ballservo
