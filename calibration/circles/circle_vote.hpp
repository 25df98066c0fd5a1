// Stage 4: a circle by random three-point votes (paper, "Estimation des parametres du cercle").
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "calibration/base/random.hpp"

namespace ballservo {

/// Where a region ends: a place (undistorted, px), and the unit normal outwards or (0, 0) where not known.
struct BoundaryPoint {
  Eigen::Vector2f position_px{0, 0};
  Eigen::Vector2f normal{0, 0};
};

/// A circle in the undistorted picture of square pixels, relative to its principal point (px).
struct UndistortedCircle {
  Eigen::Vector2d center_px{0, 0};
  double radius_px = 0;
};

/// What the votes say.
struct CircleEstimate : UndistortedCircle {
  int votes = 0;         ///< N_votes: triples drawn
  int points = 0;        ///< N_points
  int center_peak = 0;   ///< c_max: votes in the fullest cell
  int radius_peak = 0;   ///< r_max: points in the fullest radius cell
  bool stopped = false;  ///< the threshold was reached before the cap
  /// The paper's Q_c = c_max r_max / (N_votes N_points).
  double quality() const {
    return votes > 0 && points > 0
               ? static_cast<double>(center_peak) * radius_peak / (static_cast<double>(votes) * points)
               : 0;
  }
};

/// Centre of the circle through three points (paper, eqs. 1 and 2); nothing where they are nearly collinear.
std::optional<Eigen::Vector2d> circumcenter(const Eigen::Vector2d& p1, const Eigen::Vector2d& p2,
                                            const Eigen::Vector2d& p3);

/// The 2-D histogram of centre votes, kept for pictures of the stages.
struct VoteHistogram {
  Eigen::Vector2d origin_px{0, 0};  ///< position of the first cell's centre
  double cell_px = 1;
  int columns = 0, rows = 0;
  std::vector<std::uint16_t> counts;  ///< row by row
};

/// Estimates circles; keeps its histogram between calls so that it allocates only while it grows.
class CircleVoter {
 public:
  /// The circle that most triples of the boundary points agree on; nothing for fewer than 8 points or where
  /// no triple makes a circle. Half of the triples are of points near each other in the list, which should
  /// therefore be in some order of space (as by rows): so an arc is found in a long outline. `engine` is the
  /// only source of chance.
  std::optional<CircleEstimate> estimate(const std::vector<BoundaryPoint>& points, RandomEngine& engine);

  const VoteHistogram& histogram() const { return histogram_; }  ///< of the last call

 private:
  bool set_up_histogram(const std::vector<BoundaryPoint>& points);
  /// Three indices below `count`, from all or from a neighbourhood of 2^0 to 2^octaves times the least reach.
  std::array<std::size_t, 3> draw(int count, int octaves, RandomEngine& engine) const;
  Eigen::Vector2d mean_of_votes_near(const Eigen::Vector2d& peak) const;
  bool vote_radius(const std::vector<BoundaryPoint>& points, CircleEstimate& circle);

  VoteHistogram histogram_;
  std::vector<std::uint16_t> radii_;
  std::vector<Eigen::Vector2f> votes_;  // the centres, to average those around the peak
};

}  // namespace ballservo
