// How an edge's colours mix. The blur of a lens mixes the light of ball and background, in all channels
// alike; grey levels that are not proportional to the light mix otherwise, and each channel in a way of its
// own.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "perception/outline/camera_response.hpp"
#include "perception/outline/edge_model.hpp"

namespace ballservo {

/// A pixel near the outline.
struct RingColor {
  float distance_px;  ///< outside the outline, negative inside
  cv::Vec3b bgr;
};

/// Sum of the squares (grey levels) that remain when the fitted edge, with levels and shading of its own in
/// each channel, is taken from the pixels under that response.
double squares_left(const std::vector<RingColor>& pixels, const EdgeProfileFit& edge,
                    const CameraResponse& response);

}  // namespace ballservo
