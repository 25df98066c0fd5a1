#include "app/comparison/estimators/peers.hpp"

#include <fmt/format.h>
#include <visp3/blob/vpDot2.h>
#include <visp3/core/vpImageConvert.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "app/comparison/estimators/method_scene.hpp"

namespace ballservo {
namespace {

// The first, which is the best, or the one that is meant.
std::optional<MethodFit> chosen(const MethodScene& scene, const std::vector<OutlineEllipse>& found) {
  if (found.empty()) return std::nullopt;
  const auto& near_px = scene.task().near_px;
  if (!near_px) return scene.answer(found.front());
  return scene.answer(
      *std::min_element(found.begin(), found.end(), [&](const OutlineEllipse& a, const OutlineEllipse& b) {
        return (a.center_px - *near_px).norm() < (b.center_px - *near_px).norm();
      }));
}

std::vector<MethodFit> all_of(const MethodScene& scene, const std::vector<OutlineEllipse>& found) {
  std::vector<MethodFit> fits;
  for (const OutlineEllipse& circle : found) {
    if (const auto fit = scene.answer(circle)) fits.push_back(*fit);
  }
  return fits;
}

}  // namespace

std::optional<MethodFit> fit_hough_circles(MethodScene& scene, const HoughSettings& settings) {
  const auto& radius_px = scene.task().expected_radius_px;
  if (!radius_px) return std::nullopt;
  return chosen(scene, HoughGradient(*radius_px, settings).find(scene.bgr()));
}

std::optional<MethodFit> fit_hsv_contour(MethodScene& scene) {
  return chosen(scene, HsvContour(scene.task().hue, scene.task().peers.hsv).find(scene.bgr()));
}

std::optional<MethodFit> fit_vpdot2(MethodScene& scene) {
  const MethodTask& task = scene.task();
  if (!task.click_px) return std::nullopt;
  const auto blob = vpdot2_blob(scene.bgr(), task.hue, *task.click_px, task.peers.vpdot2);
  return blob ? scene.answer(*blob) : std::nullopt;
}

std::vector<MethodFit> detect_hough_gradient(MethodScene& scene) {
  const auto& radius_px = scene.task().expected_radius_px;
  if (!radius_px) return {};
  return all_of(scene, HoughGradient(*radius_px).find(scene.bgr()));
}

std::vector<MethodFit> detect_hsv_contour(MethodScene& scene) {
  return all_of(scene, HsvContour(scene.task().hue).find(scene.bgr()));
}

std::optional<OutlineEllipse> vpdot2_blob(const cv::Mat& bgr, int hue, const Eigen::Vector2d& click_px,
                                          const VpDot2Settings& settings) {
  cv::Mat grey;
  if (settings.mask) {
    HsvContour(hue, settings.hsv).mask(bgr).copyTo(grey);
  } else {
    cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  }
  const int u = static_cast<int>(std::lround(click_px.x())), v = static_cast<int>(std::lround(click_px.y()));
  if (u < 0 || v < 0 || u >= grey.cols || v >= grey.rows) return std::nullopt;
  if (settings.mask && grey.at<unsigned char>(v, u) == 0) return std::nullopt;
  try {
    vpDot2 dot;
    dot.setGraphics(false);
    dot.setComputeMoments(true);
    dot.setEllipsoidShapePrecision(settings.roundness);
    vpImage<unsigned char> picture;
    vpImageConvert::convert(grey, picture);
    dot.initTracking(picture, vpImagePoint(v, u));
    const OutlineEllipse blob{{dot.getCog().get_u(), dot.getCog().get_v()},
                              std::sqrt(std::max(0.0, dot.getArea()) / M_PI)};
    if (!blob.center_px.allFinite() || !(blob.radius_px > 0)) return std::nullopt;
    return blob;
  } catch (const vpException&) {  // no blob that it would track
    return std::nullopt;
  }
}

std::string in_words(const PeerSettings& settings) {
  const auto hough = [](const HoughSettings& s) {
    return fmt::format("param1 {:g}, param2 {:g}", s.edges, s.support);
  };
  const auto hsv = [](const HsvSettings& s) {
    return fmt::format("saturation from {:g}, value from {:g}", s.least_saturation, s.least_value);
  };
  const VpDot2Settings& dot = settings.vpdot2;
  return fmt::format(
      "hough_gradient: {}; hough_gradient_alt: {}; hsv_contour: {}; vpdot2: {}; ellipsoid shape precision "
      "{:g}",
      hough(settings.hough), hough(settings.hough_alt), hsv(settings.hsv),
      dot.mask ? "mask of hue, " + hsv(dot.hsv) : "grey picture", dot.roundness);
}

}  // namespace ballservo
