#include "app/comparison/estimators/methods.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "app/comparison/estimators/fits.hpp"
#include "app/comparison/estimators/method_scene.hpp"
#include "app/comparison/estimators/peers.hpp"
#include "app/comparison/estimators/stopwatch.hpp"
#include "app/comparison/frame_record.hpp"

namespace ballservo {
namespace {

FitMethod paper_steps(int steps, bool reselect) {
  const std::string name = fmt::format("paper_steps_{}{}", steps, reselect ? "_reselect" : "");
  const std::string what = fmt::format("{} Gauss-Newton steps on E(c), its pixels {}", steps,
                                       reselect ? "chosen anew around each step's circle" : "chosen once");
  return {name, what, MethodPoints::ring, false,
          [=](MethodScene& scene) { return fit_paper_steps(scene, steps, reselect); }};
}

FitMethod peer(const char* name, const char* what, std::optional<MethodFit> (*fit)(MethodScene&)) {
  return {name, what, MethodPoints::none, true, fit};
}

FitMethod whole_detector(const char* name, const char* what, MethodPoints points, bool is_peer,
                         std::vector<MethodFit> (*detect)(MethodScene&)) {
  return {name, what, points, is_peer, {}, detect};
}

std::vector<FitMethod> make_methods() {
  const auto ring = MethodPoints::ring, edges = MethodPoints::edges;
  return {
      {"vote", "the circle that random triples of boundary pixels agree on, before any refinement",
       MethodPoints::detection, false, fit_vote},
      {"paper_one_step", "one Gauss-Newton step on E(c) = sum |grad I|^2 (|p - c| - r)^2 over the ring", ring,
       false, [](MethodScene& scene) { return fit_paper_steps(scene, 1, false); }},
      paper_steps(2, false),
      paper_steps(3, false),
      paper_steps(5, false),
      paper_steps(10, false),
      paper_steps(2, true),
      paper_steps(3, true),
      paper_steps(5, true),
      paper_steps(10, true),
      {"paper_converged", "the minimum of E(c) over the same pixels (Ceres)", ring, false,
       [](MethodScene& scene) { return fit_paper_converged(scene, false); }},
      {"paper_robust", "E(c) with a robust loss in place of the square (Ceres, several starts)", ring, false,
       [](MethodScene& scene) { return fit_paper_converged(scene, true); }},
      {"sphere_one_step",
       "one Gauss-Newton step on the angles between edge rays and the ball's tangent cone: what runs on line",
       edges, false, [](MethodScene& scene) { return fit_sphere_steps(scene, 1); }},
      {"sphere_steps_2", "two such steps on the same points", edges, false,
       [](MethodScene& scene) { return fit_sphere_steps(scene, 2); }},
      {"sphere_converged", "the minimum of the same over the same points (Ceres)", edges, false,
       [](MethodScene& scene) { return fit_sphere_converged(scene, false); }},
      {"sphere_robust", "a robust loss in place of the points' robust weights (Ceres, several starts)", edges,
       false, [](MethodScene& scene) { return fit_sphere_converged(scene, true); }},
      {"kasa", "Kasa's algebraic circle: sum w (|p - c|^2 - r^2)^2 over the ring", ring, false, fit_kasa},
      {"taubin", "Taubin's algebraic circle: the same over its mean squared slope", ring, false, fit_taubin},
      peer("hough_gradient", "OpenCV HoughCircles, HOUGH_GRADIENT, told the radius to within a half",
           [](MethodScene& scene) { return fit_hough_circles(scene, scene.task().peers.hough); }),
      peer("hough_gradient_alt", "OpenCV HoughCircles, HOUGH_GRADIENT_ALT, told the same",
           [](MethodScene& scene) { return fit_hough_circles(scene, scene.task().peers.hough_alt); }),
      peer("hsv_contour", "OpenCV: range in HSV, contours, smallest enclosing circle of the largest",
           fit_hsv_contour),
      peer("vpdot2", "ViSP vpDot2, started by a click on the ball: moments of the blob", fit_vpdot2),
      whole_detector("detect_sphere", "every ball that `detect` reports", MethodPoints::sphere_detector,
                     false, [](MethodScene& scene) { return scene.detections(BallFit::sphere); }),
      whole_detector("detect_paper", "every ball that `detect --fit paper` reports",
                     MethodPoints::paper_detector, false,
                     [](MethodScene& scene) { return scene.detections(BallFit::paper); }),
      whole_detector("detect_hough_gradient", "every circle of hough_gradient, as tutorials set it up",
                     MethodPoints::none, true, detect_hough_gradient),
      whole_detector("detect_hsv_contour", "every contour of hsv_contour, as tutorials set it up",
                     MethodPoints::none, true, detect_hsv_contour),
  };
}

// The nearest of those at the ball, or else the best.
std::optional<MethodFit> counted_one(const std::vector<MethodFit>& found, const FrameTruth& truth) {
  if (found.empty()) return std::nullopt;
  const MethodFit* counted = &found.front();
  double least_px = std::numeric_limits<double>::infinity();
  for (const MethodFit& fit : found) {
    if (!truth.outline || !at_the_ball(fit, truth)) continue;
    const double apart_px = (fit.outline.center_px - truth.outline->center_px).norm();
    if (apart_px < least_px) counted = &fit, least_px = apart_px;
  }
  MethodFit fit = *counted;
  fit.others = static_cast<int>(found.size()) - 1;
  return fit;
}

}  // namespace

const std::vector<FitMethod>& fit_methods() {
  static const std::vector<FitMethod> methods = make_methods();
  return methods;
}

const FitMethod* find_fit_method(std::string_view name) {
  for (const FitMethod& method : fit_methods()) {
    if (method.name == name) return &method;
  }
  return nullptr;
}

std::optional<std::size_t> place_of(const MethodList& methods, std::string_view name) {
  const auto it =
      std::find_if(methods.begin(), methods.end(), [&](const FitMethod* m) { return m->name == name; });
  return it == methods.end() ? std::nullopt : std::optional<std::size_t>(it - methods.begin());
}

std::vector<std::optional<MethodFit>> run_methods(MethodScene& scene, const MethodList& methods,
                                                  const FrameTruth& truth) {
  for (const FitMethod* method : methods) scene.prepare(method->points);
  std::vector<std::optional<MethodFit>> fits;
  for (const FitMethod* method : methods) {
    const Stopwatch own;
    if (method->fit) {
      fits.push_back(method->fit(scene));
    } else {
      fits.push_back(counted_one(method->detect(scene), truth));
      // Of several balls in a user's picture the others are no errors.
      if (fits.back() && scene.task().near_px) fits.back()->others = 0;
    }
    const double own_us = own.us();
    if (fits.back()) fits.back()->time_us = own_us + scene.shared_us(method->points);
  }
  return fits;
}

}  // namespace ballservo
