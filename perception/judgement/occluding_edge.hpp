// What hides the rest of a ball: a thing with a straight edge, which goes on beyond the ball.
#pragma once

#include <opencv2/core.hpp>

#include "calibration/camera/sphere_outline.hpp"
#include "perception/segmentation/bit_picture.hpp"

namespace ballservo {

/// Whether the colour inside an outline ends along a chord of it, and an edge in the picture goes on from the
/// chord's ends: so it is where a thing stands before a ball. Half a disc ends along a chord too, but there
/// the picture is the same on both sides of where the chord would go on.
bool is_behind_straight_edge(const cv::Mat& bgr, const ColoredPixels& colored, const OutlineEllipse& outline);

}  // namespace ballservo
