#include "app/offline/peer_methods.hpp"

#include <algorithm>

#include "app/offline/method_scene.hpp"

namespace ballservo {
namespace {

std::optional<MethodFit> first_of(const MethodScene& scene, const std::vector<OutlineEllipse>& found) {
  return found.empty() ? std::nullopt : scene.from_picture_circle(found.front());
}

}  // namespace

std::optional<MethodFit> fit_hough_gradient(MethodScene& scene) {
  const MethodTask& task = scene.task();
  if (!task.expected_radius_px) return std::nullopt;
  return first_of(scene, HoughGradient(*task.expected_radius_px, task.peers.hough).find(scene.bgr()));
}

std::optional<MethodFit> fit_hough_gradient_alt(MethodScene& scene) {
  const MethodTask& task = scene.task();
  if (!task.expected_radius_px) return std::nullopt;
  return first_of(scene, HoughGradientAlt(*task.expected_radius_px, task.peers.hough_alt).find(scene.bgr()));
}

std::optional<MethodFit> fit_hsv_contour(MethodScene& scene) {
  const std::vector<OutlineEllipse> found =
      HsvContour(scene.task().hue, scene.task().peers.hsv).find(scene.bgr());
  const auto largest = std::max_element(
      found.begin(), found.end(),
      [](const OutlineEllipse& a, const OutlineEllipse& b) { return a.radius_px < b.radius_px; });
  return largest == found.end() ? std::nullopt : scene.from_picture_circle(*largest);
}

std::optional<MethodFit> fit_vpdot2(MethodScene& scene) {
  const MethodTask& task = scene.task();
  if (!task.click_px) return std::nullopt;
  const auto blob = vpdot2_blob(scene.bgr(), task.hue, *task.click_px, task.peers.vpdot2);
  return blob ? scene.from_picture_circle(*blob) : std::nullopt;
}

}  // namespace ballservo
