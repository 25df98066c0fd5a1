#include "perception/tracking/tracker.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "perception/tracking/streak.hpp"

namespace ballservo {
namespace {

// A ball is predicted unseen for so long, at most so many times as long as it was followed.
constexpr double max_coast_s = 1.0, max_coast_ratio = 3;
// Squared Mahalanobis distance: 99.9 % of chi-square with 3 degrees of freedom.
constexpr double gate_distance2 = 16.27;
// A lone ball of the class that lies so near an unmatched track continues it.
constexpr double jump_radii = 6;
// A ball's outline is sought so near the prediction, before its region is. And where its region shows no
// ball, so near it and places up to a spread beside it, as where what carries the ball stops or turns.
constexpr double search_reach_px = 5, search_reach_radii = 0.15, spread_radii = 0.6;
// Outlines of larger balls say enough; what does not show them in a film is seldom one.
constexpr double most_thorough_px = 18;
// A ball that moves less between two pictures, or whose edge is less blurred, is not smeared.
constexpr double least_streak_radii = 0.7, sharp_edge_radii = 0.05, sharp_edge_px = 1.5;
// Another light is sought so many lights a picture: often the likeliest ones, after so many pictures all.
constexpr std::size_t lights_a_picture = 3, likeliest_lights = 12;
constexpr long between_searches_of_all = 300;
// Suffices for a ball where a confirmed track expects it.
constexpr double expected_quality = 0.17;
// A detection that is not clear continues a track only in the size that is expected, to such a tolerance of
// the distance's logarithm.
constexpr double clear_quality = 0.5, weak_log_size = 0.12;
// What is clear and not believed is looked at again in so many pictures, then in every so many.
constexpr int tried_pictures = 10, tried_every = 5;

// By its motion since the picture before.
bool is_smeared(const BallObservation& before, const BallObservation& ball) {
  const double moved_px = (ball.outline.center_px - before.outline.center_px).norm();
  return moved_px >= least_streak_radii * ball.outline.radius_px &&
         ball.blur_px >= std::max(sharp_edge_px, sharp_edge_radii * ball.outline.radius_px);
}

}  // namespace

Tracker::Tracker(Detector detector, const TrackerOptions& options)
    : detector_(std::move(detector)), options_(options), look_alikes_(detector_.colors().classes.size()) {
  if (!options_.fixed_colors) light_.emplace();
  if (!options_.seek_light_at_once) put_off_light_search();
}

const std::vector<Track>& Tracker::update(const cv::Mat& bgr, double time_s, DetectionStages* stages) {
  if (!(time_s > time_s_)) return tracks_;
  interval_s_ = time_s - std::exchange(time_s_, time_s);
  left_out_ = {};
  for (Followed& followed : followed_) followed.filter.predict(time_s);
  if (light_) {
    light_->begin(bgr);
    choose_light();
  }

  look(bgr, stages);
  if (light_ && options_.seek_light) seek_light(bgr);
  match();
  if (light_) look_under_another_light(bgr);
  // Once for each detection: a filter that starts or is restarted from one knows it already.
  for (Followed& followed : followed_)
    if (followed.detection) followed.filter.correct(features_of(seen_[*followed.detection]));
  continue_jumps();
  for (Followed& followed : followed_)
    if (followed.detection) gather_evidence(bgr, followed);
  rejoin_newcomers();

  for (Followed& followed : followed_) {
    if (followed.detection)
      see(followed, seen_[*followed.detection], time_s);
    else
      miss(followed, time_s, bgr.size());
  }
  followed_.erase(
      std::remove_if(followed_.begin(), followed_.end(), [](const Followed& f) { return f.ended; }),
      followed_.end());
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    if (is_taken(i) || seen_[i].quality < min_ball_quality) continue;
    Followed newcomer{{next_id_++, seen_[i].color_class, TrackState::tentative, seen_[i]},
                      TrackFilter(features_of(seen_[i]), time_s)};
    newcomer.born_s = time_s;
    newcomer.detection = i;
    gather_evidence(bgr, newcomer);
    see(newcomer, seen_[i], time_s);
    followed_.push_back(newcomer);
  }
  count_look_alikes();
  ++pictures_;
  learn_colors(bgr);
  if (light_) light_->finish(time_s);
  tracks_.clear();
  for (const Followed& followed : followed_)
    if (is_shown(followed)) tracks_.push_back(followed.track);
  return tracks_;
}

