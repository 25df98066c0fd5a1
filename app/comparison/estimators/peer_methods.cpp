#include "app/comparison/estimators/peer_methods.hpp"

#include <algorithm>

#include "app/comparison/estimators/method_scene.hpp"

namespace ballservo {
namespace {

// The first of the list, or the one that is meant.
std::optional<MethodFit> chosen(const MethodScene& scene, const std::vector<OutlineEllipse>& found) {
  if (found.empty()) return std::nullopt;
  const auto& near_px = scene.task().near_px;
  if (!near_px) return scene.from_picture_circle(found.front());
  return scene.from_picture_circle(
      *std::min_element(found.begin(), found.end(), [&](const OutlineEllipse& a, const OutlineEllipse& b) {
        return (a.center_px - *near_px).norm() < (b.center_px - *near_px).norm();
      }));
}

std::optional<MethodFit> hough(MethodScene& scene, const HoughSettings& settings) {
  const auto& radius_px = scene.task().expected_radius_px;
  if (!radius_px) return std::nullopt;
  return chosen(scene, HoughGradient(*radius_px, settings).find(scene.bgr()));
}

std::vector<MethodFit> all_of(const MethodScene& scene, const std::vector<OutlineEllipse>& found) {
  std::vector<MethodFit> fits;
  for (const OutlineEllipse& circle : found) {
    if (const auto fit = scene.from_picture_circle(circle)) fits.push_back(*fit);
  }
  return fits;
}

}  // namespace

std::optional<MethodFit> fit_hough_gradient(MethodScene& scene) {
  return hough(scene, scene.task().peers.hough);
}

std::optional<MethodFit> fit_hough_gradient_alt(MethodScene& scene) {
  return hough(scene, scene.task().peers.hough_alt);
}

std::optional<MethodFit> fit_hsv_contour(MethodScene& scene) {
  std::vector<OutlineEllipse> found = HsvContour(scene.task().hue, scene.task().peers.hsv).find(scene.bgr());
  std::stable_sort(found.begin(), found.end(), [](const OutlineEllipse& a, const OutlineEllipse& b) {
    return a.radius_px > b.radius_px;
  });
  return chosen(scene, found);
}

std::optional<MethodFit> fit_vpdot2(MethodScene& scene) {
  const MethodTask& task = scene.task();
  if (!task.click_px) return std::nullopt;
  const auto blob = vpdot2_blob(scene.bgr(), task.hue, *task.click_px, task.peers.vpdot2);
  return blob ? scene.from_picture_circle(*blob) : std::nullopt;
}

std::vector<MethodFit> detect_hough_gradient(MethodScene& scene) {
  const auto& radius_px = scene.task().expected_radius_px;
  if (!radius_px) return {};
  return all_of(scene, HoughGradient(*radius_px, PeerSettings{}.hough).find(scene.bgr()));
}

std::vector<MethodFit> detect_hsv_contour(MethodScene& scene) {
  return all_of(scene, HsvContour(scene.task().hue, PeerSettings{}.hsv).find(scene.bgr()));
}

}  // namespace ballservo
