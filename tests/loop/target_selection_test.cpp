// Which of the tracks is the ball.
#include "app/loop/target_selection.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace ballservo {
namespace {

constexpr ClassIndex red = 1, blue = 2;

/// A track of a red ball that lies at (x, 0, z) of the robot frame.
Track track(int id, TrackState state, double quality = 0.8, double x_m = 2.0, double z_m = 0.06) {
  Track track;
  track.id = id;
  track.color_class = red;
  track.state = state;
  track.ball.quality = quality;
  track.ball.position = BallPosition{};
  track.ball.position->p_C = TargetOptions{}.mount.X_RC().inverse() * Eigen::Vector3d(x_m, 0, z_m);
  return track;
}

constexpr TrackState tentative = TrackState::tentative, confirmed = TrackState::confirmed,
                     coasting = TrackState::coasting;

int chosen(TargetSelection& selection, const std::vector<Track>& tracks) {
  const Track* target = selection.choose(tracks);
  return target == nullptr ? 0 : target->id;
}

struct TargetSelectionTest : testing::Test {
  TargetSelection selection{TargetOptions{}};
};

TEST_F(TargetSelectionTest, NothingIsChosenOfNothing) { EXPECT_EQ(chosen(selection, {}), 0); }

TEST_F(TargetSelectionTest, OnlyTheTargetsClassCounts) {
  Track other = track(1, confirmed, 0.9);
  other.color_class = blue;
  EXPECT_EQ(chosen(selection, {other}), 0);
  EXPECT_EQ(chosen(selection, {other, track(2, tentative, 0.3)}), 2);
}

TEST_F(TargetSelectionTest, ConfirmedComesBeforeTentativeThenTheBetterThenTheOlder) {
  EXPECT_EQ(chosen(selection, {track(1, tentative, 0.9), track(2, confirmed, 0.3)}), 2);
  TargetSelection anew{TargetOptions{}};
  EXPECT_EQ(chosen(anew, {track(1, tentative, 0.4), track(2, tentative, 0.6), track(3, tentative, 0.6)}), 2);
}

TEST_F(TargetSelectionTest, SticksToTheConfirmedOneForAsLongAsItLives) {
  EXPECT_EQ(chosen(selection, {track(4, confirmed, 0.5)}), 4);
  EXPECT_EQ(chosen(selection, {track(2, confirmed, 0.9), track(4, confirmed, 0.5)}), 4);
  EXPECT_EQ(chosen(selection, {track(2, confirmed, 0.9), track(4, coasting, 0.0)}), 4)
      << "unseen for a while";
}

TEST_F(TargetSelectionTest, ATentativeOneIsNotStuckTo) {
  EXPECT_EQ(chosen(selection, {track(1, tentative, 0.5)}), 1);
  EXPECT_EQ(chosen(selection, {track(1, tentative, 0.5), track(2, tentative, 0.7)}), 2);
}

TEST_F(TargetSelectionTest, HandsOverWhenTheFollowedTrackEnds) {
  EXPECT_EQ(chosen(selection, {track(1, confirmed, 0.9), track(2, confirmed, 0.5)}), 1);
  EXPECT_EQ(chosen(selection, {track(2, confirmed, 0.5), track(3, confirmed, 0.4)}), 2);
  EXPECT_EQ(chosen(selection, {}), 0);
  EXPECT_EQ(chosen(selection, {track(1, confirmed, 0.4), track(2, confirmed, 0.8)}), 2)
      << "nobody is followed";
}

TEST_F(TargetSelectionTest, WhatLiesAtAnotherHeightIsNoBall) {
  EXPECT_EQ(chosen(selection, {track(1, confirmed, 0.9, 2.0, 0.75)}), 0);
  EXPECT_EQ(chosen(selection, {track(1, confirmed, 0.9, 2.0, -0.4)}), 0);
  TargetOptions lifted;
  lifted.lift_m = 0.7;
  TargetSelection looks_up(lifted);
  EXPECT_EQ(chosen(looks_up, {track(1, confirmed, 0.9, 2.0, 0.75)}), 1);
}

TEST_F(TargetSelectionTest, TheWindowOfHeightGrowsWithTheRange) {
  EXPECT_EQ(chosen(selection, {track(1, confirmed, 0.9, 1.0, 0.35)}), 0);
  EXPECT_EQ(chosen(selection, {track(1, confirmed, 0.9, 5.0, 0.35)}), 1);
}

TEST_F(TargetSelectionTest, OfAnUnknownScaleTheDirectionCounts) {
  TargetOptions options;
  options.greatest_scale = 5;
  TargetSelection taught{options};
  const Eigen::Vector3d camera = options.mount.X_RC().translation(), ball(2.0, 0, 0.06), sign(6.0, 0, 1.3);
  const auto seen = [&](const Eigen::Vector3d& p_RB, double scale) {
    const Eigen::Vector3d p = camera + scale * (p_RB - camera);
    return std::vector<Track>{track(1, confirmed, 0.8, p.x(), p.z())};
  };
  EXPECT_EQ(chosen(selection, seen(ball, 4)), 0);
  for (const double scale : {0.25, 1.0, 4.0}) {
    EXPECT_EQ(chosen(taught, seen(ball, scale)), 1) << scale;
    EXPECT_EQ(chosen(taught, seen(sign, scale)), 0) << scale;
  }
}

TEST_F(TargetSelectionTest, ATrackWithoutAPlaceOrWithAnImpossibleOneIsPassedOver) {
  Track nowhere = track(1, confirmed);
  nowhere.ball.position.reset();
  Track odd_quality = track(2, confirmed, std::nan(""));
  std::vector<Track> tracks{nowhere, odd_quality};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double odd : {std::nan(""), std::numeric_limits<double>::infinity()}) {
      tracks.push_back(track(3 + axis, confirmed));
      tracks.back().ball.position->p_C[axis] = odd;
    }
  }
  EXPECT_EQ(chosen(selection, tracks), 0);
  tracks.push_back(track(9, tentative, 0.1));
  EXPECT_EQ(chosen(selection, tracks), 9);
}

}  // namespace
}  // namespace ballservo
