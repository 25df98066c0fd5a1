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

namespace ballservo {
namespace {

constexpr int worth_sharing_px = 100000;  // below, threads cost more to wake than they save
constexpr int failures_per_region = 3;
constexpr std::size_t max_boundary_points = 256;
constexpr double long_step_px = 1;
constexpr double pi = 3.14159265358979323846;
// A disc of 12 px radius: a smaller one's edges before its own colour tell nothing (see outline_support).
constexpr double least_unexplained_px2 = pi * 12 * 12;
// Robust weights are never built on a scale finer than this: edges of a clean ball agree to a few hundredths.
constexpr double robust_floor_px = 0.06;

// How far an edge or a boundary pixel may lie from a ball's outline and still speak for it.
double tolerance_px(double radius_px) { return 0.5 + 0.025 * radius_px; }

Eigen::Vector3d ray_of(const BoundaryPoint& p, double focal_px) {
  return Eigen::Vector3d(static_cast<double>(p.position_px.x()), static_cast<double>(p.position_px.y()),
                         focal_px)
      .normalized();
}

// The sectors of the cone's outline on which a boundary point lies: 48, or as many as it has pixels.
OutlineSectors boundary_sectors(const std::vector<BoundaryPoint>& points, const TangentCone& cone,
                                double focal_px) {
  const double radius_px = cone.alpha_rad * focal_px;
  const double tolerance_rad = (0.5 + tolerance_px(radius_px)) / focal_px;
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(cone.axis);
  OutlineSectors sectors;
  sectors.count = static_cast<int>(std::clamp(6.28 * radius_px, 8.0, 48.0));
  for (const BoundaryPoint& p : points) {
    const Eigen::Vector3d ray = ray_of(p, focal_px);
    if (std::abs(angle_outside(cone, ray)) > tolerance_rad) continue;
    const Eigen::Vector2d across = basis.transpose() * ray;
    const double angle = std::atan2(across.y(), across.x());
    sectors.see(angle < 0 ? angle + 6.283185307179586 : angle);
  }
  return sectors;
}

}  // namespace

Detector::Detector(std::shared_ptr<const RayTable> rays, std::shared_ptr<const ColorTable> colors,
                   const DetectorOptions& options)
    : rays_(std::move(rays)),
      colors_(std::move(colors)),
      options_(options),
      regions_(options.max_runs),
      voter_(options.vote),
      edge_meter_(options.edges) {
  options_.validate();
  if (options_.threads > 1) team_ = std::make_unique<RowTeam>(options_.threads);
}

const std::vector<BallObservation>& Detector::detect(const cv::Mat& bgr, cv::Rect window,
                                                     DetectionStages* stages) {
  if (bgr.type() != CV_8UC3 || bgr.cols != rays_->size().width_px || bgr.rows != rays_->size().height_px) {
    throw InputError("picture", std::to_string(bgr.cols) + "x" + std::to_string(bgr.rows),
                     "the camera's size, " + std::to_string(rays_->size().width_px) + "x" +
                         std::to_string(rays_->size().height_px) + ", in 8-bit BGR");
  }
  balls_.clear();
  left_out_ = {};
  const cv::Rect everywhere({0, 0}, bgr.size());
  if (window.empty()) window = everywhere;
  window &= everywhere;
  if (window.empty()) return balls_;

  classify(bgr(window), colors_, classified_, ClassificationKernel::fastest,
           window.area() >= worth_sharing_px ? team_.get() : nullptr);
  morphology_.open(classified_, opened_);
  morphology_.close(opened_, closed_);
  if (stages) {
    const auto numbers = [&](const ClassPictures& classes) { return class_numbers(classes, window.size()); };
    *stages = {window, numbers(classified_), numbers(opened_), numbers(closed_), {}};
  }
  regions_.update(closed_, window.size());
  left_out_.shorter_px = regions_.shortest_run_px() > 1 ? regions_.shortest_run_px() : 0;
  left_out_.regions = choose_regions(regions_.regions(), 2 * options_.min_radius_px * options_.min_radius_px,
                                     options_.max_regions, chosen_);
  find_balls(bgr, window, stages);
  if (learn_response(bgr)) find_balls(bgr, window, stages);
  return balls_;
}

void Detector::find_balls(const cv::Mat& bgr, const cv::Rect& window, DetectionStages* stages) {
  balls_.clear();
  if (stages) stages->candidates.clear();
  for (const int region : chosen_) find_balls_in(bgr, window, region, stages);
  drop_repeated();
}

const CameraResponse& Detector::response() const {
  switch (options_.response) {
    case ResponseChoice::linear:
      return CameraResponse::linear();
    case ResponseChoice::srgb:
      return CameraResponse::srgb();
    case ResponseChoice::by_edges:
      break;
  }
  return response_.likelier();
}

// Whether the camera's response is believed to be another now, after a look at the edges of the balls found.
bool Detector::learn_response(const cv::Mat& bgr) {
  if (options_.response != ResponseChoice::by_edges || options_.fit != BallFit::sphere) return false;
  const CameraResponse& before = response();
  for (const BallObservation& ball : balls_) {
    if (!response_.open()) break;
    edge_meter_.measure(bgr, *rays_, ball.cone, before, edges_);
    robust_weights_.set(ball.cone, edges_.points, robust_floor_px, options_.oval_fraction);
    response_.add(edge_meter_.evidence(bgr, *rays_, ball.cone, edges_.points, CameraResponse::srgb(),
                                       CameraResponse::linear()));
  }
  return &response() != &before;
}

// The region's boundary points, but for straight sides: undistorted, half a pixel outward, between the
// region's last pixel and the first beyond it. Of a long boundary only so many as tell where its circles are.
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
    unexplained_px2 -= pi * balls_[i].outline.radius_px * balls_[i].outline.radius_px;
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
    Candidate candidate = judge(bgr, colored, *vote, stages ? &input : nullptr);
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
                         return (at_px - ball.vote.center_px).norm() < 1.1 * ball.vote.radius_px + 2;
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
  const TangentCone cone = rough_cone(*voted);
  Candidate candidate;
  candidate.support = early_support(bgr, colored, cone);
  candidate.reason = early_rejection(candidate.support);
  if (candidate.reason && !inside_region) return candidate;

