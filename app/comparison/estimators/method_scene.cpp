#include "app/comparison/estimators/method_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/comparison/estimators/stopwatch.hpp"
#include "calibration/base/statistics.hpp"
#include "perception/outline/paper_refinement.hpp"

namespace ballservo {
namespace {

// A circle of the undistorted picture as it appears in the picture as given: centroid and sqrt(area / pi) of
// its image, which for a pinhole camera of square pixels is the circle itself.
std::optional<OutlineEllipse> circle_in_picture(const Camera& camera, const UndistortedCircle& circle) {
  constexpr int count = 256;
  std::array<Eigen::Vector2d, count> points;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * M_PI * k / count;
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
  const double share = std::sin(2 * M_PI / count) / (2 * M_PI / count);
  return OutlineEllipse{origin + moment / (3 * twice_area), std::sqrt(twice_area / 2 / share / M_PI)};
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

}  // namespace

MethodScene::MethodScene(const cv::Mat& bgr, const DetectorSetup& setup, const MethodTask& task)
    : bgr_(bgr),
      setup_(setup),
      detector_(setup.rays, setup.colors, setup.options),
      task_(task),
      radius_m_(detector_.options().radius_of(task.color_class).radius_m),
      start_(task.start) {
  DetectionStages stages;
  const Stopwatch detection;
  const std::vector<BallObservation>& balls = detector_.detect(bgr, {}, &stages);
  cost_us_[MethodPoints::detection] = detection.us();
  // The best of the class, or the one that is meant.
  const auto distance = [&](const BallObservation& b) {
    return task.near_px ? (b.outline.center_px - *task.near_px).norm() : 0;
  };
  const BallObservation* ball = nullptr;
  for (const BallObservation& seen : balls) {
    if (seen.color_class == task.color_class && (!ball || distance(seen) < distance(*ball))) ball = &seen;
  }
  if (!ball) return;
  vote_ = ball->vote;
  if (start_ || !vote_) return;
  start_ = UndistortedCircle{vote_->center_px, vote_->radius_px};
  boundary_ = boundary_of(rays(), stages, *vote_);
}

const std::vector<RingPixel>& MethodScene::ring() {
  prepare(MethodPoints::ring);
  return ring_;
}

const std::optional<MethodScene::Edges>& MethodScene::edges() {
  prepare(MethodPoints::edges);
  return edges_;
}

double MethodScene::shared_us(MethodPoints points) const {
  const auto cost = cost_us_.find(points);
  return cost == cost_us_.end() ? 0 : cost->second;
}

void MethodScene::prepare(MethodPoints points) {
  if (points == MethodPoints::sphere_detector) whole_detector(BallFit::sphere);
  if (points == MethodPoints::paper_detector) whole_detector(BallFit::paper);
  if (cost_us_.count(points) > 0 || !start_) return;
  const Stopwatch choice;
  if (points == MethodPoints::ring) {
    select_ring_pixels(bgr_, rays(), *start_, ring_);
    cost_us_[points] = choice.us();
  } else if (points == MethodPoints::edges) {
    OutlineFit fit;
    detector_.fit_sphere(bgr_, *start_, boundary_, fit);
    cost_us_[points] = choice.us();
    if (!fit.edges.points.empty()) edges_ = Edges{fit.edges_start, std::move(fit.edges.points), fit.passes};
  }
}

Detector& MethodScene::whole_detector(BallFit fit) {
  const auto known = whole_.find(fit);
  if (known != whole_.end()) return known->second;
  DetectorOptions options = setup_.options;
  options.fit = fit;
  Detector& made = whole_.try_emplace(fit, setup_.rays, setup_.colors, options).first->second;
  for (const cv::Mat& bgr : setup_.seen_before) made.detect(bgr);
  return made;
}

std::vector<MethodFit> MethodScene::detections(BallFit fit) {
  std::vector<MethodFit> fits;
  for (const BallObservation& ball : whole_detector(fit).detect(bgr_)) {
    if (ball.color_class != task_.color_class) continue;
    MethodFit found = answer(ball.outline, ball.position ? ball.position->p_C : Eigen::Vector3d(0, 0, 0));
    if (ball.position) found.covariance_m2 = ball.position->covariance_m2;
    found.residual_px = ball.residual_px;
    found.step_px = ball.step_px;
    found.next_step_px = ball.next_step_px;
    found.arc = ball.support.arc;
    fits.push_back(found);
  }
  return fits;
}

MethodFit MethodScene::answer(const OutlineEllipse& outline, const Eigen::Vector3d& p_C) const {
  MethodFit fit;
  fit.outline = outline;
  fit.p_C = p_C;
  // A ball of unknown diameter may stand anywhere along its ray.
  if (!(radius_m_ > 0)) fit.p_C.setConstant(not_known);
  return fit;
}

std::optional<MethodFit> MethodScene::answer(const UndistortedCircle& circle) const {
  const auto outline = circle_in_picture(camera(), circle);
  if (!outline) return std::nullopt;
  return answer(*outline, paper_position(circle, camera().focal_px(), radius_m_));
}

std::optional<MethodFit> MethodScene::answer(const TangentCone& cone) const {
  const auto outline = project_sphere(camera(), cone.axis, std::sin(cone.alpha_rad));
  if (!outline) return std::nullopt;
  return answer(*outline, cone.center(radius_m_));
}

std::optional<MethodFit> MethodScene::answer(const OutlineEllipse& circle) const {
  const auto undistorted = undistorted_circle(camera(), circle);
  if (!undistorted) return std::nullopt;
  return answer(circle, paper_position(*undistorted, camera().focal_px(), radius_m_));
}

std::optional<UndistortedCircle> undistorted_circle(const Camera& camera, const OutlineEllipse& circle) {
  constexpr int count = 32;
  const double focal_px = camera.focal_px();
  std::array<Eigen::Vector2d, count> points;
  UndistortedCircle undistorted;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * M_PI * k / count;
    const auto ray = camera.unproject(circle.center_px +
                                      circle.radius_px * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    if (!ray || !(ray->z() > 0)) return std::nullopt;
    points[static_cast<std::size_t>(k)] = focal_px * ray->head<2>() / ray->z();
    undistorted.center_px += points[static_cast<std::size_t>(k)] / count;
  }
  for (const Eigen::Vector2d& point : points)
    undistorted.radius_px += (point - undistorted.center_px).norm() / count;
  return undistorted;
}

}  // namespace ballservo
