#include "app/offline/methods.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "app/offline/converged_fits.hpp"
#include "perception/ball_position.hpp"

namespace ballservo {
namespace {

constexpr std::array<std::string_view, all_fit_methods.size()> names{
    "vote", "paper_one_step", "paper_converged", "sphere_one_step", "sphere_converged"};

class Stopwatch {
 public:
  double us() const {
    return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// A circle of the undistorted picture as it appears in the picture as given: centroid and sqrt(area / pi) of
// its image, which for a pinhole camera of square pixels is the circle itself.
std::optional<OutlineEllipse> circle_in_picture(const Camera& camera, const UndistortedCircle& circle) {
  constexpr int count = 256;
  constexpr double pi = 3.14159265358979323846;
  std::array<Eigen::Vector2d, count> points;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * pi * k / count;
    const Eigen::Vector2d p =
        circle.center_px + circle.radius_px * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const auto pixel = camera.project({p.x(), p.y(), camera.focal_px()});
    if (!pixel) return std::nullopt;
    points[static_cast<std::size_t>(k)] = *pixel;
  }
  const Eigen::Vector2d origin = points[0];
  double twice_area = 0;
  Eigen::Vector2d moment(0, 0);
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::Vector2d a = points[k] - origin, b = points[(k + 1) % count] - origin;
    const double cross = a.x() * b.y() - a.y() * b.x();
    twice_area += cross;
    moment += cross * (a + b);
  }
  if (!(twice_area > 0)) return std::nullopt;
  // A polygon of n corners on a circle lacks a known share of its area.
  const double share = std::sin(2 * pi / count) / (2 * pi / count);
  return OutlineEllipse{origin + moment / (3 * twice_area), std::sqrt(twice_area / 2 / share / pi)};
}

std::optional<MethodFit> from_circle(const Camera& camera, const UndistortedCircle& circle, double radius_m) {
  const auto outline = circle_in_picture(camera, circle);
  if (!outline) return std::nullopt;
  MethodFit fit;
  fit.outline = *outline;
  fit.p_C = paper_position(circle, camera.focal_px(), radius_m);
  return fit;
}

std::optional<MethodFit> from_cone(const Camera& camera, const TangentCone& cone, double radius_m) {
  const auto outline = project_sphere(camera, cone.axis, std::sin(cone.alpha_rad));
  if (!outline) return std::nullopt;
  MethodFit fit;
  fit.outline = *outline;
  fit.p_C = cone.center(radius_m);
  return fit;
}

// The boundary points that a circle was voted from, as the detector had them: undistorted, half a pixel
// outward.
std::vector<BoundaryPoint> boundary_of(const RayTable& rays, const DetectionStages& stages,
                                       const CircleEstimate& vote) {
  std::vector<BoundaryPoint> points;
  for (const auto& candidate : stages.candidates) {
    if (!candidate.accepted || candidate.estimate.center_px != vote.center_px) continue;
    for (const BoundaryPixel& pixel : candidate.outline) {
      const auto position = rays.undistorted_px(pixel.u_px, pixel.v_px);
      if (position) points.push_back({*position + 0.5f * pixel.outward, pixel.outward});
    }
    break;
  }
  return points;
}

void set_effort(std::optional<MethodFit>& fit, int iterations, double residual_px, double time_us) {
  if (!fit) return;
  fit->iterations = iterations;
  fit->residual_px = residual_px;
  fit->time_us = time_us;
}

}  // namespace

std::string_view fit_method_name(FitMethod method) { return names[static_cast<std::size_t>(method)]; }

std::optional<FitMethod> fit_method_from_name(std::string_view name) {
  for (const FitMethod method : all_fit_methods) {
    if (fit_method_name(method) == name) return method;
  }
  return std::nullopt;
}

std::vector<std::optional<MethodFit>> run_methods(Detector& detector, const cv::Mat& bgr,
                                                  ClassIndex color_class,
                                                  const std::vector<FitMethod>& methods) {
  std::vector<std::optional<MethodFit>> fits(methods.size());
  const Camera& camera = detector.rays().camera();
  const double radius_m = detector.fitter().radius_of(color_class).radius_m;

  DetectionStages stages;
  const Stopwatch detection;
  const std::vector<BallObservation>& balls = detector.detect(bgr, {}, &stages);
  const double detection_us = detection.us();
  const auto ball = std::find_if(balls.begin(), balls.end(),
                                 [&](const BallObservation& b) { return b.color_class == color_class; });
  if (ball == balls.end()) return fits;
  const CircleEstimate vote = ball->vote;
  const std::vector<BoundaryPoint> boundary = boundary_of(detector.rays(), stages, vote);

  const auto set = [&](FitMethod method, const std::optional<MethodFit>& fit) {
    const auto place = std::find(methods.begin(), methods.end(), method);
    if (place != methods.end()) fits[static_cast<std::size_t>(place - methods.begin())] = fit;
  };
  auto voted = from_circle(camera, {vote.center_px, vote.radius_px}, radius_m);
  if (voted) voted->time_us = detection_us;
  set(FitMethod::vote, voted);

  RefinementInput paper;
  const Stopwatch paper_step;
  detector.fitter().refine(bgr, color_class, vote, boundary, BallFit::paper, &paper);
  const double paper_us = paper_step.us();
  if (const auto step = one_gauss_newton_step(paper.vote, paper.ring)) {
    auto fit = from_circle(camera, step->circle, radius_m);
    set_effort(fit, 1, step->residual_px, paper_us);
    set(FitMethod::paper_one_step, fit);
  }
  const Stopwatch paper_solver;
  if (const auto minimum = converge_circle(paper.vote, paper.ring)) {
    auto fit = from_circle(camera, minimum->circle, radius_m);
    set_effort(fit, minimum->convergence.iterations, minimum->convergence.residual_px, paper_solver.us());
    set(FitMethod::paper_converged, fit);
  }

  RefinementInput sphere;
  const Stopwatch sphere_step;
  detector.fitter().refine(bgr, color_class, vote, boundary, BallFit::sphere, &sphere);
  const double sphere_us = sphere_step.us();
  if (const auto step = one_gauss_newton_step(sphere.start, sphere.edges)) {
    auto fit = from_cone(camera, step->cone, radius_m);
    set_effort(fit, 1, step->residual_px, sphere_us);
    set(FitMethod::sphere_one_step, fit);
  }
  const Stopwatch sphere_solver;
  if (const auto minimum = converge_cone(sphere.start, sphere.edges)) {
    auto fit = from_cone(camera, minimum->cone, radius_m);
    set_effort(fit, minimum->convergence.iterations, minimum->convergence.residual_px, sphere_solver.us());
    set(FitMethod::sphere_converged, fit);
  }
  return fits;
}

}  // namespace ballservo
