#include "perception/detector.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/base/fault.hpp"
#include "perception/candidates/region_shape.hpp"
#include "perception/outline/ball_position.hpp"
#include "perception/segmentation/classification.hpp"

namespace ballservo {
namespace {

constexpr int worth_sharing_px = 100000;  // below, threads cost more to wake than they save
constexpr int failures_per_region = 3, max_balls_per_region = 8;
// A region may be less than its ball, whose rim is too dark or too pale for the class, unless a ball of so
// much quality was found in it, if it is so large and fills its circle so far: then there may be an outline
// around it, its radius larger by up to a part of the circle's.
constexpr double sure_quality = 0.7, min_frayed_radius_px = 8, min_frayed_fill = 0.6, frayed_reach = 0.6;
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
                                                     DetectionStages* stages,
                                                     std::optional<double> min_quality) {
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
  find_balls(bgr, window, min_quality, stages);
  if (fitter_.learn_response(bgr, balls_)) find_balls(bgr, window, min_quality, stages);
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
  const Look look = look_at(bgr, colored, expected.min_quality);
  const int rings = rings_over(expected.spread_px, expected.reach_px);
  const double spacing_rad = expected.spread_px / std::max(1, rings) / rays_->camera().focal_px();
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(expected.cone.axis);
  std::optional<BallObservation> clearest;
  for (int down = -rings; down <= rings; ++down) {
    for (int right = -rings; right <= rings; ++right) {
      TangentCone start = expected.cone;
      if (rings > 0)
        start.axis = (start.axis + basis * Eigen::Vector2d(right, down) * spacing_rad).normalized();
      const auto ball = find_from(look, start, expected.reach_px, clearly);
      if (ball && may_be(*ball) && (!clearest || ball->quality > clearest->quality)) clearest = ball;
    }
  }
  return clearest;
}

// The ball whose outline is near the cone's; not clearly: also where it shows less of itself than another
// must.
std::optional<BallObservation> Detector::find_from(const Look& look, const TangentCone& start,
                                                   double reach_px, bool clearly) {
  const Candidate candidate = try_around(
      look, start, reach_px, clearly ? options_.min_frayed_edge : options_.min_expected_edge, nullptr);
  const bool is_there = !candidate.reason ||
                        (!clearly && candidate.ball && look.judge.suffices_where_expected(*candidate.ball));
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

Detector::Look Detector::look_at(const cv::Mat& bgr, const ColoredPixels& colored,
                                 std::optional<double> min_quality) const {
  return {bgr, colored,
          BallJudge(bgr, colored, *rays_, fitter_, options_, min_quality.value_or(options_.min_quality))};
}

Detector::VotedCircle Detector::voted_circle(const CircleEstimate& estimate) const {
  return {estimate, cone_near_circle({estimate.center_px, estimate.radius_px}, rays_->camera().focal_px())};
}

// Region by region: by votes of its boundary, and where the balls found leave enough of it over, inside it.
void Detector::find_balls(const cv::Mat& bgr, const cv::Rect& window, std::optional<double> min_quality,
                          DetectionStages* stages) {
  balls_.clear();
  if (stages) stages->candidates.clear();
  for (const int index : chosen_) {
    const Region& region = regions_.regions()[static_cast<std::size_t>(index)];
    const ColoredPixels colored{region.color_class, closed_[region.color_class - 1u], window.tl()};
    const Look look = look_at(bgr, colored, min_quality);
    collect_boundary(colored, index);
    whole_boundary_ = points_;
    const std::size_t before = balls_.size();
    vote_for_balls(look, index, stages);
    // What is left may hide another one, if it is large enough for one to be told from it.
    double unexplained_px2 = region.pixels;
    for (std::size_t i = before; i < balls_.size(); ++i)
      unexplained_px2 -= M_PI * balls_[i].outline.radius_px * balls_[i].outline.radius_px;
    if (unexplained_px2 > least_unexplained_px2) look_inside(look, index, before, stages);
  }
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

// By votes of the region's boundary.
void Detector::vote_for_balls(const Look& look, int region_index, DetectionStages* stages) {
  const Region& region = regions_.regions()[static_cast<std::size_t>(region_index)];
  const std::uint64_t place = (static_cast<std::uint64_t>(region.box.x + look.colored.window.x) << 32) ^
                              (static_cast<std::uint64_t>(region.box.y + look.colored.window.y) << 16) ^
                              static_cast<std::uint64_t>(region.pixels);
  RandomEngine engine = random_stream(options_.seed, "circle_vote", place);

  int found = 0;
  for (int failures = 0; failures < failures_per_region && found < max_balls_per_region;) {
    const auto vote = voter_.estimate(points_, engine);
    if (!vote) return;
    RefinementInput input;
    RefinementInput* const wanted = stages ? &input : nullptr;
    const VotedCircle circle = voted_circle(*vote);
    Candidate candidate = try_circle(look, circle, wanted);
    if (failures == 0) look_around(look, circle, candidate, wanted);
    if (stages) record(region_index, circle, candidate, input, *stages);
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
void Detector::look_inside(const Look& look, int region_index, std::size_t first_known,
                           DetectionStages* stages) {
  const Region& region = regions_.regions()[static_cast<std::size_t>(region_index)];
  inner_edges_.find(look.bgr, look.colored, *rays_, region.box + look.colored.window, region.pixels, inside_);
  // What lies on or inside a ball that was found, as its terminator does, is that ball's.
  const auto is_known = [&](const auto& edge) {
    return std::any_of(balls_.begin() + static_cast<std::ptrdiff_t>(first_known), balls_.end(),
                       [&](const BallObservation& ball) {
                         const Eigen::Vector2d at_px = edge.position_px.template cast<double>();
                         return (at_px - ball.start.center_px).norm() < 1.1 * ball.start.radius_px + 2;
                       });
  };
  while (static_cast<int>(balls_.size() - first_known) < max_balls_per_region) {
    whole_boundary_.erase(std::remove_if(whole_boundary_.begin(), whole_boundary_.end(), is_known),
                          whole_boundary_.end());
    inside_.erase(std::remove_if(inside_.begin(), inside_.end(), is_known), inside_.end());
    const InnerCircle* const inner = inner_circles_.find(look.bgr, rays_->camera(), whole_boundary_, inside_);
    if (!inner) return;
    const VotedCircle circle = voted_circle(inner->circle);
    points_ = inner->outline.points;
    remaining_.clear();
    RefinementInput input;
    const Candidate candidate = try_circle(look, circle, stages ? &input : nullptr, true);
    if (stages) record(region_index, circle, candidate, input, *stages);
    if (candidate.reason) return;
    balls_.push_back(*candidate.ball);
  }
}

// Is the voted circle a ball? The cheap questions first: most circles are none.
Detector::Candidate Detector::try_circle(const Look& look, const VotedCircle& circle, RefinementInput* input,
                                         bool inside_region) {
  if (circle.estimate.radius_px < options_.min_radius_px) return {std::nullopt, {}, "too small"};
  if (!circle.cone) return {std::nullopt, {}, "no ball makes this circle"};
  const TangentCone cone = boundary_cone_.rough(*circle.cone, points_, rays_->camera().focal_px());
  Candidate candidate;
  candidate.support = look.judge.early_support(points_, cone);
  candidate.reason = look.judge.early_rejection(candidate.support);
  if (candidate.reason && !inside_region) return candidate;

  candidate.ball = fitter_.refine(look.bgr, look.colored.color_class, circle.estimate, *circle.cone, points_,
                                  options_.fit, input);
  judge_fitted(look, candidate);
  return candidate;
}

// The ball whose outline is near the cone's, by the edges in the picture alone.
Detector::Candidate Detector::try_around(const Look& look, const TangentCone& start, double reach_px,
                                         double min_edge, RefinementInput* input) {
  OutlineScoutOptions scout;
  scout.reach_px = reach_px;
  scout.min_support = min_edge;
  Candidate candidate;
  if (scout_outline(look.bgr, rays_->camera(), start, scout, scouted_))
    candidate.ball = fitter_.refine(look.bgr, look.colored.color_class, scouted_.cone, input);
  judge_fitted(look, candidate);
  return candidate;
}

void Detector::judge_fitted(const Look& look, Candidate& candidate) const {
  if (!candidate.ball) {
    candidate.reason = "no edge along the circle";
    return;
  }
  candidate.reason = look.judge.rejection(points_, *candidate.ball);
  candidate.support = candidate.ball->support;
}

// The outline around a region that may be less than its ball, in the candidate's place where it says more.
void Detector::look_around(const Look& look, const VotedCircle& circle, Candidate& candidate,
                           RefinementInput* input) {
  const double radius_px = circle.estimate.radius_px;
  const bool is_sure = !candidate.reason && candidate.ball->quality >= sure_quality;
  if (is_sure || options_.fit != BallFit::sphere || !circle.cone || radius_px < min_frayed_radius_px ||
      candidate.support.fill < min_frayed_fill)
    return;
  RefinementInput around_input;
  Candidate around = try_around(look, *circle.cone, frayed_reach * radius_px, options_.min_frayed_edge,
                                input ? &around_input : nullptr);
  if (around.reason && around.ball && look.judge.encloses(whole_boundary_, *around.ball)) {
    around.reason = nullptr;
    around.ball->quality = std::max(around.ball->quality, look.judge.share_on_outline(*around.ball));
  }
  if (around.reason || (!candidate.reason && around.ball->quality <= candidate.ball->quality)) return;
  candidate = around;
  candidate.ball->vote = circle.estimate;
  if (input) *input = std::move(around_input);
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