// What is not clear is looked at again; what is not believed, too, at first and then now and then. But a
// streak is no circle.
void Tracker::gather_evidence(const cv::Mat& bgr, Followed& followed) {
  const BallObservation& ball = seen_[*followed.detection];
  const bool is_circle = ball.support.fill > 0, small = ball.outline.radius_px < small_ball_px;
  const int pictures = followed.evidence.pictures();
  const bool is_tried = followed.track.state == TrackState::tentative &&
                        (pictures < tried_pictures || pictures % tried_every == 0);
  std::optional<double> log_odds;
  if (is_circle && (small || ball.quality < doubtful_quality || is_tried))
    log_odds = detector_.log_odds(bgr, ball);
  followed.evidence.see(ball.outline.radius_px, log_odds, is_smeared(followed.track.ball, ball));
}

// A known ball's place has no other ball in it: what is seen there in another size is the known one, in part.
bool Tracker::is_shown(const Followed& followed) const {
  if (followed.track.state != TrackState::tentative) return true;
  return followed.detection && !followed.evidence.is_unlikely() &&
         std::none_of(followed_.begin(), followed_.end(), [&](const Followed& other) {
           return other.track.state != TrackState::tentative &&
                  same_ball(other.track.ball, followed.track.ball);
         });
}

// Where no ball is known, the light may be the one that was last seen or, if the picture says so, the taught
// one again: they take turns until one of them shows a ball.
void Tracker::choose_light() {
  if (followed_.empty()) {
    // What was found in it was no ball, or was missed for a moment.
    if (!is_light_believed_ && pictures_ >= next_light_search_) light_->assume({});
    taught_light_ = !taught_light_ && light_->may_be_taught_light();
  }
  set_light();
}

void Tracker::set_light() { detector_.set_light(taught_light_ ? LightCells::as_taught() : light_->cells()); }

std::optional<AssumedLight> Tracker::assumed_light() const {
  const bool is_other = is_light_believed_ && light_ && !light_->assumed().is_taught();
  return is_other ? std::optional(light_->assumed()) : std::nullopt;
}

// The colours may have been taught in another light than that of the pictures, which then shows no sure ball.
// That takes as long as dozens of looks: at first it is sought at once, later a few lights a picture.
void Tracker::seek_light(const cv::Mat& bgr) {
  const bool knows_ball = std::any_of(followed_.begin(), followed_.end(), [](const Followed& followed) {
    return followed.track.state != TrackState::tentative;
  });
  if (knows_ball) {
    next_light_search_ = pictures_ + newcomers_every;
    next_search_of_all_ = pictures_ + between_searches_of_all;
  }
  if (pictures_ < next_light_search_) return;
  if (!other_lights_) other_lights_.emplace(detector_);
  if (pictures_ == next_light_search_) {
    if (see_sure_balls(bgr, LightSearch::least_log_odds)) return put_off_light_search();
    const bool all = pictures_ >= next_search_of_all_;
    other_lights_->begin(all ? LightSearch::all_lights : likeliest_lights);
    if (all) next_search_of_all_ = pictures_ + between_searches_of_all;
  }
  const std::optional<LightSearch::Found> found =
      other_lights_->go_on(bgr, pictures_ == 0 ? LightSearch::all_lights : lights_a_picture);
  if (other_lights_->is_done()) put_off_light_search();
  if (!found) return;
  light_->assume(found->light);
  is_light_believed_ = taught_light_ = false;
  set_light();
  detector_.forget_response();
  seen_.clear();
  see_sure_balls(bgr, found->least_log_odds);
}

void Tracker::put_off_light_search() { next_light_search_ = pictures_ + newcomers_every; }

bool Tracker::see_sure_balls(const cv::Mat& bgr, double least_log_odds) {
  bool any = false;
  for (const BallObservation& ball : detector_.detect(bgr)) {
    if (detector_.log_odds(bgr, ball) < least_log_odds) continue;
    add_new(ball);
    any = true;
  }
  return any;
}

