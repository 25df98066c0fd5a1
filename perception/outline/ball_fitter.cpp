#include "perception/outline/ball_fitter.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "perception/outline/ball_position.hpp"

namespace ballservo {
namespace {

constexpr double long_step_px = 1;
// Length of the step that would follow; infinite where there is none.
template <class Start, class Points, class... More>
double following_step_px(const Start& start, const Points& points, More... more) {
  const auto next = one_gauss_newton_step(start, points, more...);
  return next ? next->step_px : std::numeric_limits<double>::infinity();
}

// Robust weights are never built on a scale finer than this: edges of a clean ball agree to a few hundredths.
constexpr double robust_floor_px = 0.06;

}  // namespace

BallFitter::BallFitter(std::shared_ptr<const RayTable> rays, const DetectorOptions& options)
    : rays_(std::move(rays)), options_(options), edge_meter_(options.edges) {}

std::optional<BallObservation> BallFitter::refine(const cv::Mat& bgr, ClassIndex color_class,
                                                  const CircleEstimate& vote, const TangentCone& voted,
                                                  const std::vector<BoundaryPoint>& boundary, BallFit fit,
                                                  RefinementInput* input) {
  const UndistortedCircle circle{vote.center_px, vote.radius_px};
  const auto fitted = [&] {
    if (fit == BallFit::paper) return refine_paper(bgr, color_class, circle, input);
    const TangentCone start =
        boundary_cone_.robust(voted, boundary, rays_->camera().focal_px(), options_.oval_fraction)
            .value_or(voted);
    return refine_sphere(bgr, color_class, start, input);
  };
  auto ball = finished(fitted(), color_class, circle);
  if (ball) ball->vote = vote;
  return ball;
}

std::optional<BallObservation> BallFitter::refine(const cv::Mat& bgr, ClassIndex color_class,
                                                  const TangentCone& start, RefinementInput* input) {
  const double focal_px = rays_->camera().focal_px();
  const UndistortedCircle circle{focal_px / start.axis.z() * start.axis.head<2>(),
                                 focal_px * std::tan(start.alpha_rad)};
  return finished(refine_sphere(bgr, color_class, start, input), color_class, circle);
}

// With what all fits share.
std::optional<BallObservation> BallFitter::finished(std::optional<BallObservation> ball,
                                                    ClassIndex color_class,
                                                    const UndistortedCircle& start) const {
  if (!ball) return std::nullopt;
  const auto outline = project_sphere(rays_->camera(), ball->cone.axis, std::sin(ball->cone.alpha_rad));
  if (!outline) return std::nullopt;
  ball->outline = *outline;
  ball->color_class = color_class;
  ball->start = start;
  return ball;
}

// Measured around the start and followed by one step; and once more where that was not enough: it was long,
// so that the pixels were not those around the outline, or another would still move it.
std::optional<BallObservation> BallFitter::refine_sphere(const cv::Mat& bgr, ClassIndex color_class,
                                                         TangentCone cone, RefinementInput* input) {
  std::optional<ConeFit> fit;
  double next_step_px = 0;
  bool enough = false;
  for (int pass = 0; pass < 2 && !enough; ++pass) {
    measure(bgr, cone);
    if (input) {
      input->start = cone;
      input->edges = edges_.points;
      input->passes = pass + 1;
    }
    fit = one_gauss_newton_step(cone, edges_.points, options_.oval_fraction);
    if (!fit) return std::nullopt;
    cone = fit->cone;
    next_step_px = following_step_px(cone, edges_.points, options_.oval_fraction);
    enough = fit->step_px < long_step_px && next_step_px <= enough_next_step_px;
  }
  BallObservation ball;
  ball.cone = cone;
  ball.cone_covariance_rad2 = fit->covariance_rad2;
  ball.residual_px = fit->residual_px;
  ball.step_px = fit->step_px;
  ball.next_step_px = next_step_px;
  ball.one_step_enough = enough;
  ball.blur_px = edges_.blur_px;
  offsets_ = edge_offsets(edges_, *fit);
  ball.position = position(color_class, *fit);
  return ball;
}

std::optional<BallObservation> BallFitter::refine_paper(const cv::Mat& bgr, ClassIndex color_class,
                                                        const UndistortedCircle& circle,
                                                        RefinementInput* input) {
  select_ring_pixels(bgr, *rays_, circle, options_.ring, ring_);
  if (input) input->ring = ring_;
  const auto fit = one_gauss_newton_step(circle, ring_);
  if (!fit) return std::nullopt;
  const double focal_px = rays_->camera().focal_px();
  const auto cone = cone_near_circle(fit->circle, focal_px);
  if (!cone) return std::nullopt;
  BallObservation ball;
  ball.cone = *cone;
  // Where the circle is small against the focal length, its centre and radius are the cone's turns and angle.
  ball.cone_covariance_rad2 = fit->covariance_px2 / (focal_px * focal_px);
  ball.residual_px = fit->residual_px;
  ball.step_px = fit->step_px;
  ball.next_step_px = following_step_px(fit->circle, ring_);
  ball.one_step_enough = ball.next_step_px <= enough_next_step_px;  // said only: the paper's fit is one step
  if (const BallRadius radius = radius_of(color_class); radius.radius_m > 0) {
    const Eigen::Matrix3d jacobian = paper_position_jacobian(fit->circle, focal_px, radius.radius_m);
    BallPosition position;
    position.p_C = paper_position(fit->circle, focal_px, radius.radius_m);
    const Eigen::Vector3d by_radius = position.p_C / radius.radius_m * radius.sigma_m;
    position.covariance_m2 =
        jacobian * fit->covariance_px2 * jacobian.transpose() + by_radius * by_radius.transpose();
    ball.position = position;
  }
  return ball;
}

// The edges around a cone, and how far each is believed.
void BallFitter::measure(const cv::Mat& bgr, const TangentCone& cone) {
  edge_meter_.measure(bgr, *rays_, cone, response(), edges_);
  robust_weights_.set(cone, edges_.points, robust_floor_px, options_.oval_fraction);
}

std::optional<BallPosition> BallFitter::position(ClassIndex color_class, const ConeFit& fit) const {
  const BallRadius radius = radius_of(color_class);
  if (!(radius.radius_m > 0)) return std::nullopt;
  return BallPosition{fit.cone.center(radius.radius_m),
                      center_covariance(fit, radius.radius_m, radius.sigma_m)};
}

BallRadius BallFitter::radius_of(ClassIndex color_class) const {
  const std::size_t index = static_cast<std::size_t>(color_class) - 1;
  return color_class != no_class && index < options_.radii.size() ? options_.radii[index] : BallRadius{};
}

const CameraResponse& BallFitter::response() const {
  switch (options_.response) {
    case ResponseChoice::linear:
      return CameraResponse::linear();
    case ResponseChoice::srgb:
      return CameraResponse::srgb();
    case ResponseChoice::by_edges:
      break;
  }
  return belief_.likelier();
}

bool BallFitter::learn_response(const cv::Mat& bgr, const std::vector<BallObservation>& balls) {
  if (options_.response != ResponseChoice::by_edges || options_.fit != BallFit::sphere) return false;
  const CameraResponse& before = response();
  for (const BallObservation& ball : balls) {
    if (!belief_.open()) break;
    measure(bgr, ball.cone);
    belief_.add(edge_meter_.evidence(bgr, *rays_, ball.cone, edges_.points, CameraResponse::srgb(),
                                     CameraResponse::linear()));
  }
  return &response() != &before;
}

}  // namespace ballservo
