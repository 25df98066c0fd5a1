#include "perception/detector.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "perception/judgement/ball_shading.hpp"
#include "perception/outline/noise_response.hpp"
#include "perception/outline/picture_noise.hpp"

namespace ballservo {
namespace {

constexpr int worth_sharing_px = 100000;  // below, threads cost more to wake than they save
constexpr int max_regions = 256;          // that are looked at for balls; the largest

const DetectorOptions& valid(const DetectorOptions& options) {
  options.validate();
  return options;
}

// The noise (sigma, grey levels) beyond which a smoother picture tells the classes better.
double most_noise(const ColorTable& colors) {
  constexpr double ordinary = 7, of_chroma = 0.25;
  double most = ordinary;
  for (const ColorClass& color : colors.classes) {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < color.histogram.counts.size(); ++i) {
      const auto middle = [](std::size_t cell) {
        return (static_cast<double>(cell) + 0.5) * ChromaHistogram::cell - 128;
      };
      const double pixels = color.histogram.counts[i];
      sum += pixels * std::hypot(middle(i % ChromaHistogram::side), middle(i / ChromaHistogram::side));
      count += pixels;
    }
    if (count > 0) most = std::min(most, of_chroma * sum / count);
  }
  return most;
}

// Rings of starts around an expected ball, so that each place within the spread is in reach of one.
int rings_over(double spread_px, double reach_px) {
  constexpr double most = 3;
  const double rings = std::ceil(spread_px / (2 * reach_px));
  return rings > 0 ? static_cast<int>(std::min(rings, most)) : 0;
}

// The best first, equals as they were found (std::stable_sort takes memory).
void sort_by_quality(std::vector<BallObservation>& balls) {
  const auto better = [](const BallObservation& a, const BallObservation& b) {
    return a.quality > b.quality;
  };
  for (auto ball = balls.begin(); ball != balls.end(); ++ball)
    std::rotate(std::upper_bound(balls.begin(), ball, *ball, better), ball, ball + 1);
}

// What is the same ball as a better one, by another region.
void drop_repeated(std::vector<BallObservation>& balls) {
  auto kept = balls.begin();
  for (auto ball = balls.begin(); ball != balls.end(); ++ball) {
    const bool repeated = std::any_of(
        balls.begin(), kept, [&](const BallObservation& better) { return same_ball(better, *ball); });
    if (repeated) continue;
    if (kept != ball) *kept = *ball;
    ++kept;
  }
  balls.erase(kept, balls.end());
}

void show_rejected(const BallObservation& ball, const char* reason, DetectionStages& stages) {
  for (DetectionStages::Candidate& candidate : stages.candidates) {
    if (!ball.vote || candidate.estimate.center_px != ball.vote->center_px) continue;
    candidate.accepted = false;
    candidate.reason = reason;
  }
}

// What a picture's other regions of its class say of one. As many things as there are of about one size
// (leaves, a pattern), so much likelier is one of them to look like a ball.
void compare_with_others(const std::vector<Region>& regions, const std::vector<int>& chosen, int region,
                         RegionPrior& prior) {
  constexpr int same_size = 3;  // times the pixels
  const Region& one = regions[static_cast<std::size_t>(region)];
  double alike = 0, pixels = 0;
  for (const int i : chosen) {
    const Region& other = regions[static_cast<std::size_t>(i)];
    if (other.color_class != one.color_class) continue;
    pixels += other.pixels;
    alike += other.pixels < same_size * one.pixels && one.pixels < same_size * other.pixels ? 1 : 0;
  }
  prior.log_look_alikes = std::log(alike);
  prior.share = one.pixels / pixels;
}

}  // namespace

BallRadius DetectorOptions::radius_of(ClassIndex color_class) const {
  const std::size_t index = static_cast<std::size_t>(color_class) - 1;
  return color_class != no_class && index < radii.size() ? radii[index] : BallRadius{};
}

