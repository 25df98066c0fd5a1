#include "perception/outline/ball_fitter.hpp"

#include <cmath>
#include <limits>

namespace ballservo {
namespace {

constexpr double long_step_px = 1;
constexpr int usual_passes = 2, most_passes = 4;
// Infinite where there is no step.
template <class Step>
double length_px(const std::optional<Step>& step) {
  return step ? step->step_px : std::numeric_limits<double>::infinity();
}

// Robust weights are never built on a scale finer than this: edges of a clean ball agree to a few hundredths.
constexpr double robust_floor_px = 0.06, settled_px = 1e-3;

}  // namespace

// Measured around the start and followed by one step; and again where that was not enough: it was long, so
// that the pixels were not those around the outline, or another would still move it. More often only while
// the steps are long.
bool BallFitter::fit_sphere(const cv::Mat& bgr, const CameraResponse& response, const TangentCone& start,
                            const BallRadius& radius, OutlineFit& fit, const KnownAngle& known) {
  fit.clear();
  FittedBall& ball = fit.ball;
  ball.cone = start;
  std::optional<ConeFit> step;
  fit.passes = 0;
  do {
    ++fit.passes;
    fit.edges_start = ball.cone;
    measure(bgr, response, ball.cone, fit.edges, known);
    step = one_gauss_newton_step(ball.cone, fit.edges.points, oval_fraction_, known);
    if (!step) return false;
    ball.cone = step->cone;
    ball.next_step_px = length_px(one_gauss_newton_step(ball.cone, fit.edges.points, oval_fraction_, known));
    ball.one_step_enough = step->step_px < long_step_px && ball.next_step_px <= enough_next_step_px;
  } while (!ball.one_step_enough && fit.passes < (step->step_px > long_step_px ? most_passes : usual_passes));
  ball.cone_covariance_rad2 = step->covariance_rad2;
  ball.residual_px = step->residual_px;
  ball.step_px = step->step_px;
  ball.blur_px = fit.edges.blur_px;
  fit.oval = step->oval_rad.norm() / step->cone.alpha_rad;
  fit.offsets = edge_offsets(fit.edges, *step);
  if (radius.radius_m > 0)
    ball.position = {step->cone.center(radius.radius_m),
                     center_covariance(*step, radius.radius_m, radius.sigma_m)};
  const double focal_px = rays_->camera().focal_px();
  return finish({focal_px / start.axis.z() * start.axis.head<2>(), focal_px * std::tan(start.alpha_rad)},
                fit);
}

bool BallFitter::fit_circle(const cv::Mat& bgr, const UndistortedCircle& start, const BallRadius& radius,
                            OutlineFit& fit) const {
  fit.clear();
  FittedBall& ball = fit.ball;
  select_ring_pixels(bgr, *rays_, start, fit.ring);
  const auto step = one_gauss_newton_step(start, fit.ring);
  if (!step) return false;
  const double focal_px = rays_->camera().focal_px();
  const auto cone = cone_near_circle(step->circle, focal_px);
  if (!cone) return false;
  ball.cone = *cone;
  // Where the circle is small against the focal length, its centre and radius are the cone's turns and angle.
  ball.cone_covariance_rad2 = step->covariance_px2 / (focal_px * focal_px);
  ball.residual_px = step->residual_px;
  ball.step_px = step->step_px;
  ball.next_step_px = length_px(one_gauss_newton_step(step->circle, fit.ring));
  ball.one_step_enough = ball.next_step_px <= enough_next_step_px;  // said only: the paper's fit is one step
  if (radius.radius_m > 0) {
    const Eigen::Matrix3d jacobian = paper_position_jacobian(step->circle, focal_px, radius.radius_m);
    const Eigen::Vector3d p_C = paper_position(step->circle, focal_px, radius.radius_m);
    const Eigen::Vector3d by_radius = p_C / radius.radius_m * radius.sigma_m;
    ball.position = {
        p_C, jacobian * step->covariance_px2 * jacobian.transpose() + by_radius * by_radius.transpose()};
  }
  return finish(start, fit);
}

void BallFitter::admit(const CameraResponse& other, double probability, const cv::Mat& bgr,
                       const BallRadius& radius, FittedBall& ball) {
  measure(bgr, other, ball.cone, evident_edges_);
  const auto there = one_gauss_newton_step(ball.cone, evident_edges_.points, oval_fraction_);
  if (!there) return;
  Eigen::Vector3d away_rad;
  away_rad << perpendicular_basis(ball.cone.axis).transpose() * there->cone.axis,
      there->cone.alpha_rad - ball.cone.alpha_rad;
  ball.cone_covariance_rad2 += probability * away_rad * away_rad.transpose();
  if (!ball.position) return;
  const Eigen::Vector3d away_m = there->cone.center(radius.radius_m) - ball.position->p_C;
  ball.position->covariance_m2 += probability * away_m * away_m.transpose();
}

// With what both fits share.
bool BallFitter::finish(const UndistortedCircle& start, OutlineFit& fit) const {
  const TangentCone& cone = fit.ball.cone;
  const auto outline = project_sphere(rays_->camera(), cone.axis, std::sin(cone.alpha_rad));
  if (!outline) return false;
  fit.ball.outline = *outline;
  fit.ball.start = start;
  return true;
}

// The edges around a cone, and how far each is believed.
void BallFitter::measure(const cv::Mat& bgr, const CameraResponse& response, const TangentCone& cone,
                         OutlineEdges& edges, const KnownAngle& known) {
  edge_meter_.measure(bgr, *rays_, cone, response, edges);
  robust_weights_.set(cone, edges.points, robust_floor_px, oval_fraction_, settled_px, known);
}

// The edges are sought where one response puts them, and texture beside them may speak against it by chance:
// what does is asked again where the other one puts them. That counts as far as it still contradicts.
ResponseEvidence BallFitter::response_evidence(const cv::Mat& bgr, const CameraResponse& response,
                                               const TangentCone& cone) {
  measure(bgr, response, cone, evident_edges_);
  ResponseEvidence evidence = edge_meter_.evidence(bgr, *rays_, cone, evident_edges_.points);
  const bool coarse = response.coarse_chroma, is_srgb = &response == &CameraResponse::srgb(coarse);
  if (is_srgb ? evidence.srgb >= 0 : evidence.srgb <= 0) return evidence;
  measure(bgr, is_srgb ? CameraResponse::linear(coarse) : CameraResponse::srgb(coarse), cone, evident_edges_);
  const auto step = one_gauss_newton_step(cone, evident_edges_.points, oval_fraction_);
  if (!step) return evidence;
  const double again = edge_meter_.evidence(bgr, *rays_, step->cone, evident_edges_.points).srgb;
  evidence.srgb = is_srgb ? std::min(again, 0.0) : std::max(again, 0.0);
  return evidence;
}

}  // namespace ballservo
