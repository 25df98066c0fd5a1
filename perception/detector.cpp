#include "perception/detector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "calibration/files/fault.hpp"
#include "perception/ball_position.hpp"
#include "perception/ball_shading.hpp"
#include "perception/classification.hpp"
#include "perception/outline_steps.hpp"
#include "perception/region_shape.hpp"

namespace ballservo {
namespace {

constexpr int worth_sharing_px = 100000;  // below, threads cost more to wake than they save
constexpr int failures_per_region = 3;
constexpr std::size_t max_boundary_points = 256;
// A disc of 12 px radius: a smaller one's edges before its own colour tell nothing (see outline_support).
constexpr double least_unexplained_px2 = M_PI * 12 * 12;

// Rings of starts around an expected ball, so that each place within the spread is in reach of one.
int rings_over(double spread_px, double reach_px) {
  constexpr double most = 3;
  const double rings = std::ceil(spread_px / (2 * reach_px));
  return rings > 0 ? static_cast<int>(std::min(rings, most)) : 0;
}

}  // namespace

Detector::Detector(std::shared_ptr<const RayTable> rays, std::shared_ptr<const ColorTable> colors,
                   const DetectorOptions& options)
    : rays_(std::move(rays)),
      colors_(std::move(colors)),
      options_(options),
      regions_(options.max_runs),
      voter_(options.vote),
      fitter_(rays_, options) {
  scouted_.points.reserve(most_outline_sectors);
  options_.validate();
  if (options_.threads > 1) team_ = std::make_unique<RowTeam>(options_.threads);
}

const std::vector<BallObservation>& Detector::detect(const cv::Mat& bgr, cv::Rect window,
                                                     DetectionStages* stages) {
  check(bgr);
  balls_.clear();
  left_out_ = {};
  const cv::Rect everywhere({0, 0}, bgr.size());
  if (window.empty()) window = everywhere;
  window &= everywhere;
  if (window.empty()) return balls_;

  segment(bgr, window);
  if (stages) {
    const auto numbers = [&](const ClassPictures& classes) { return class_numbers(classes, window.size()); };
    *stages = {window, numbers(classified_), numbers(opened_), numbers(closed_), {}};
  }
  regions_.update(closed_, window.size());
  left_out_.shorter_px = regions_.shortest_run_px() > 1 ? regions_.shortest_run_px() : 0;
  left_out_.regions = choose_regions(regions_.regions(), 2 * options_.min_radius_px * options_.min_radius_px,
                                     options_.max_regions, chosen_);
  find_balls(bgr, window, stages);
  if (fitter_.learn_response(bgr, balls_)) find_balls(bgr, window, stages);
  return balls_;
}

std::optional<BallObservation> Detector::find_expected(
    const cv::Mat& bgr, const cv::Rect& window, const ExpectedBall& expected, bool clearly,
    const std::function<bool(const BallObservation&)>& may_be) {
  check(bgr);
  if (options_.fit != BallFit::sphere) return std::nullopt;
  const cv::Rect seen = window & cv::Rect({0, 0}, bgr.size());
  if (seen.empty()) return std::nullopt;
  segment(bgr, seen);
  if (expected.color_class == no_class || expected.color_class > closed_.size()) return std::nullopt;
  const ColoredPixels colored{expected.color_class, closed_[expected.color_class - 1u], seen.tl()};
  const int rings = rings_over(expected.spread_px, expected.reach_px);
  const double spacing_rad = expected.spread_px / std::max(1, rings) / rays_->camera().focal_px();
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(expected.cone.axis);
  std::optional<BallObservation> clearest;
  for (int down = -rings; down <= rings; ++down) {
    for (int right = -rings; right <= rings; ++right) {
      TangentCone start = expected.cone;
      if (rings > 0)
        start.axis = (start.axis + basis * Eigen::Vector2d(right, down) * spacing_rad).normalized();
      const auto ball = find_from(bgr, colored, start, expected.reach_px, clearly);
      if (ball && may_be(*ball) && (!clearest || ball->quality > clearest->quality)) clearest = ball;
    }
  }
  return clearest;
}

// The ball whose outline is near the cone's; not clearly: also where it shows less of itself than another
// must.
std::optional<BallObservation> Detector::find_from(const cv::Mat& bgr, const ColoredPixels& colored,
                                                   const TangentCone& start, double reach_px, bool clearly) {
  const Candidate candidate =
      judge_scouted(bgr, colored, start, reach_px,
                    clearly ? options_.min_frayed_edge : options_.min_expected_edge, nullptr);
  if (!candidate.reason) return candidate.ball;
  const bool is_there = !clearly && candidate.ball && candidate.support.fill >= options_.min_expected_fill &&
                        candidate.support.leak <= options_.max_leak &&
                        share_on_outline(*candidate.ball) >= options_.min_expected_edge;
  return is_there ? candidate.ball : std::nullopt;
}

void Detector::check(const cv::Mat& bgr) const {
  if (bgr.type() == CV_8UC3 && bgr.cols == rays_->size().width_px && bgr.rows == rays_->size().height_px)
    return;
  throw InputError("picture", std::to_string(bgr.cols) + "x" + std::to_string(bgr.rows),
                   "the camera's size, " + std::to_string(rays_->size().width_px) + "x" +
                       std::to_string(rays_->size().height_px) + ", in 8-bit BGR");
}

// The pixels of each class in a window, cleaned.
void Detector::segment(const cv::Mat& bgr, const cv::Rect& window) {
  classify(bgr(window), colors_, classified_, ClassificationKernel::fastest,
           window.area() >= worth_sharing_px ? team_.get() : nullptr);
  morphology_.open(classified_, opened_);
  morphology_.close(opened_, closed_);
}

void Detector::find_balls(const cv::Mat& bgr, const cv::Rect& window, DetectionStages* stages) {
  balls_.clear();
  if (stages) stages->candidates.clear();
  for (const int region : chosen_) find_balls_in(bgr, window, region, stages);
  drop_repeated();
}

// The region's boundary points, but for straight sides: undistorted, half a pixel outward, between the
// region's last pixel and the first beyond it. Of a long boundary only so many as tell where its circles are;
// none of one that as a whole is no ball's.
void Detector::collect_boundary(const ColoredPixels& colored, int region) {
  regions_.boundary(region, closed_, boundary_);
  chain_.order(boundary_, colored.pixels.size());
  const std::size_t stride = (boundary_.size() + max_boundary_points - 1) / max_boundary_points;
  points_.clear();
  remaining_.clear();
  for (std::size_t i = 0; i < boundary_.size(); i += stride) {
    const BoundaryPixel& pixel = boundary_[i];
    const auto position = rays_->undistorted_px(pixel.u_px + colored.window.x, pixel.v_px + colored.window.y);
    if (!position) continue;
    points_.push_back({*position, {0, 0}});
    remaining_.push_back(pixel);
  }
  // The picture's border cuts every shape.
  const Region& whole = regions_.regions()[static_cast<std::size_t>(region)];
  const double focal_px = rays_->camera().focal_px();
  if (!whole.touches_border && is_no_balls(region_shape(remaining_, points_, whole.pixels, focal_px))) {
    points_.clear();
    remaining_.clear();
    return;
  }
  const std::vector<char>& straight = sides_.find(points_);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (straight[i]) continue;
    BoundaryPixel& pixel = remaining_[kept] = remaining_[i];
    const Eigen::Vector2f outward = outward_normal(colored.pixels, pixel);
    points_[kept++] = {points_[i].position_px + 0.5f * outward, outward};
    pixel = {pixel.u_px + colored.window.x, pixel.v_px + colored.window.y, outward};
  }
  points_.resize(kept);
  remaining_.resize(kept);
}