void DetectorOptions::validate() const {
  FaultList faults;
  check_range(faults, "threads", threads, 1, most_threads);
  check_range(faults, "oval_fraction", oval_fraction, 0, 0.3);
  for (const BallRadius& radius : radii) {
    if (!(radius.radius_m >= 0) || !std::isfinite(radius.radius_m))
      faults.add("radii", number_text(radius.radius_m), "a positive length (m), or 0 where unknown");
    if (!(radius.sigma_m >= 0) || !std::isfinite(radius.sigma_m))
      faults.add("radii", number_text(radius.sigma_m), "a sigma of 0 or more (m)");
  }
  faults.throw_if_any();
}

Detector::Detector(std::shared_ptr<const RayTable> rays, std::shared_ptr<const ColorTable> colors,
                   const DetectorOptions& options)
    : rays_(std::move(rays)),
      options_(valid(options)),
      most_noise_(most_noise(*colors)),
      colors_(std::move(colors)),
      search_(rays_, options),
      response_belief_(options.coarse_chroma) {}

const std::vector<BallObservation>& Detector::detect(const cv::Mat& bgr, const cv::Rect& window,
                                                     DetectionStages* stages, double min_quality) {
  check(bgr);
  balls_.clear();
  chosen_.clear();
  left_out_ = {};
  const cv::Rect everywhere({0, 0}, bgr.size());
  const cv::Rect seen = window.empty() ? everywhere : window & everywhere;
  if (seen.empty()) return balls_;

  looked_at_ = {seen, window.empty()};
  if (window.empty()) learn_noise(bgr);
  segment(bgr, seen);
  if (stages) {
    const auto numbers = [&](const ClassPictures& classes) { return class_numbers(classes, seen.size()); };
    *stages = {
        seen, numbers(segmented_.classified), numbers(segmented_.opened), numbers(segmented_.closed), {}};
  }
  regions_.update(segmented_.closed, seen.size());
  left_out_.shorter_px = regions_.shortest_run_px() > 1 ? regions_.shortest_run_px() : 0;
  left_out_.regions =
      choose_regions(regions_.regions(), 2 * min_ball_radius_px * min_ball_radius_px, max_regions, chosen_);
  return search_regions(bgr, {min_quality, window.empty()}, stages);
}

const std::vector<BallObservation>& Detector::detect_thoroughly(const cv::Mat& bgr, DetectionStages* stages) {
  RegionPrior prior{min_ball_quality, looked_at_.everywhere};
  prior.thorough = true;
  return search_regions(bgr, prior, stages);
}

// By the camera's response that the balls' edges tell.
const std::vector<BallObservation>& Detector::search_regions(const cv::Mat& bgr, const RegionPrior& prior,
                                                             DetectionStages* stages) {
  find_balls(bgr, prior, stages);
  if (learn_response(bgr)) find_balls(bgr, prior, stages);
  if (looked_at_.window.size() == bgr.size() && balls_.size() > 1) compare_with_clear_balls(bgr, stages);
  admit_other_responses(bgr);
  return balls_;
}

void Detector::find_balls(const cv::Mat& bgr, RegionPrior prior, DetectionStages* stages) {
  balls_.clear();
  if (stages) stages->candidates.clear();
  for (const int region : chosen_) {
    compare_with_others(regions_.regions(), chosen_, region, prior);
    search_.find(bgr, regions_, region, looked_at_.window.tl(), response(), prior, balls_, stages);
  }
  sort_by_quality(balls_);
  drop_repeated(balls_);
}

