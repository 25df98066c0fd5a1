// Where circles may be: what the edges of a picture point at.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "calibration/circles/circle_evidence.hpp"

namespace ballservo {

/// Circles that many edges of a picture (L, a, b) agree on, in whatever sense they go, the most agreed on
/// first; true to about a quarter of the radius (radial symmetry: Loy and Zelinsky, 2003).
std::vector<Outline> circle_seeds(const cv::Mat3f& lab, double min_radius_px);

}  // namespace ballservo
