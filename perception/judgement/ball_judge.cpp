#include "perception/judgement/ball_judge.hpp"

#include <algorithm>
#include <limits>

#include "perception/judgement/ball_shading.hpp"
#include "perception/judgement/outline_steps.hpp"

namespace ballservo {
namespace {

constexpr double min_arc = 0.3;        // of the outline must have an edge on it
constexpr double min_fill = 0.25;      // of the disc must have the ball's colour
constexpr double small_radius_px = 5;  // below, max_small_leak counts
// Where more of the outline than this is hidden, what is seen must be shaded as a sphere is, so strongly (a
// part of the mean brightness). A half-hidden disc is flat.
constexpr double max_hidden = 0.45, min_shading = 0.4;
// But where an edge follows so much of the outline in the picture, nothing hides the rest.
constexpr double min_whole = 0.9;
// Of the disc of a ball that encloses its region, so much and no more has the colour.
constexpr double min_enclosed_fill = 0.35, max_enclosed_fill = 0.6;
constexpr double min_expected_fill = 0.4;

constexpr const char* too_weak = "outline and colour together are too weak";

}  // namespace

OutlineSupport BallJudge::early_support(const std::vector<BoundaryPoint>& boundary,
                                        const TangentCone& cone) const {
  const Camera& camera = rays_.camera();
  OutlineSectors sectors = boundary_sectors(boundary, cone, camera.focal_px());
  see_steps_in_own_color(bgr_, colored_, camera, cone, sectors);
  EdgeOffsets offsets;
  offsets.count = sectors.count;
  for (int i = 0; i < offsets.count; ++i) {
    const bool seen = sectors.seen[static_cast<std::size_t>(i)];
    offsets[i] = seen ? 0 : std::numeric_limits<float>::quiet_NaN();
  }
  return outline_support(sectors, offsets, 0, colored_, camera, cone);
}

const char* BallJudge::early_rejection(const OutlineSupport& support) const {
  if (support.arc < 0.6 * min_arc) return "the region's outline follows no circle";
  // The circle that fits into a box: touched in short stretches, with the colour all around or all inside.
  if (support.arc_in_runs == 0 && (support.leak > 0.25 || (support.arc < 0.4 && support.fill > 0.9)))
    return "the region's outline follows no circle";
  if (support.fill < 0.8 * min_fill) return "too little of the disc has the colour";
  if (support.leak > options_.max_leak + 0.1) return "the colour runs on around it";
  return support.quality() < 0.75 * min_quality_ ? too_weak : nullptr;
}

const char* BallJudge::rejection(const std::vector<BoundaryPoint>& boundary, BallObservation& ball) const {
  const Camera& camera = rays_.camera();
  // The paper's fit measures no edges.
  const bool with_edges = options_.fit == BallFit::sphere;
  const OutlineSectors sectors =
      with_edges ? edge_sectors(fitter_.offsets(), outline_tolerance_px(ball.start.radius_px))
                 : boundary_sectors(boundary, ball.cone, camera.focal_px());
  const EdgeOffsets offsets = with_edges ? fitter_.offsets() : EdgeOffsets{};
  ball.support = outline_support(sectors, offsets, ball.blur_px, colored_, camera, ball.cone);
  ball.quality = ball.support.quality();
  if (const char* reason = rejection_by_support(ball)) return reason;
  return shows_a_sphere(ball) ? nullptr : "half of it is hidden, and the rest is not shaded as a sphere";
}

const char* BallJudge::rejection_by_support(const BallObservation& ball) const {
  if (ball.outline.radius_px < options_.min_radius_px) return "too small";
  if (ball.support.arc < min_arc) return "too little of the outline has an edge";
  if (ball.support.fill < min_fill) return "too little of the disc has the colour";
  const bool is_small = ball.outline.radius_px < small_radius_px;
  if (ball.support.leak > (is_small ? options_.max_small_leak : options_.max_leak))
    return "the colour runs on around it";
  return ball.quality < min_quality_ ? too_weak : nullptr;
}

// Half a disc looks like a half-hidden ball, but for its shading. A ball half in shade, or cut by the
// picture, has its edge all around in the picture even so.
bool BallJudge::shows_a_sphere(const BallObservation& ball) const {
  if (ball.support.hidden <= max_hidden) return true;
  if (options_.fit == BallFit::sphere && share_on_outline(ball) >= min_whole) return true;
  const BallShading shading =
      ball_shading(bgr_, fitter_.response(), colored_, rays_, ball.cone, ball.outline);
  return shading.strength >= min_shading && shading.explained >= options_.min_shading_explained &&
         shading.explained > shading.explained_by_two;
}

bool BallJudge::encloses(const std::vector<BoundaryPoint>& region, const BallObservation& ball) const {
  if (ball.support.fill < min_enclosed_fill || ball.support.fill > max_enclosed_fill ||
      share_on_outline(ball) < options_.min_enclosing_edge)
    return false;
  const double focal_px = rays_.camera().focal_px();
  const double reach_px = outline_tolerance_px(ball.outline.radius_px);
  const auto enclosed = std::count_if(region.begin(), region.end(), [&](const BoundaryPoint& point) {
    return angle_outside(ball.cone, ray_of(point, focal_px)) * focal_px <= reach_px;
  });
  return static_cast<double>(enclosed) >= 0.95 * static_cast<double>(region.size());
}

bool BallJudge::suffices_where_expected(const BallObservation& ball) const {
  return ball.support.fill >= min_expected_fill && ball.support.leak <= options_.max_leak &&
         share_on_outline(ball) >= options_.min_expected_edge;
}

double BallJudge::share_on_outline(const BallObservation& ball) const {
  const EdgeOffsets& offsets = fitter_.offsets();
  int on_outline = 0;
  for (int i = 0; i < offsets.count; ++i)
    on_outline += is_on_outline(offsets[i], ball.outline.radius_px, ball.blur_px) ? 1 : 0;
  return on_outline / std::max(1.0, static_cast<double>(fitter_.edges().stretches_in_picture));
}

}  // namespace ballservo
