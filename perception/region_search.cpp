#include "perception/region_search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ballservo {
namespace {

constexpr int failures_per_region = 3, thorough_failures_per_region = 10, max_balls_per_region = 8;
// A disc of 12 px radius: a smaller one's edges before its own colour tell nothing (see outline_support).
constexpr double least_unexplained_px2 = M_PI * 12 * 12;

// Takes away what a circle explains, found to be a ball or not: of a ball also what lies inside its outline,
// as its terminator does. False where that is nothing.
bool take_away(const CircleEstimate& circle, const FittedBall* ball, double focal_px, RegionOutline& outline,
               std::vector<BoundaryPixel>* taken) {
  const double reach_px = 0.5 + outline_tolerance_px(circle.radius_px);
  const auto is_explained = [&](const BoundaryPoint& p) {
    const double outside_px = (p.position_px.cast<double>() - circle.center_px).norm() - circle.radius_px;
    if (!ball) return std::abs(outside_px) <= reach_px;
    return outside_px <= reach_px || angle_outside(ball->cone, ray_of(p, focal_px)) * focal_px <= reach_px;
  };
  std::size_t kept = 0;
  for (std::size_t i = 0; i < outline.points.size(); ++i) {
    if (is_explained(outline.points[i])) {
      if (taken) taken->push_back(outline.pixels[i]);
      continue;
    }
    outline.points[kept] = outline.points[i];
    outline.pixels[kept++] = outline.pixels[i];
  }
  const bool any = kept < outline.points.size();
  outline.resize(kept);
  return any;
}

}  // namespace

RegionSearch::RegionSearch(std::shared_ptr<const RayTable> rays, const DetectorOptions& options)
    : rays_(std::move(rays)), seed_(options.seed), verifier_(rays_, options) {}

void RegionSearch::find(const cv::Mat& bgr, const RegionMap& regions, int index, const cv::Point& window,
                        const CameraResponse& response, const RegionPrior& prior,
                        std::vector<BallObservation>& balls, DetectionStages* stages) {
  const Region& region = regions.regions()[static_cast<std::size_t>(index)];
  const ColoredPixels colored{region.color_class, regions.pixels_of(region.color_class), window};
  const ClassView view{bgr, colored, response, prior};
  const RegionOutline& outline = tracer_.trace(regions, index, window, *rays_);
  const std::size_t before = balls.size();
  const std::uint64_t place = (static_cast<std::uint64_t>(region.box.x + window.x) << 32) ^
                              (static_cast<std::uint64_t>(region.box.y + window.y) << 16) ^
                              static_cast<std::uint64_t>(region.pixels);
  RandomEngine engine = random_stream(seed_, "circle_vote", place);
  find_by_votes(view, outline, engine, balls, stages);
  // What is left may hide another one, if it is large enough for one to be told from it.
  double unexplained_px2 = region.pixels;
  for (std::size_t i = before; i < balls.size(); ++i)
    unexplained_px2 -= M_PI * balls[i].outline.radius_px * balls[i].outline.radius_px;
  if (unexplained_px2 > least_unexplained_px2) find_inside(view, outline, region, before, balls, stages);
}

void RegionSearch::find_by_votes(const ClassView& view, const RegionOutline& outline, RandomEngine& engine,
                                 std::vector<BallObservation>& balls, DetectionStages* stages) {
  unexplained_ = outline;
  int found = 0;
  const int most_failures = view.prior.thorough ? thorough_failures_per_region : failures_per_region;
  for (int failures = 0; failures < most_failures && found < max_balls_per_region;) {
    const auto vote = voter_.estimate(unexplained_.points, engine);
    if (!vote) return;
    const VotedCircle circle(*vote, rays_->camera().focal_px());
    const VerifiedCandidate& candidate =
        failures == 0 ? verifier_.verify_frayed(view, circle, unexplained_.points, outline.points)
                      : verifier_.verify(view, circle, unexplained_.points);
    show(view.colored.color_class, circle, candidate, stages);
    if (candidate.is_ball()) {
      balls.push_back(candidate.observation(view.colored.color_class, vote));
      ++found;
    } else {
      ++failures;
    }
    if (!take_away(*vote, candidate.is_ball() ? &candidate.fit.ball : nullptr, rays_->camera().focal_px(),
                   unexplained_, stages ? &stages->candidates.back().removed : nullptr))
      return;
  }
}

// By edges inside the region: a ball before a thing of its own colour.
void RegionSearch::find_inside(const ClassView& view, const RegionOutline& outline, const Region& region,
                               std::size_t first_known, std::vector<BallObservation>& balls,
                               DetectionStages* stages) {
  std::vector<BoundaryPoint>& boundary = unexplained_.points;
  boundary = outline.points;
  unexplained_.pixels.clear();
  inner_edges_.find(view.bgr, view.colored, *rays_, region.box + view.colored.window, region.pixels, inside_);
  // What lies on or inside a ball that was found, as its terminator does, is that ball's.
  const auto is_known = [&](const auto& edge) {
    return std::any_of(balls.begin() + static_cast<std::ptrdiff_t>(first_known), balls.end(),
                       [&](const BallObservation& ball) {
                         const Eigen::Vector2d at_px = edge.position_px.template cast<double>();
                         return (at_px - ball.start.center_px).norm() < 1.1 * ball.start.radius_px + 2;
                       });
  };
  while (static_cast<int>(balls.size() - first_known) < max_balls_per_region) {
    boundary.erase(std::remove_if(boundary.begin(), boundary.end(), is_known), boundary.end());
    inside_.erase(std::remove_if(inside_.begin(), inside_.end(), is_known), inside_.end());
    const InnerCircle* const inner = inner_circles_.find(view.bgr, rays_->camera(), boundary, inside_);
    if (!inner) return;
    const VotedCircle circle(inner->circle, rays_->camera().focal_px());
    const VerifiedCandidate& candidate = verifier_.verify(view, circle, inner->outline.points, true);
    show(view.colored.color_class, circle, candidate, stages);
    if (!candidate.is_ball()) return;
    balls.push_back(candidate.observation(view.colored.color_class, inner->circle));
  }
}

void RegionSearch::show(ClassIndex color_class, const VotedCircle& circle, const VerifiedCandidate& candidate,
                        DetectionStages* stages) const {
  if (!stages) return;
  const Camera& camera = rays_->camera();
  const auto outline_of = [&](const TangentCone& cone) {
    return project_outline(camera, cone.axis, std::sin(cone.alpha_rad), 128);
  };
  DetectionStages::Candidate& shown = stages->candidates.emplace_back();
  shown.color_class = color_class;
  shown.outline = unexplained_.pixels;
  shown.votes = voter_.histogram();
  shown.estimate = circle.estimate;
  shown.accepted = candidate.is_ball();
  shown.reason = shown.accepted ? "" : candidate.verdict.reason;
  shown.support = candidate.verdict.support;
  if (circle.cone) shown.estimate_outline_px = outline_of(*circle.cone);
  for (const RingPixel& pixel : candidate.fit.ring) shown.ring_px.emplace_back(pixel.u_px, pixel.v_px);
  for (const EdgePoint& edge : candidate.fit.edges.points) {
    if (const auto pixel = camera.project(edge.ray); pixel && edge.weight > 0)
      shown.ring_px.push_back(*pixel);
  }
  if (candidate.is_fitted) shown.refined_outline_px = outline_of(candidate.fit.ball.cone);
}

}  // namespace ballservo
