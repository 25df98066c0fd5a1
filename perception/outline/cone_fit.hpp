// Stage 5, exact: the cone of rays that touch the ball, fitted to rays of its edge.
//
// The rays that touch a sphere of centre C and radius R make a cone around C with half angle alpha,
// sin(alpha) = R/|C| (u.C = sqrt(|C|^2 - R^2) for every unit ray u of it). On the unit sphere of directions
// the outline is therefore an exact circle, wherever the ball stands and whatever the lens: fitting it is
// fitting a circle there.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calibration/circles/circle_vote.hpp"

namespace ballservo {

/// The tangent cone of a ball: all that a picture tells about it without its diameter.
struct TangentCone {
  Eigen::Vector3d axis{0, 0, 1};  ///< unit vector to the ball's centre, camera frame
  double alpha_rad = 0;           ///< half angle, 0 to pi/2

  /// The ball's centre (m, camera frame) given its radius.
  Eigen::Vector3d center(double radius_m) const;
  /// The cone of a ball; nothing when the camera is inside it or anything is not finite.
  static std::optional<TangentCone> of_sphere(const Eigen::Vector3d& p_C, double radius_m);
};

/// What is known of a cone's half angle before its edge is seen, as of a ball that was followed; no sigma:
/// nothing.
struct KnownAngle {
  double alpha_rad = 0, sigma_rad = 0;
};

/// A place on the ball's edge.
struct EdgePoint {
  Eigen::Vector3d ray{0, 0, 1};  ///< unit, camera frame
  double px_per_rad = 1;         ///< how far the edge moves in the picture when its ray turns outward
  double sigma_px = 1;           ///< standard deviation of its place across the edge
  double weight = 1;             ///< robust weight, 0 (not the ball's edge) to 1
  double angle_rad = 0;          ///< where on the outline, about the axis of the cone it was sought around
};

/// One fit's outcome.
struct ConeFit {
  TangentCone cone;
  /// Where the lens is not known: the outline's departure from a circle, (cos, sin) of twice the angle, rad.
  Eigen::Vector2d oval_rad{0, 0};
  /// Covariance of (turn along basis column 1, turn along column 2, alpha), rad^2; basis =
  /// perpendicular_basis(axis).
  Eigen::Matrix3d covariance_rad2 = Eigen::Matrix3d::Zero();
  double residual_px = 0;  ///< weighted RMS of the edge points' distances from the outline, after the step
  double step_px = 0;      ///< largest move of the outline by the step
};

/// The angle (rad) between two directions.
double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

/// Signed angle (rad) of a ray outside the cone (negative inside): angle(u, axis) - alpha.
double angle_outside(const TangentCone& cone, const Eigen::Vector3d& ray);

/// The cone after turning its axis by `step` = (turn 1, turn 2, change of alpha), rad:
/// axis' ~ axis + basis (turn 1, turn 2).
TangentCone moved(const TangentCone& cone, const Eigen::Vector3d& step_rad);

/// Signed angle (rad) of a ray outside the fitted outline, its oval included.
double angle_outside(const ConeFit& fit, const Eigen::Vector3d& ray);

/// Through a lens that is not known a ball away from the axis is an oval, by how much nobody can say.
/// `oval_fraction` is the sigma of that departure as a fraction of alpha; 0 where the lens is known and the
/// outline is a cone.
///
/// Exactly one Gauss-Newton step from `start` on sum_i weight_i (angle_outside_i px_per_rad_i / sigma_i)^2
/// with the points and weights held fixed. Nothing for fewer than 3 points of weight or a degenerate set.
/// The covariance is (J'WJ)^-1 times the residuals' own scale where that is above 1, and an error common to
/// all points.
std::optional<ConeFit> one_gauss_newton_step(const TangentCone& start, const std::vector<EdgePoint>& edges,
                                             double oval_fraction = 0, const KnownAngle& known = {});

/// Robust weights of edge points; keeps its buffers between calls.
class RobustWeights {
 public:
  /// Sets the weights (Tukey's biweight, Beaton and Tukey 1974) of the points about the best cone near
  /// `start`: a few reweighted solutions of the problem linearised once, at `start`. `floor_px` bounds the
  /// scale from below; the weights have settled where the outline moves less than `settled_px`. Returns that
  /// cone as the step (turn 1, turn 2, change of alpha; rad) from `start`; nothing for a degenerate set.
  std::optional<Eigen::Vector3d> set(const TangentCone& start, std::vector<EdgePoint>& edges, double floor_px,
                                     double oval_fraction = 0, double settled_px = 1e-3,
                                     const KnownAngle& known = {});

 private:
  struct Point {
    Eigen::Matrix<double, 5, 1> row;
    double outside_px, residual_px;  // of the start, and of the solution so far
    double px_per_rad, inverse;      // inverse: 1/sigma, per rad
  };
  std::vector<Point> points_;
  std::vector<double> magnitudes_;
};

/// Covariance of the ball's centre (m^2, camera frame) given its radius and that radius's own sigma (m).
Eigen::Matrix3d center_covariance(const ConeFit& fit, double radius_m, double radius_sigma_m);

/// The unit ray (camera frame) of an undistorted place.
Eigen::Vector3d ray_of(const BoundaryPoint& point, double focal_px);

/// How far (px) an edge or a boundary pixel may lie from a ball's outline and still speak for it.
double outline_tolerance_px(double radius_px);

/// Cones through boundary points, before any edge is measured; keeps its buffers between calls.
class BoundaryCone {
 public:
  /// Through the points near the voted cone: enough to ask whether a ball is likely. The voted one itself
  /// where they say nothing.
  TangentCone rough(const TangentCone& voted, const std::vector<BoundaryPoint>& points, double focal_px);

  /// The votes look for a circle; a ball off the axis is none, and they may settle on a part of it. The cone
  /// through the points near the rough one is the whole ball's. Nothing for a degenerate set.
  std::optional<TangentCone> robust(const TangentCone& rough, const std::vector<BoundaryPoint>& points,
                                    double focal_px, double oval_fraction);

 private:
  std::vector<Eigen::Vector3d> rays_;
  std::vector<EdgePoint> edges_;
  RobustWeights weights_;
};

}  // namespace ballservo