void Detector::find_balls_in(const cv::Mat& bgr, const cv::Rect& window, int region_index,
                             DetectionStages* stages) {
  const Region& region = regions_.regions()[static_cast<std::size_t>(region_index)];
  const ColoredPixels colored{region.color_class, closed_[region.color_class - 1u], window.tl()};
  collect_boundary(colored, region_index);
  whole_boundary_ = points_;
  const std::size_t before = balls_.size();
  vote_for_balls(bgr, colored, region_index, stages);
  // What the balls found leave over may hide another one, if it is large enough for one to be told from it.
  double unexplained_px2 = region.pixels;
  for (std::size_t i = before; i < balls_.size(); ++i)
    unexplained_px2 -= M_PI * balls_[i].outline.radius_px * balls_[i].outline.radius_px;
  if (unexplained_px2 > least_unexplained_px2) look_inside(bgr, colored, region_index, before, stages);
}

// By votes of the region's boundary.
void Detector::vote_for_balls(const cv::Mat& bgr, const ColoredPixels& colored, int region_index,
                              DetectionStages* stages) {
  const Region& region = regions_.regions()[static_cast<std::size_t>(region_index)];
  const std::uint64_t place = (static_cast<std::uint64_t>(region.box.x + colored.window.x) << 32) ^
                              (static_cast<std::uint64_t>(region.box.y + colored.window.y) << 16) ^
                              static_cast<std::uint64_t>(region.pixels);
  RandomEngine engine = random_stream(options_.seed, "circle_vote", place);

  int found = 0;
  for (int failures = 0; failures < failures_per_region && found < options_.max_balls_per_region;) {
    const auto vote = voter_.estimate(points_, engine);
    if (!vote) return;
    RefinementInput input;
    RefinementInput* const wanted = stages ? &input : nullptr;
    Candidate candidate = judge(bgr, colored, *vote, wanted);
    if (failures == 0 && !candidate.is_sure()) look_around(bgr, colored, *vote, candidate, wanted);
    if (stages) record(region_index, *vote, candidate, input, *stages);
    // Take away what this circle explains, found to be a ball or not, and look at the rest: of a ball also
    // what lies inside its outline, as its terminator does.
    const bool nothing_taken = !take_away(*vote, candidate.reason ? nullptr : &*candidate.ball, stages);
    if (!candidate.reason) {
      balls_.push_back(*candidate.ball);
      ++found;
    } else {
      ++failures;
    }
    if (nothing_taken) return;
  }
}

