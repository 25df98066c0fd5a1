// One frame of a comparison's condition: a room, a ball where the condition has it, a picture with exact
// truth.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <string>

#include "app/comparison/pictures/plan.hpp"
#include "servo/simulation/rendering/truth.hpp"

namespace ballservo {

/// How many instants stand for an exposure in which the camera moves.
inline constexpr int motion_views = 5;

struct RenderedFrame {
  cv::Mat bgr;
  BallTruth truth;
  /// For the bound: the picture without noise, and what is not hidden (see BoundScene). Empty where the
  /// bound's model of the picture does not hold: the camera moves, or its response is not linear.
  cv::Mat clean_bgr, unhidden;
};

/// The pixels at most `reach_px` away along each axis; may leave the picture.
inline cv::Rect square_around(const Eigen::Vector2d& center_px, int reach_px) {
  return {static_cast<int>(center_px.x()) - reach_px, static_cast<int>(center_px.y()) - reach_px,
          2 * reach_px, 2 * reach_px};
}

/// Draws frame number `frame` of a condition. Background, clutter, light, the occluder's side, the direction
/// off the axis, and a shift of a pixel and a half and of 2 % in depth come from (seed, the condition's name,
/// frame) alone.
RenderedFrame render_comparison_frame(const ComparisonCondition& condition, std::uint64_t seed, int frame);

/// Why the condition cannot be rendered: the ball's outline leaves the picture, the camera is inside the
/// ball. Empty if it can.
std::string why_not_rendered(const ComparisonCondition& condition);

}  // namespace ballservo