  candidate.ball = refine(bgr, colored.color_class, vote, points_, options_.fit, input);
  if (!candidate.ball) {
    candidate.reason = "no edge along the circle";
    return candidate;
  }
  BallObservation& ball = *candidate.ball;
  if (options_.fit == BallFit::paper) {
    sectors_ = boundary_sectors(points_, ball.cone, camera.focal_px());
    offsets_.count = 0;
  }
  candidate.support = ball.support =
      outline_support(sectors_, offsets_, ball.blur_px, colored, camera, ball.cone);
  ball.quality = ball.support.quality();
  candidate.reason = rejection(ball);
  if (!candidate.reason && !shows_a_sphere(bgr, colored, ball))
    candidate.reason = "half of it is hidden, and the rest is not shaded as a sphere";
  return candidate;
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
  const double reach_px = 0.5 + tolerance_px(vote.radius_px), focal_px = rays_->camera().focal_px();
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
  if (ball.support.leak > options_.max_leak) return "the colour runs on around it";
  if (ball.quality < options_.min_quality) return "outline and colour together are too weak";
  return nullptr;
}

// Half a disc looks like a half-hidden ball, but for its shading. A ball half in shade, or cut by the
// picture, has its edge all around in the picture even so.
bool Detector::shows_a_sphere(const cv::Mat& bgr, const ColoredPixels& colored,
                              const BallObservation& ball) const {
  if (ball.support.hidden <= options_.max_hidden) return true;
  int on_outline = 0;
  for (int i = 0; i < offsets_.count; ++i)
    on_outline += is_on_outline(offsets_[i], ball.outline.radius_px, ball.blur_px) ? 1 : 0;
  if (on_outline >= options_.min_whole * edges_.stretches_in_picture && on_outline > 0) return true;
  const BallShading shading = ball_shading(bgr, response(), colored, *rays_, ball.cone, ball.outline);
  return shading.strength >= options_.min_shading && shading.explained >= options_.min_shading_explained;
}

std::optional<BallObservation> Detector::refine(const cv::Mat& bgr, ClassIndex color_class,
                                                const CircleEstimate& vote,
                                                const std::vector<BoundaryPoint>& boundary, BallFit fit,
                                                RefinementInput* input) {
  const UndistortedCircle circle{vote.center_px, vote.radius_px};
  if (input) input->vote = circle;
  auto ball = fit == BallFit::sphere ? refine_sphere(bgr, color_class, circle, boundary, input)
                                     : refine_paper(bgr, color_class, circle, input);
  if (!ball) return std::nullopt;
  const auto outline = project_sphere(rays_->camera(), ball->cone.axis, std::sin(ball->cone.alpha_rad));
  if (!outline) return std::nullopt;
  ball->outline = *outline;
  ball->color_class = color_class;
  ball->vote = vote;
  return ball;
}

