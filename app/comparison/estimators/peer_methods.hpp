// Other people's recipes as methods: each answers with its own best circle, and the paper's formula makes it
// a position.
#pragma once

#include <optional>

#include "app/comparison/estimators/methods.hpp"

namespace ballservo {

/// HoughCircles' strongest circle, told the radius to within a half.
std::optional<MethodFit> fit_hough_gradient(MethodScene& scene);
std::optional<MethodFit> fit_hough_gradient_alt(MethodScene& scene);
/// The largest contour of the ball's hue, by its smallest enclosing circle.
std::optional<MethodFit> fit_hsv_contour(MethodScene& scene);
/// ViSP's blob around a click on the ball.
std::optional<MethodFit> fit_vpdot2(MethodScene& scene);

/// All circles of HoughCircles, and all contours of the ball's hue, with the settings of tutorials.
std::vector<MethodFit> detect_hough_gradient(MethodScene& scene);
std::vector<MethodFit> detect_hsv_contour(MethodScene& scene);

}  // namespace ballservo
