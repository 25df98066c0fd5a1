// What the pixels at a circle say for a ball: its contour, its shading, its colour.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace ballservo {

/// A circle, or with `shape` (symmetric, determinant 1) an ellipse: center + radius * shape * (unit vector).
struct Outline {
  Eigen::Vector2d center_px{0, 0};
  double radius_px = 0;
  Eigen::Matrix2d shape = Eigen::Matrix2d::Identity();
};

struct CircleEvidence {
  Eigen::Vector2d center_px{0, 0};  ///< of the circle through the edges found
  double radius_px = 0;
  double contour = 0;    ///< log likelihood ratio of the rim: circle against any star-shaped outline
  double arc = 0;        ///< of the rim within the picture: the part that has an edge on the circle
  double ellipse = 0;    ///< amplitude of the second harmonic, of the radius
  double edge = 0;       ///< median contrast of the edges on the circle, Lab
  double shading = 0;    ///< part of the light's variance that a sphere's normals explain
  double relief = 0;     ///< standard deviation of the shading, of the mean light
  double distinct = 0;   ///< how far the disc's colours are other than those around it, 0 to 1
  double rim = 0;        ///< part of what the disc shows near its rim that has the ball's hue
  double filled = 0;     ///< part of the disc that has the ball's hue
  double hidden_by = 1;  ///< how far what hides it is other than what lies around the rest, 0 to 1
  double pattern = 0;    ///< log likelihood that it loses to a pattern of many like it
  Eigen::Vector3d color{0, 0, 0};  ///< mean (L, a, b) of what has the ball's hue in the disc

  /// How much it is shaded as a sphere, 0 to 1.
  double sphere() const;
  /// Logarithm of the odds that it is a ball, whatever its colour: few balls are dull.
  double log_odds() const;
  /// The same of a colour that is known to be a ball's, as vivid as it is.
  double log_odds_of_known_color() const;
};

/// Measures in a picture (L, a, b) around `outline`, of what has `color` (L, a, b) in whatever light.
CircleEvidence circle_evidence(const cv::Mat3f& lab, const Outline& outline, const Eigen::Vector3d& color);

/// The pixels that have `color` in whatever light: CV_8U, 0 or 255.
cv::Mat ball_pixels(const cv::Mat3f& lab, const Eigen::Vector3d& color);

}  // namespace ballservo