// By edges inside the region: a ball before a thing of its own colour.
void Detector::look_inside(const cv::Mat& bgr, const ColoredPixels& colored, int region_index,
                           std::size_t first_known, DetectionStages* stages) {
  const Region& region = regions_.regions()[static_cast<std::size_t>(region_index)];
  inner_edges_.find(bgr, colored, *rays_, region.box + colored.window, region.pixels, inside_);
  // What lies on or inside a ball that was found, as its terminator does, is that ball's.
  const auto is_known = [&](const auto& edge) {
    return std::any_of(balls_.begin() + static_cast<std::ptrdiff_t>(first_known), balls_.end(),
                       [&](const BallObservation& ball) {
                         const Eigen::Vector2d at_px = edge.position_px.template cast<double>();
                         return (at_px - ball.start.center_px).norm() < 1.1 * ball.start.radius_px + 2;
                       });
  };
  while (static_cast<int>(balls_.size() - first_known) < options_.max_balls_per_region) {
    whole_boundary_.erase(std::remove_if(whole_boundary_.begin(), whole_boundary_.end(), is_known),
                          whole_boundary_.end());
    inside_.erase(std::remove_if(inside_.begin(), inside_.end(), is_known), inside_.end());
    const InnerCircle* const circle = inner_circles_.find(bgr, rays_->camera(), whole_boundary_, inside_);
    if (!circle) return;
    points_ = circle->outline.points;
    remaining_.clear();
    RefinementInput input;
    Candidate candidate = judge(bgr, colored, circle->circle, stages ? &input : nullptr, true);
    if (stages) record(region_index, circle->circle, candidate, input, *stages);
    if (candidate.reason) return;
    balls_.push_back(*candidate.ball);
  }
}

// Is the voted circle a ball? The cheap questions first: most circles are none.
Detector::Candidate Detector::judge(const cv::Mat& bgr, const ColoredPixels& colored,
                                    const CircleEstimate& vote, RefinementInput* input, bool inside_region) {
  if (vote.radius_px < options_.min_radius_px) return {std::nullopt, {}, "too small"};
  const Camera& camera = rays_->camera();
  const auto voted = cone_near_circle({vote.center_px, vote.radius_px}, camera.focal_px());
  if (!voted) return {std::nullopt, {}, "no ball makes this circle"};
  const TangentCone cone = boundary_cone_.rough(*voted, points_, camera.focal_px());
  Candidate candidate;
  candidate.support = early_support(bgr, colored, cone);
  candidate.reason = early_rejection(candidate.support);
  if (candidate.reason && !inside_region) return candidate;

  candidate.ball = fitter_.refine(bgr, colored.color_class, vote, points_, options_.fit, input);
  if (!candidate.ball) {
    candidate.reason = "no edge along the circle";
    return candidate;
  }
  judge_fitted(bgr, colored, candidate);
  return candidate;
}

