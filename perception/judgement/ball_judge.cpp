#include "perception/judgement/ball_judge.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/judgement/ball_shading.hpp"
#include "perception/judgement/occluding_edge.hpp"

namespace ballservo {
namespace {

constexpr double min_arc = 0.3;    // of the outline must have an edge on it
constexpr double min_fill = 0.25;  // of the disc must have the ball's colour
// Some circle fits into a few pixels of anything: of the rim of a ball smaller than this less may have its
// colour.
constexpr double small_radius_px = 5, max_small_leak = 0.1;
// Where more of the outline than this is hidden, what is seen must be shaded as a sphere is, so strongly (a
// part of the mean brightness). A half-hidden disc is flat.
constexpr double max_hidden = 0.45, min_shading = 0.4, min_lighter_shading = 1;
constexpr double min_shading_explained = 0.95;  // of it, by a sphere
// Or what hides it must be seen to go on beyond it; a chord of a few pixels shows no line, and what is seen
// must be round: of the pictures that we have, balls are by 1, what is none by half of it.
constexpr double least_hidden_radius_px = 12, least_round = 0.75;
// But where an edge follows so much of the outline in the picture, nothing hides the rest.
constexpr double min_whole = 0.9;
// Of the disc of a ball that encloses its region, so much and no more has the colour.
constexpr double min_enclosed_fill = 0.35, max_enclosed_fill = 0.6;
constexpr double min_enclosing_edge = 0.5;  // and on so much of its outline an edge lies
constexpr double min_expected_fill = 0.4;
// An edge that is straight, or in many short pieces, is another thing's even where a ball is expected.
constexpr double least_expected_quality = 0.05;

constexpr const char* too_weak = "outline and colour together are too weak";

}  // namespace

double log_look_alikes_by_size(double radius_px) {
  return 3 * std::log(std::max(1.0, small_ball_px / radius_px));
}

Verdict BallJudge::early(const std::vector<BoundaryPoint>& boundary, const TangentCone& cone) const {
  const Camera& camera = rays_.camera();
  OutlineSectors sectors = boundary_sectors(boundary, cone, camera.focal_px());
  see_steps_in_own_color(view_.bgr, view_.colored, camera, cone, sectors);
  EdgeOffsets offsets(sectors.count);
  for (int i = 0; i < offsets.count; ++i)
    offsets[i] = sectors[i] ? 0 : std::numeric_limits<float>::quiet_NaN();
  const OutlineSupport support = outline_support(sectors, offsets, 0, view_.colored, camera, cone);
  const double quality = support.quality();
  const auto reason = [&]() -> const char* {
    if (support.arc < 0.6 * min_arc) return "the region's outline follows no circle";
    // The circle that fits into a box: touched in short arcs, with the colour all around or all inside.
    if (support.arc_in_runs == 0 && (support.leak > 0.25 || (support.arc < 0.4 && support.fill > 0.9)))
      return "the region's outline follows no circle";
    if (support.fill < 0.8 * min_fill) return "too little of the disc has the colour";
    if (support.leak > max_leak + 0.1) return "the colour runs on around it";
    return quality < 0.75 * view_.prior.min_quality ? too_weak : nullptr;
  };
  return {support, quality, reason()};
}

Verdict BallJudge::of(const OutlineFit& fit, const std::vector<BoundaryPoint>& boundary) const {
  const Camera& camera = rays_.camera();
  const FittedBall& ball = fit.ball;
  const OutlineSectors sectors = fit.has_edges()
                                     ? edge_sectors(fit.offsets, outline_tolerance_px(ball.start.radius_px))
                                     : boundary_sectors(boundary, ball.cone, camera.focal_px());
  Verdict verdict;
  verdict.support = outline_support(sectors, fit.offsets, ball.blur_px, view_.colored, camera, ball.cone);
  verdict.quality = verdict.support.quality();
  const double hidden = verdict.support.hidden;
  const bool behind_something = hidden > max_hidden && hidden < 1 && fit.has_edges() &&
                                ball.outline.radius_px >= least_hidden_radius_px &&
                                verdict.support.shape.roundness() >= least_round &&
                                is_behind_straight_edge(view_.bgr, view_.colored, ball.outline);
  // Of what can be seen of it.
  if (behind_something) verdict.quality /= std::sqrt(1 - hidden);
  verdict.reason = rejection(fit, verdict, behind_something);
  return verdict;
}

const char* BallJudge::rejection(const OutlineFit& fit, const Verdict& verdict, bool behind_something) const {
  const double radius_px = fit.ball.outline.radius_px;
  const OutlineSupport& support = verdict.support;
  if (radius_px < min_ball_radius_px) return "too small";
  if (support.arc < min_arc) return "too little of the outline has an edge";
  if (support.fill < min_fill) return "too little of the disc has the colour";
  if (support.leak > (radius_px < small_radius_px ? max_small_leak : max_leak))
    return "the colour runs on around it";
  if (verdict.quality < view_.prior.min_quality) return too_weak;
  return shows_a_sphere(fit, support, behind_something)
             ? nullptr
             : "half of it is hidden, and the rest is not shaded as a sphere";
}

// Half a disc looks like a half-hidden ball, but for its shading. A ball half in shade, or cut by the
// picture, has its edge all around in the picture even so. What hides a ball shades it too: where that is
// seen, a ball's shading need not be a sphere's alone.
bool BallJudge::shows_a_sphere(const OutlineFit& fit, const OutlineSupport& support,
                               bool behind_something) const {
  if (support.hidden <= max_hidden) return true;
  if (fit.has_edges() && share_on_outline(fit) >= min_whole) return true;
  const BallShading shading =
      ball_shading(view_.bgr, view_.response, view_.colored, rays_, fit.ball.cone, fit.ball.outline);
  if (shading.strength < min_shading) return false;
  if (behind_something && shading.strength_of_lighter >= min_lighter_shading) return true;
  return shading.explained >= min_shading_explained && shading.explained > shading.explained_by_two;
}

bool BallJudge::encloses(const std::vector<BoundaryPoint>& region, const OutlineFit& fit,
                         const OutlineSupport& support) const {
  if (support.fill < min_enclosed_fill || support.fill > max_enclosed_fill ||
      share_on_outline(fit) < min_enclosing_edge)
    return false;
  const double focal_px = rays_.camera().focal_px();
  const double reach_px = outline_tolerance_px(fit.ball.outline.radius_px);
  const auto enclosed = std::count_if(region.begin(), region.end(), [&](const BoundaryPoint& point) {
    return angle_outside(fit.ball.cone, ray_of(point, focal_px)) * focal_px <= reach_px;
  });
  return static_cast<double>(enclosed) >= 0.95 * static_cast<double>(region.size());
}

bool BallJudge::suffices_where_expected(const OutlineFit& fit, const OutlineSupport& support) const {
  return support.fill >= min_expected_fill && support.leak <= max_leak &&
         support.quality() >= least_expected_quality && share_on_outline(fit) >= min_expected_edge;
}

// What hides a ball takes its colour and much of its contour, so that to miss these says little against it.
// What is left must be a circle's, with an edge all along it, behind an edge that goes on; not flat; and what
// hides it no ground that goes on around it. The weights are a logistic regression's over photographs with
// and without balls half behind sheets and fruit; those of one half of the photographs do as well on the
// other half.
double BallJudge::half_hidden_log_odds(const OutlineFit& fit, const OutlineSupport& support,
                                       const SecondLook::Look& look) const {
  constexpr double least_sphere = 0.1, least_hidden_by = 0.3;
  if (look.seen.sphere() < least_sphere || look.seen.hidden_by < least_hidden_by)
    return -std::numeric_limits<double>::infinity();
  const OutlineEllipse& outline = fit.ball.outline;
  const double seen = support.arc / std::max(0.2, 1 - support.hidden);
  const double behind = is_behind_straight_edge(view_.bgr, view_.colored, outline) ? 1 : 0;
  const double contrast = std::log(std::max(1.0, look.seen.edge) / 12);
  return 2.7 * seen + 2 * support.shape.roundness() + 2.2 * behind + contrast +
         2.4 * std::clamp(look.seen.contour, -0.5, 1.2) + 0.5 * look.seen.sphere() -
         0.8 * view_.prior.log_look_alikes - log_look_alikes_by_size(outline.radius_px) - 6.4;
}

double share_on_outline(const OutlineFit& fit) {
  int on_outline = 0;
  for (int i = 0; i < fit.offsets.count; ++i)
    on_outline += is_on_outline(fit.offsets[i], fit.ball.outline.radius_px, fit.ball.blur_px) ? 1 : 0;
  return on_outline / std::max(1.0, static_cast<double>(fit.edges.segments_in_picture));
}

}  // namespace ballservo