// A confirmed ball is missing: perhaps the light has changed at once.
void Tracker::look_under_another_light(const cv::Mat& bgr) {
  const auto missing = std::find_if(followed_.begin(), followed_.end(), [](const Followed& followed) {
    return followed.track.state != TrackState::tentative && !followed.detection;
  });
  if (missing == followed_.end() || !light_->assume_change()) return;
  set_light();
  look(bgr, nullptr);
  match();
  const auto& detection = missing->detection;
  const bool is_there = detection && seen_[*detection].quality >= min_ball_quality;
  light_->settle_change(is_there);
  if (is_there) return;
  set_light();
  look(bgr, nullptr);
  match();
}

// Of confirmed balls, and what they say of the light.
void Tracker::learn_colors(const cv::Mat& bgr) {
  for (Followed& followed : followed_) {
    const BallObservation& ball = followed.track.ball;
    if (followed.track.state != TrackState::confirmed) continue;
    if (!light_) {
      if (ball.quality >= clear_quality && ball.support.fill > 0)
        followed.light.last = middle_color(bgr, ball.outline);
      continue;
    }
    if (std::exchange(taught_light_, false)) light_->assume({});
    light_->learn(bgr, ball, followed.light);
  }
}

bool Tracker::is_taken(std::size_t seen) const {
  return std::any_of(followed_.begin(), followed_.end(),
                     [&](const Followed& followed) { return followed.detection == seen; });
}

// Other things of its class and size tell what this one may be.
bool Tracker::is_believed(const Followed& followed) const {
  return followed.evidence.suffices(look_alikes_.near(followed.track.color_class, followed.evidence));
}

void Tracker::count_look_alikes() {
  look_alikes_.begin();
  for (const Followed& followed : followed_)
    if (followed.track.state == TrackState::tentative)
      look_alikes_.add(followed.track.color_class, followed.evidence);
}

// Near the predictions first, where a weak detection suffices; the whole picture when a ball is missing
// there, and now and then for newcomers.
void Tracker::look(const cv::Mat& bgr, DetectionStages* stages) {
  seen_.clear();
  const bool newcomers = followed_.empty() || pictures_ % newcomers_every == 0;
  look_near_predictions(bgr);
  const bool all_found = std::all_of(followed_.begin(), followed_.end(),
                                     [&](const Followed& followed) { return is_seen(followed); });
  if (!newcomers && all_found) return;
  // As a window: what doubtful things are, the pictures to come tell.
  detect(bgr, {{0, 0}, bgr.size()}, all_found ? min_ball_quality : expected_quality, stages);
  if (seen_.empty() && pictures_ % newcomers_every == 0) detect_thoroughly(bgr);
}

void Tracker::detect(const cv::Mat& bgr, const cv::Rect& window, double min_quality,
                     DetectionStages* stages) {
  for (const BallObservation& ball : detector_.detect(bgr, window, stages, min_quality)) add_new(ball);
  left_out_.add(detector_.left_out());
}

// Where `detect` has just found none.
void Tracker::detect_thoroughly(const cv::Mat& bgr) {
  for (const BallObservation& ball : detector_.detect_thoroughly(bgr))
    if (ball.outline.radius_px < most_thorough_px) add_new(ball);
}

void Tracker::add_new(const BallObservation& ball) {
  if (std::none_of(seen_.begin(), seen_.end(),
                   [&](const BallObservation& other) { return same_ball(ball, other); }))
    seen_.push_back(ball);
}