// A region may be less than its ball, whose rim is too dark or too pale to have the class's colour: perhaps
// there is an outline around it in the picture.
void Detector::look_around(const cv::Mat& bgr, const ColoredPixels& colored, const CircleEstimate& vote,
                           Candidate& candidate, RefinementInput* input) {
  if (options_.fit != BallFit::sphere || vote.radius_px < options_.min_frayed_radius_px ||
      candidate.support.fill < options_.min_frayed_fill)
    return;
  const auto voted = cone_near_circle({vote.center_px, vote.radius_px}, rays_->camera().focal_px());
  if (!voted) return;
  RefinementInput around_input;
  Candidate around = judge_scouted(bgr, colored, *voted, options_.frayed_reach * vote.radius_px,
                                   options_.min_frayed_edge, input ? &around_input : nullptr);
  if (around.reason && around.ball && encloses_region(*around.ball)) {
    around.reason = nullptr;
    around.ball->quality = std::max(around.ball->quality, share_on_outline(*around.ball));
  }
  if (around.reason || (!candidate.reason && around.ball->quality <= candidate.ball->quality)) return;
  candidate = around;
  candidate.ball->vote = vote;
  if (input) *input = std::move(around_input);
}

// Where the colour ends well inside the outline all around, as in dim light or much compressed pictures, the
// colour says little of the rim; but the edge runs around all of it.
bool Detector::encloses_region(const BallObservation& ball) const {
  if (ball.support.fill < options_.min_enclosed_fill || ball.support.fill > options_.max_enclosed_fill ||
      share_on_outline(ball) < options_.min_enclosing_edge)
    return false;
  const double focal_px = rays_->camera().focal_px();
  const double reach_px = outline_tolerance_px(ball.outline.radius_px);
  const auto enclosed =
      std::count_if(whole_boundary_.begin(), whole_boundary_.end(), [&](const BoundaryPoint& point) {
        return angle_outside(ball.cone, ray_of(point, focal_px)) * focal_px <= reach_px;
      });
  return static_cast<double>(enclosed) >= 0.95 * static_cast<double>(whole_boundary_.size());
}

// The ball whose outline is near the cone's, by the edges in the picture alone.
Detector::Candidate Detector::judge_scouted(const cv::Mat& bgr, const ColoredPixels& colored,
                                            const TangentCone& start, double reach_px, double min_edge,
                                            RefinementInput* input) {
  OutlineScoutOptions scout;
  scout.reach_px = reach_px;
  scout.min_support = min_edge;
  Candidate candidate;
  candidate.reason = "no edge along the circle";
  if (!scout_outline(bgr, rays_->camera(), start, scout, scouted_)) return candidate;
  candidate.ball = fitter_.refine(bgr, colored.color_class, scouted_.cone, input);
  if (candidate.ball) judge_fitted(bgr, colored, candidate);
  return candidate;
}

// Do outline and colour together show a ball where it was fitted?
void Detector::judge_fitted(const cv::Mat& bgr, const ColoredPixels& colored, Candidate& candidate) {
  BallObservation& ball = *candidate.ball;
  const Camera& camera = rays_->camera();
  // The paper's fit measures no edges.
  const bool with_edges = options_.fit == BallFit::sphere;
  const OutlineSectors sectors =
      with_edges ? edge_sectors(fitter_.offsets(), outline_tolerance_px(ball.start.radius_px))
                 : boundary_sectors(points_, ball.cone, camera.focal_px());
  const EdgeOffsets offsets = with_edges ? fitter_.offsets() : EdgeOffsets{};
  candidate.support = ball.support =
      outline_support(sectors, offsets, ball.blur_px, colored, camera, ball.cone);
  ball.quality = ball.support.quality();
  candidate.reason = rejection(ball);
  if (!candidate.reason && !shows_a_sphere(bgr, colored, ball))
    candidate.reason = "half of it is hidden, and the rest is not shaded as a sphere";
}

// What the region's boundary says before any edge was measured, and a quick look at the picture where it has
// none: as if every edge that may be there lay on the outline.
OutlineSupport Detector::early_support(const cv::Mat& bgr, const ColoredPixels& colored,
                                       const TangentCone& cone) const {
  const Camera& camera = rays_->camera();
  OutlineSectors sectors = boundary_sectors(points_, cone, camera.focal_px());
  see_steps_in_own_color(bgr, colored, camera, cone, sectors);
  EdgeOffsets offsets;
  offsets.count = sectors.count;
  for (int i = 0; i < offsets.count; ++i) {
    const bool seen = sectors.seen[static_cast<std::size_t>(i)];
    offsets[i] = seen ? 0 : std::numeric_limits<float>::quiet_NaN();
  }
  return outline_support(sectors, offsets, 0, colored, camera, cone);
}

