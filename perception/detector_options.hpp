// What a detector may be told.
#pragma once

#include <cstdint>
#include <vector>

#include "calibration/circles/circle_vote.hpp"
#include "perception/outline/ball_observation.hpp"
#include "perception/outline/edge_points.hpp"
#include "perception/outline/paper_refinement.hpp"

namespace ballservo {

/// How the camera's grey levels follow the light: stated, or told by how the balls' edges look.
enum class ResponseChoice { by_edges, linear, srgb };

struct DetectorOptions {
  BallFit fit = BallFit::sphere;
  ResponseChoice response = ResponseChoice::by_edges;
  /// The radius of each class's balls; class k is entry k - 1. Empty or 0: not known, no position in 3-D.
  std::vector<BallRadius> radii;
  double min_radius_px = 3;
  int max_regions = 256;   ///< that are looked at for balls; the largest
  int max_runs = 1 << 16;  ///< that a picture is cut into (see Runs::cut)
  /// Of a ball's rim so much may have its colour; but of a small one's only so much: some circle fits into a
  /// few pixels of anything.
  double max_leak = 0.55, max_small_leak = 0.1;
  /// Of the shading of a ball more than half hidden so much must be a sphere's.
  double min_shading_explained = 0.95;
  double min_quality = 0.36;
  /// On so much of an outline an edge must lie for it to be the ball's: around a region that may be less than
  /// its ball; where the class ends well inside it all around; where a ball is expected.
  double min_frayed_edge = 0.37, min_enclosing_edge = 0.5, min_expected_edge = 0.30;
  /// Where no camera was given: how far outlines may depart from circles (see one_gauss_newton_step).
  double oval_fraction = 0;
  std::uint64_t seed = 0;
  static constexpr int most_threads = 64;
  int threads = 1;  ///< that share the rows of a picture (classification); the same result with any number
  CircleVoteOptions vote;
  EdgeRingOptions edges;
  RingOptions ring;

  /// Throws InputError naming every value that makes no sense.
  void validate() const;
};

}  // namespace ballservo