void Tracker::look_near_predictions(const cv::Mat& bgr) {
  for (const Followed& followed : followed_) {
    const TangentCone cone = cone_of(followed.filter.value());
    const auto outline = project_sphere(detector_.rays().camera(), cone.axis, std::sin(cone.alpha_rad));
    if (!outline) continue;
    const Eigen::Vector3d variance = followed.filter.variance();
    const double spread_radii = std::sqrt(std::max(variance.x(), variance.y())) / cone.alpha_rad;
    const double reach = outline->radius_px * (2 + std::min(4.0, 3 * spread_radii)) + 8;
    const Eigen::Vector2d& c = outline->center_px;
    if (!(c.cwiseAbs().maxCoeff() < 1e6) || !(reach < 1e6)) continue;
    const cv::Rect window(static_cast<int>(c.x() - reach), static_cast<int>(c.y() - reach),
                          static_cast<int>(2 * reach) + 1, static_cast<int>(2 * reach) + 1);
    if ((window & cv::Rect({0, 0}, bgr.size())).empty()) continue;
    const auto look_for_it = [&](double near_px, double spread_px, bool clearly) {
      const double min_quality = clearly ? min_ball_quality : expected_quality;
      const double size_sigma = clearly ? 0 : std::sqrt(variance.z());
      const auto ball = detector_.find_expected(
          bgr, window, {followed.track.color_class, cone, near_px, spread_px, min_quality, size_sigma},
          clearly, [&](const BallObservation& found) { return is_plausible(followed, found); });
      if (ball) add_new(*ball);
      return is_seen(followed);
    };
    // Where it is expected, or else anywhere near; a weak detection suffices where no clear one is had.
    if (!look_for_it(search_reach_px, 0, true)) {
      for (const double quality : {min_ball_quality, expected_quality}) {
        if (is_seen(followed)) break;
        detect(bgr, window, quality, nullptr);
      }
      if (!is_seen(followed)) detect_thoroughly(bgr);
      if (!is_seen(followed) && followed.track.state != TrackState::tentative)
        look_for_it(std::max(search_reach_px, search_reach_radii * outline->radius_px),
                    spread_radii * outline->radius_px, false);
    }
    if (followed.track.state != TrackState::tentative) look_for_streak(bgr, followed, *outline);
  }
}

// A ball that flies fast has no edge, or one that misleads: it is sought as what the shutter makes of it.
void Tracker::look_for_streak(const cv::Mat& bgr, const Followed& followed, const OutlineEllipse& expected) {
  const Camera& camera = detector_.rays().camera();
  const Eigen::Vector3d value = followed.filter.value(), moved = interval_s_ / 2 * followed.filter.velocity();
  const auto from = camera.project(cone_of(value - moved).axis),
             to = camera.project(cone_of(value + moved).axis);
  const SurfaceColor& color = followed.light.last;
  const auto seen = std::find_if(seen_.begin(), seen_.end(),
                                 [&](const BallObservation& ball) { return is_plausible(followed, ball); });
  if (seen != seen_.end() && seen->blur_px < sharp_edge_radii * seen->outline.radius_px) return;
  if (!from || !to || (*to - *from).norm() < least_streak_radii * expected.radius_px || !color.known.any())
    return;
  auto ball = find_streak(bgr, camera, detector_.response(), color.log_bgr.exp().matrix(),
                          {expected.center_px, *to - *from, expected.radius_px},
                          detector_.options().radius_of(followed.track.color_class));
  if (!ball) return;
  ball->color_class = followed.track.color_class;
  if (seen != seen_.end())
    *seen = *ball;
  else
    add_new(*ball);
}

bool Tracker::is_seen(const Followed& followed) const {
  return std::any_of(seen_.begin(), seen_.end(),
                     [&](const BallObservation& ball) { return is_plausible(followed, ball); });
}

bool Tracker::is_plausible(const Followed& followed, const BallObservation& ball) const {
  if (ball.color_class != followed.track.color_class) return false;
  const BallFeatures measured = features_of(ball);
  if (!(followed.filter.distance2(measured) < gate_distance2)) return false;
  // A weak detection counts only of a ball that is known, and only in its size: two balls that hide each
  // other look like one larger ball.
  if (ball.quality < min_ball_quality && followed.track.state == TrackState::tentative) return false;
  return ball.quality >= clear_quality ||
         std::abs(measured.value.z() - followed.filter.value().z()) < weak_log_size;
}

// The likeliest pair first, confirmed tracks before tentative ones: one ball a track, and one track a ball.
void Tracker::match() {
  for (Followed& followed : followed_) followed.detection.reset();
  pairs_.clear();
  for (std::size_t i = 0; i < followed_.size(); ++i) {
    for (std::size_t k = 0; k < seen_.size(); ++k) {
      if (!is_plausible(followed_[i], seen_[k])) continue;
      const BallFeatures measured = features_of(seen_[k]);
      const double negative_log_likelihood = followed_[i].filter.negative_log_likelihood(measured);
      pairs_.push_back({followed_[i].track.state == TrackState::tentative, negative_log_likelihood, i, k});
    }
  }
  std::sort(pairs_.begin(), pairs_.end(), [](const Pair& a, const Pair& b) {
    return std::tie(a.tentative, a.negative_log_likelihood, a.followed, a.seen) <
           std::tie(b.tentative, b.negative_log_likelihood, b.followed, b.seen);
  });
  for (const Pair& pair : pairs_)
    if (!is_taken(pair.seen) && !followed_[pair.followed].detection)
      followed_[pair.followed].detection = pair.seen;
}

