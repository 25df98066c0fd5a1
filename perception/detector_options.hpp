// What a detector may be told.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/ball_observation.hpp"
#include "perception/circle_vote.hpp"
#include "perception/edge_points.hpp"
#include "perception/paper_refinement.hpp"

namespace ballservo {

/// How the camera's grey levels follow the light: stated, or told by how the balls' edges look.
enum class ResponseChoice { by_edges, linear, srgb };

struct DetectorOptions {
  BallFit fit = BallFit::sphere;
  ResponseChoice response = ResponseChoice::by_edges;
  /// The radius of each class's balls; class k is entry k - 1. Empty or 0: not known, no position in 3-D.
  std::vector<BallRadius> radii;
  double min_radius_px = 3;
  int max_balls_per_region = 8;
  int max_regions = 256;   ///< that are looked at for balls; the largest
  int max_runs = 1 << 16;  ///< that a picture is cut into (see Runs::cut)
  double min_arc = 0.3;    ///< of the outline must have an edge on it
  double min_fill = 0.25;  ///< of the disc must have the ball's colour
  double max_leak = 0.55;  ///< of the rim may have it
  /// But of a smaller ball's only so much: some circle fits into a few pixels of anything.
  double small_radius_px = 5, max_small_leak = 0.1;
  /// Where more of the outline than this is hidden, what is seen must be shaded as a sphere is: so strongly
  /// (a part of the mean brightness), and so much of its shading must be that. A half-hidden disc is flat.
  double max_hidden = 0.45, min_shading = 0.4, min_shading_explained = 0.95;
  /// But where an edge follows so much of the outline in the picture, nothing hides the rest.
  double min_whole = 0.9;
  double min_quality = 0.36;
  /// A region that shows no clear ball may be what is left of one, whose rim is too dark or too pale for the
  /// class, if it is so large and fills its circle so far: then there is an edge on so much of an outline
  /// around it, its radius larger by a part of the circle's.
  double min_frayed_radius_px = 8, min_frayed_fill = 0.6, min_frayed_edge = 0.37, frayed_reach = 0.6;
  /// Where the class ends well inside the outline all around, it is a ball if an edge lies on so much of an
  /// outline that encloses the region, of whose disc so much and no more has the colour.
  double min_enclosing_edge = 0.5, min_enclosed_fill = 0.35, max_enclosed_fill = 0.6;
  /// Where a ball is expected and shows itself less clearly than any would: an edge on so much of its outline
  /// in the picture, so much of its disc of its colour.
  double min_expected_edge = 0.30, min_expected_fill = 0.4;
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