// What the boundary says before any edge was measured, with room for what the edges may add.
const char* Detector::early_rejection(const OutlineSupport& support) const {
  if (support.arc < 0.6 * options_.min_arc) return "the region's outline follows no circle";
  // The circle that fits into a box: touched in short stretches, with the colour all around or all inside.
  if (support.arc_in_runs == 0 && (support.leak > 0.25 || (support.arc < 0.4 && support.fill > 0.9)))
    return "the region's outline follows no circle";
  if (support.fill < 0.8 * options_.min_fill) return "too little of the disc has the colour";
  if (support.leak > options_.max_leak + 0.1) return "the colour runs on around it";
  if (support.quality() < 0.75 * options_.min_quality) return "outline and colour together are too weak";
  return nullptr;
}

bool Detector::take_away(const CircleEstimate& vote, const BallObservation* ball, DetectionStages* stages) {
  std::size_t kept = 0;
  const double reach_px = 0.5 + outline_tolerance_px(vote.radius_px), focal_px = rays_->camera().focal_px();
  const auto is_explained = [&](const BoundaryPoint& p) {
    const double outside_px = (p.position_px.cast<double>() - vote.center_px).norm() - vote.radius_px;
    if (!ball) return std::abs(outside_px) <= reach_px;
    return outside_px <= reach_px || angle_outside(ball->cone, ray_of(p, focal_px)) * focal_px <= reach_px;
  };
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (is_explained(points_[i])) {
      if (stages) stages->candidates.back().removed.push_back(remaining_[i]);
      continue;
    }
    points_[kept] = points_[i];
    remaining_[kept++] = remaining_[i];
  }
  const bool taken = kept < points_.size();
  points_.resize(kept);
  remaining_.resize(kept);
  return taken;
}

const char* Detector::rejection(const BallObservation& ball) const {
  if (ball.outline.radius_px < options_.min_radius_px) return "too small";
  if (ball.support.arc < options_.min_arc) return "too little of the outline has an edge";
  if (ball.support.fill < options_.min_fill) return "too little of the disc has the colour";
  const bool is_small = ball.outline.radius_px < options_.small_radius_px;
  if (ball.support.leak > (is_small ? options_.max_small_leak : options_.max_leak))
    return "the colour runs on around it";
  if (ball.quality < options_.min_quality) return "outline and colour together are too weak";
  return nullptr;
}

// Half a disc looks like a half-hidden ball, but for its shading. A ball half in shade, or cut by the
// picture, has its edge all around in the picture even so.
bool Detector::shows_a_sphere(const cv::Mat& bgr, const ColoredPixels& colored,
                              const BallObservation& ball) const {
  if (ball.support.hidden <= options_.max_hidden) return true;
  if (options_.fit == BallFit::sphere && share_on_outline(ball) >= options_.min_whole) return true;
  const BallShading shading = ball_shading(bgr, fitter_.response(), colored, *rays_, ball.cone, ball.outline);
  return shading.strength >= options_.min_shading && shading.explained >= options_.min_shading_explained &&
         shading.explained > shading.explained_by_two;
}

// On how much of the outline that runs in the picture an edge lies.
double Detector::share_on_outline(const BallObservation& ball) const {
  const EdgeOffsets& offsets = fitter_.offsets();
  int on_outline = 0;
  for (int i = 0; i < offsets.count; ++i)
    on_outline += is_on_outline(offsets[i], ball.outline.radius_px, ball.blur_px) ? 1 : 0;
  return on_outline / std::max(1.0, static_cast<double>(fitter_.edges().stretches_in_picture));
}

void Detector::drop_repeated() {
  // The best first, equals as they were found (std::stable_sort takes memory).
  for (auto ball = balls_.begin(); ball != balls_.end(); ++ball)
    std::rotate(std::upper_bound(
                    balls_.begin(), ball, *ball,
                    [](const BallObservation& a, const BallObservation& b) { return a.quality > b.quality; }),
                ball, ball + 1);
  // A circle whose centre lies well inside a better one of its class is the same ball seen through another
  // region of it.
  std::size_t kept = 0;
  for (std::size_t i = 0; i < balls_.size(); ++i) {
    const bool repeated =
        std::any_of(balls_.begin(), balls_.begin() + static_cast<std::ptrdiff_t>(kept),
                    [&](const BallObservation& better) {
                      const double apart_rad =
                          std::acos(std::clamp(better.cone.axis.dot(balls_[i].cone.axis), -1.0, 1.0));
                      return better.color_class == balls_[i].color_class &&
                             apart_rad < 0.7 * std::max(better.cone.alpha_rad, balls_[i].cone.alpha_rad);
                    });
    if (!repeated) {
      if (kept != i) balls_[kept] = balls_[i];
      ++kept;
    }
  }
  balls_.resize(kept);
}

}  // namespace ballservo
