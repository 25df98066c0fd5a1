// A quick look for edges where the class picture shows none: the ball's colour on both sides of its outline.
#pragma once

#include <opencv2/core.hpp>

#include "calibration/camera/camera.hpp"
#include "perception/judgement/outline_support.hpp"
#include "perception/outline/cone_fit.hpp"

namespace ballservo {

/// Sees in `sectors` those with the ball's colour outside the cone's outline where the picture's colours step
/// near it, by whole pixels and no model of the edge.
void see_steps_in_own_color(const cv::Mat& bgr, const ColoredPixels& colored, const Camera& camera,
                            const TangentCone& cone, OutlineSectors& sectors);

}  // namespace ballservo
