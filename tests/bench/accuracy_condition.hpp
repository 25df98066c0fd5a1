// The conditions under which accuracy is measured, and the frames of each: a new scene every time, with exact
// truth.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibration/base/random.hpp"
#include "calibration/camera/ray_table.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "calibration/color/color_table.hpp"

namespace ballservo::bench {

/// What stands beside the ball, or instead of it.
enum class Neighbour { none, touching_bar, picture_border, no_ball };

/// How the painted pictures' ball looks (see painted_frame.hpp).
struct PaintedLook {
  bool half_shade = false, highlight = false, marbled = false, contact_shadow = false;
};

/// A 7 cm ball in a picture of 640x480.
struct AccuracyCondition {
  std::string name, words;
  bool painted = false;  ///< by painted_frame, else by the simulator's renderer
  double focal_px = 857;
  double depth_m = 1;  ///< Z of the ball, +- 2 %
  double off_axis_rad = 0;
  double hidden = 0;  ///< fraction of the outline's area behind an occluder
  double blur_px = 0.7, noise = 2, gamma = 1;
  Neighbour neighbour = Neighbour::none;
  int distractors = 4;  ///< things of the ball's colour
  PaintedLook look;
  std::string sweep;  ///< the plot it belongs to; empty: the table
  double sweep_value = 0;
};

struct AccuracyFrame {
  cv::Mat bgr;
  std::optional<OutlineEllipse> truth;  ///< nothing: there is no ball in it
  Eigen::Vector3d p_CB{0, 0, 0};        ///< m
  double visible_fraction = 0;
  cv::Mat clean_bgr;  ///< the same without noise
  cv::Mat unhidden;   ///< as BoundScene has it
};

constexpr double accuracy_ball_radius_m = 0.035;

/// The table's conditions, and those of the sweeps (`sweep` not empty).
const std::vector<AccuracyCondition>& accuracy_conditions();

Camera accuracy_camera(const AccuracyCondition& condition);

/// The ball's colour: red where rendered, green where painted.
int accuracy_hue(const AccuracyCondition& condition);  ///< as OpenCV counts it
std::shared_ptr<const ColorTable> accuracy_colors(const AccuracyCondition& condition);

/// Where the ball stands (m, camera frame), by chance.
Eigen::Vector3d accuracy_place(const AccuracyCondition& condition, const Camera& camera,
                               RandomEngine& engine);

/// How far from a disc's centre (in radii) a straight edge runs that hides the given fraction of it.
double hiding_edge_distance(double hidden_fraction);

/// Frame `index` of a condition; from (seed, the condition's name, index) alone.
AccuracyFrame make_accuracy_frame(const AccuracyCondition& condition, std::uint64_t seed, int index);

}  // namespace ballservo::bench