// Near enough to where a missing ball is predicted to be that ball, and of its size.
bool Tracker::may_be_missing_one(const Followed& missing, const BallObservation& ball) const {
  const TangentCone expected = cone_of(missing.filter.value());
  const double ratio = ball.cone.alpha_rad / expected.alpha_rad;
  return !missing.detection && ball.color_class == missing.track.color_class && ratio > 0.6 && ratio < 1.67 &&
         angle_between(ball.cone.axis, expected.axis) < jump_radii * expected.alpha_rad;
}

// A throw or a knock outruns the filter: one unmatched ball near one unmatched track is the same ball.
void Tracker::continue_jumps() {
  for (Followed& followed : followed_) {
    std::size_t candidate = seen_.size();
    int candidates = 0;
    for (std::size_t k = 0; k < seen_.size(); ++k) {
      if (!is_taken(k) && seen_[k].quality >= clear_quality && may_be_missing_one(followed, seen_[k]))
        candidate = k, ++candidates;
    }
    if (candidates != 1) continue;
    followed.detection = candidate;
    followed.filter.correct_after_jump(features_of(seen_[candidate]));
  }
}

// A ball less clear than that becomes a track of its own; believed, it is the one that has been missing ever
// since it appeared.
void Tracker::rejoin_newcomers() {
  for (Followed& newcomer : followed_) {
    if (newcomer.track.state != TrackState::tentative || !newcomer.detection || !is_believed(newcomer))
      continue;
    const auto is_missing = [&](const Followed& followed) {
      return followed.track.state == TrackState::coasting && followed.seen_s < newcomer.born_s &&
             may_be_missing_one(followed, seen_[*newcomer.detection]);
    };
    const auto missing = std::find_if(followed_.begin(), followed_.end(), is_missing);
    if (missing == followed_.end() || std::any_of(missing + 1, followed_.end(), is_missing)) continue;
    missing->filter = newcomer.filter;
    missing->detection = std::exchange(newcomer.detection, std::nullopt);
  }
}

// What was believed too early is believed no longer.
void Tracker::see(Followed& followed, const BallObservation& ball, double time_s) {
  followed.seen_s = time_s;
  followed.track.ball = ball;
  if (followed.track.state != TrackState::tentative || is_believed(followed))
    followed.track.state = TrackState::confirmed;
  const bool is_confirmed = followed.track.state == TrackState::confirmed;
  followed.ended = is_confirmed && followed.evidence.is_unlikely();
  is_light_believed_ |= is_confirmed && !followed.ended;
}

// A tentative ball that is missed more often than seen was none; a confirmed one is predicted for a while, as
// long as it is in view.
void Tracker::miss(Followed& followed, double time_s, const cv::Size& picture) {
  Track& track = followed.track;
  if (track.state == TrackState::tentative) {
    followed.evidence.miss();
    followed.ended = followed.evidence.is_refuted();
    return;
  }
  if (track.state == TrackState::confirmed) followed.filter.lose();
  const TangentCone cone = cone_of(followed.filter.value());
  const auto outline = project_sphere(detector_.rays().camera(), cone.axis, std::sin(cone.alpha_rad));
  const bool in_view = outline && outline->center_px.x() > -outline->radius_px &&
                       outline->center_px.y() > -outline->radius_px &&
                       outline->center_px.x() < picture.width + outline->radius_px &&
                       outline->center_px.y() < picture.height + outline->radius_px;
  const double followed_s = followed.seen_s - followed.born_s;
  const double coast_s = std::min(max_coast_s, max_coast_ratio * followed_s);
  if (!in_view || time_s - followed.seen_s > coast_s) {
    followed.ended = true;
    return;
  }
  track.state = TrackState::coasting;
  BallObservation predicted;
  predicted.color_class = track.color_class;
  predicted.cone = cone;
  predicted.outline = *outline;
  if (track.ball.position) {
    predicted.position = position_of(followed.filter.value(), followed.filter.variance(),
                                     detector_.options().radius_of(track.color_class));
  }
  track.ball = predicted;
}

}  // namespace ballservo