// The cone through the boundary points near the voted one: enough to ask whether a ball is likely.
TangentCone Detector::rough_cone(const TangentCone& voted) {
  const double focal_px = rays_->camera().focal_px();
  TangentCone cone = voted;
  for (int i = 0; i < 2; ++i) {
    const double band_rad = 0.15 * cone.alpha_rad + 1 / focal_px;
    const double cosine_inner = std::cos(std::max(0.0, cone.alpha_rad - band_rad)),
                 cosine_outer = std::cos(cone.alpha_rad + band_rad);
    boundary_rays_.clear();
    for (const BoundaryPoint& p : points_) {
      const Eigen::Vector3d ray = ray_of(p, focal_px);
      const double cosine = cone.axis.dot(ray);
      if (cosine <= cosine_inner && cosine >= cosine_outer) boundary_rays_.push_back(ray);
    }
    const auto center = sphere_from_rays(boundary_rays_, 1);
    const auto found = center ? TangentCone::of_sphere(*center, 1) : std::nullopt;
    if (!found || !(std::abs(found->alpha_rad / voted.alpha_rad - 1) < 0.3)) return voted;
    cone = *found;
  }
  return cone;
}

// The votes look for a circle; a ball off the axis is none, and they may settle on a part of it. The cone
// through the boundary pixels near the voted circle is the whole ball's.
std::optional<TangentCone> Detector::cone_of_boundary(const TangentCone& start,
                                                      const std::vector<BoundaryPoint>& boundary) {
  const double focal_px = rays_->camera().focal_px();
  TangentCone cone = start;
  for (int i = 0; i < 3; ++i) {
    const double band_rad = 0.15 * cone.alpha_rad + 1 / focal_px;
    boundary_edges_.clear();
    for (const BoundaryPoint& p : boundary) {
      const Eigen::Vector3d ray = ray_of(p, focal_px);
      if (std::abs(angle_outside(cone, ray)) > band_rad) continue;
      EdgePoint edge;
      edge.ray = ray;
      edge.px_per_rad = focal_px;
      edge.sigma_px = 0.5;
      boundary_edges_.push_back(edge);
    }
    robust_weights_.set(cone, boundary_edges_, 0.3, options_.oval_fraction);
    const auto fit = one_gauss_newton_step(cone, boundary_edges_, options_.oval_fraction);
    if (!fit) return std::nullopt;
    cone = fit->cone;
  }
  return cone;
}

std::optional<BallObservation> Detector::refine_sphere(const cv::Mat& bgr, ClassIndex color_class,
                                                       const UndistortedCircle& circle,
                                                       const std::vector<BoundaryPoint>& boundary,
                                                       RefinementInput* input) {
  const auto voted = cone_near_circle(circle, rays_->camera().focal_px());
  if (!voted) return std::nullopt;
  // Measured around the boundary's cone and followed by one step; and once more where that step was long, so
  // that the pixels were not those around the outline.
  TangentCone cone = cone_of_boundary(*voted, boundary).value_or(*voted);
  std::optional<ConeFit> fit;
  for (int pass = 0; pass < 2; ++pass) {
    edge_meter_.measure(bgr, *rays_, cone, response(), edges_);
    robust_weights_.set(cone, edges_.points, robust_floor_px, options_.oval_fraction);
    if (input) {
      input->start = cone;
      input->edges = edges_.points;
    }
    fit = one_gauss_newton_step(cone, edges_.points, options_.oval_fraction);
    if (!fit) return std::nullopt;
    cone = fit->cone;
    if (fit->step_px < long_step_px) break;
  }
  BallObservation ball;
  ball.cone = cone;
  ball.cone_covariance_rad2 = fit->covariance_rad2;
  ball.residual_px = fit->residual_px;
  ball.step_px = fit->step_px;
  ball.edges_used = fit->used;
  ball.blur_px = edges_.blur_px;
  offsets_ = edge_offsets(edges_, *fit);
  sectors_ = edge_sectors(offsets_, tolerance_px(circle.radius_px));
  ball.position = position(color_class, *fit);
  return ball;
}

std::optional<BallObservation> Detector::refine_paper(const cv::Mat& bgr, ClassIndex color_class,
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
  ball.edges_used = fit->used;
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

std::optional<BallPosition> Detector::position(ClassIndex color_class, const ConeFit& fit) const {
  const BallRadius radius = radius_of(color_class);
  if (!(radius.radius_m > 0)) return std::nullopt;
  return BallPosition{fit.cone.center(radius.radius_m),
                      center_covariance(fit, radius.radius_m, radius.sigma_m)};
}

BallRadius Detector::radius_of(ClassIndex color_class) const {
  const std::size_t index = static_cast<std::size_t>(color_class) - 1;
  return color_class != no_class && index < options_.radii.size() ? options_.radii[index] : BallRadius{};
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