// See clear_ball.hpp. In most pictures the shading decides.
void Detector::compare_with_clear_balls(const cv::Mat& bgr, DetectionStages* stages) {
  const auto pixels_of = [&](const BallObservation& ball) -> ColoredPixels {
    return {ball.color_class, segmented_.closed[ball.color_class - 1u], looked_at_.window.tl()};
  };
  const std::size_t count = balls_.size();
  looks_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const BallObservation& ball = balls_[i];
    looks_[i] = {ball.outline.radius_px,
                 shading_strength(bgr, response(), pixels_of(ball), *rays_, ball.cone, ball.outline),
                 std::nullopt};
  }
  const auto log_odds = [&](std::size_t i) {
    std::optional<double>& seen = looks_[i].log_odds;
    if (!seen)
      seen = search_.verifier().second_look().look(bgr, pixels_of(balls_[i]), balls_[i].outline).log_odds;
    return *seen;
  };
  const auto is_beside_clear_ball = [&](const BallObservation& ball) {
    for (std::size_t i = 0; i < count; ++i) {
      if (balls_[i].color_class == ball.color_class && may_be_clear_ball(looks_[i]) &&
          log_odds(i) >= least_clear_log_odds)
        return true;
    }
    return false;
  };
  const auto reason_against = [&](std::size_t i) -> const char* {
    const double radius_px = looks_[i].radius_px;
    const bool disc = is_flat_disc(looks_[i]), small = radius_px < small_ball_px;
    if ((!disc && !small) || !is_beside_clear_ball(balls_[i])) return nullptr;
    if (disc) return "evenly bright, beside a ball that is shaded";
    return log_odds(i) < least_log_odds_of_small(radius_px) ? "a speck, beside a clear ball" : nullptr;
  };
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const char* const reason = reason_against(i);
    if (reason && stages) show_rejected(balls_[i], reason, *stages);
    if (reason) continue;
    std::swap(balls_[kept], balls_[i]);
    std::swap(looks_[kept++], looks_[i]);
  }
  balls_.resize(kept);
}

std::optional<BallObservation> Detector::find_expected(
    const cv::Mat& bgr, const cv::Rect& window, const ExpectedBall& expected, bool clearly,
    const std::function<bool(const BallObservation&)>& may_be) {
  check(bgr);
  if (options_.fit != BallFit::sphere) return std::nullopt;
  const cv::Rect seen = window & cv::Rect({0, 0}, bgr.size());
  if (seen.empty()) return std::nullopt;
  segment(bgr, seen);
  if (expected.color_class == no_class || expected.color_class > segmented_.closed.size())
    return std::nullopt;
  const ColoredPixels colored{expected.color_class, segmented_.closed[expected.color_class - 1u], seen.tl()};
  const ClassView view{bgr, colored, response(), {expected.min_quality}};
  const int rings = rings_over(expected.spread_px, expected.reach_px);
  const double spacing_rad = expected.spread_px / std::max(1, rings) / rays_->camera().focal_px();
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(expected.cone.axis);
  const double alpha_rad = expected.cone.alpha_rad;
  const KnownAngle known{alpha_rad, expected.size_sigma * alpha_rad};
  std::optional<BallObservation> clearest;
  for (int down = -rings; down <= rings; ++down) {
    for (int right = -rings; right <= rings; ++right) {
      TangentCone start = expected.cone;
      if (rings > 0)
        start.axis = (start.axis + basis * Eigen::Vector2d(right, down) * spacing_rad).normalized();
      const auto ball = search_.verifier().verify_near(view, start, expected.reach_px, clearly, known);
      if (ball && may_be(*ball) && (!clearest || ball->quality > clearest->quality)) clearest = ball;
    }
  }
  return clearest;
}

double Detector::log_odds(const cv::Mat& bgr, const BallObservation& ball) {
  const double reach = ball.outline.radius_px + 8;
  const Eigen::Vector2d corner = ball.outline.center_px.array() - reach;
  if (!(reach < 1e6) || !(corner.cwiseAbs().maxCoeff() < 1e6)) return 0;
  const cv::Rect around(cvFloor(corner.x()), cvFloor(corner.y()), cvCeil(2 * reach), cvCeil(2 * reach));
  const cv::Rect window = around & cv::Rect({0, 0}, bgr.size());
  if (window.empty()) return 0;
  segment(bgr, window);
  const ColoredPixels colored{ball.color_class, segmented_.closed[ball.color_class - 1u], window.tl()};
  return search_.verifier().second_look().look(bgr, colored, ball.outline).log_odds;
}

