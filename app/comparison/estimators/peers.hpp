// Other people's recipes as methods, and how each is set up. Each answers with its own best circle, and the
// paper's formula makes it a position.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/comparison/estimators/methods.hpp"
#include "app/comparison/estimators/opencv_peers.hpp"

namespace ballservo {

/// What ViSP's blob tracker is started on, and how round a blob must be.
struct VpDot2Settings {
  bool mask = true;         ///< the picture of the ball's hue (see HsvContour) instead of the grey one
  double roundness = 0.65;  ///< setEllipsoidShapePrecision: 0 takes any shape
  HsvSettings hsv{80, 30};
};

struct PeerSettings {
  HoughSettings hough;
  HoughSettings hough_alt{cv::HOUGH_GRADIENT_ALT, 300, 0.8};
  HsvSettings hsv;
  VpDot2Settings vpdot2;
};

/// "hough_gradient: param1 100, param2 20; ...": in the words of each peer's own interface.
std::string in_words(const PeerSettings& settings);

/// HoughCircles' strongest circle, told the radius to within a half.
std::optional<MethodFit> fit_hough_circles(MethodScene& scene, const HoughSettings& settings);
/// The largest contour of the ball's hue, by its smallest enclosing circle.
std::optional<MethodFit> fit_hsv_contour(MethodScene& scene);
/// ViSP's blob around a click on the ball.
std::optional<MethodFit> fit_vpdot2(MethodScene& scene);

/// All circles of HoughCircles, and all contours of the ball's hue, with the settings of tutorials.
std::vector<MethodFit> detect_hough_gradient(MethodScene& scene);
std::vector<MethodFit> detect_hsv_contour(MethodScene& scene);

/// The blob (vpDot2) around a clicked pixel: its centre of gravity, and the radius of a disc of its area.
/// Nothing where the tracker refuses.
std::optional<OutlineEllipse> vpdot2_blob(const cv::Mat& bgr, int hue, const Eigen::Vector2d& click_px,
                                          const VpDot2Settings& settings);

}  // namespace ballservo