bool Detector::fit_sphere(const cv::Mat& bgr, const UndistortedCircle& circle,
                          const std::vector<BoundaryPoint>& boundary, OutlineFit& fit) {
  const VotedCircle voted({circle}, rays_->camera().focal_px());
  if (!voted.cone) return false;
  BallVerifier& verifier = search_.verifier();
  const TangentCone rough = verifier.rough_cone(voted, boundary);
  return verifier.fit_sphere(verifier.fitter(), bgr, response(), voted, rough, boundary, {}, fit);
}

void Detector::learn_noise(const cv::Mat& bgr) {
  noise_sigma_ = noise_sigma(bgr);
  search_.verifier().second_look().set_noise(noise_sigma_);
}

// Stages 1 and 2.
void Detector::segment(const cv::Mat& bgr, const cv::Rect& window) {
  const int threads = window.area() >= worth_sharing_px ? options_.threads : 1;
  const cv::Mat seen = bgr(window);
  const bool noisy = options_.fit == BallFit::sphere && noise_sigma_ > most_noise_;
  classify(noisy ? smoothing_.smoothed(seen) : seen, colors_, segmented_.classified, threads);
  morphology_.open(segmented_.classified, segmented_.opened);
  morphology_.close(segmented_.opened, segmented_.closed);
}

void Detector::check(const cv::Mat& bgr) const {
  if (bgr.type() == CV_8UC3 && bgr.cols == rays_->size().width_px && bgr.rows == rays_->size().height_px)
    return;
  throw InputError("picture", std::to_string(bgr.cols) + "x" + std::to_string(bgr.rows),
                   "the camera's size, " + std::to_string(rays_->size().width_px) + "x" +
                       std::to_string(rays_->size().height_px) + ", in 8-bit BGR");
}

const CameraResponse& Detector::response() const {
  const bool srgb = options_.response == ResponseChoice::by_picture
                        ? response_belief_.srgb()
                        : options_.response == ResponseChoice::srgb;
  const bool coarse_chroma = response_belief_.coarse_chroma();
  return srgb ? CameraResponse::srgb(coarse_chroma) : CameraResponse::linear(coarse_chroma);
}

// Looks at the edges of balls that were found; at those of small ones, which may be another thing's, where
// there are no others. Is another response believed now?
bool Detector::learn_response(const cv::Mat& bgr) {
  if (options_.fit != BallFit::sphere || balls_.empty() || !response_belief_.open()) return false;
  const CameraResponse& before = response();
  ResponseEvidence evidence;
  if (options_.response == ResponseChoice::by_picture && response_belief_.asks_noise())
    evidence.srgb_by_noise = srgb_log_odds_by_noise(bgr);
  const auto is_large = [](const BallObservation& ball) { return ball.outline.radius_px >= small_ball_px; };
  const bool any_large = std::any_of(balls_.begin(), balls_.end(), is_large);
  for (const BallObservation& ball : balls_) {
    if (any_large && !is_large(ball)) continue;
    const ResponseEvidence of_ball = search_.verifier().fitter().response_evidence(bgr, before, ball.cone);
    evidence.srgb += of_ball.srgb;
    evidence.coarse_chroma += of_ball.coarse_chroma;
  }
  response_belief_.add(evidence);
  return &response() != &before;
}

// What edges and noise leave open of the camera, they leave open of the balls.
void Detector::admit_other_responses(const cv::Mat& bgr) {
  constexpr double least_probability = 1e-3;
  if (options_.fit != BallFit::sphere || options_.response != ResponseChoice::by_picture) return;
  for (const auto& [response, probability] : response_belief_.alternatives()) {
    if (probability < least_probability) continue;
    for (BallObservation& ball : balls_)
      search_.verifier().fitter().admit(*response, probability, bgr, options_.radius_of(ball.color_class),
                                        ball);
  }
}

}  // namespace ballservo
