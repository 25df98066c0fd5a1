#include "perception/tracking/light_search.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/base/statistics.hpp"

namespace ballservo {
namespace {

// Standard deviations of a light against the taught one, in coordinates of light (log channels of the taught
// camera). Its level and temperature are about what the greys say; a tint no lamp has.
const Eigen::Array3d sigma_by_greys(1.2, 0.18, 0.08);
// Or it is the taught light, brighter or dimmer, whatever colours are around the ball.
const Eigen::Array3d sigma_of_taught(1.0, 0.1, 0.05);
// The taught table bears half a step of each.
const Eigen::Array3d step(0.5, 0.22, 0.12);
// sRGB is close to the power 2.2 of the light. Pictures are mostly sRGB; the edges of a linear one say so.
constexpr double srgb_power = 2.2, log_other_response = -4, log_seen_linear = 2;
// That something is a ball does not say which: its light must be probable beside. 2 % of lights are less.
constexpr double least_log_prior = -4.9;
// Lights that are less probable than that by the greys alone are not tried.
constexpr double least_log_prior_tried = -2.5;
// So surely that no other light need be asked.
constexpr double sure_log_odds = 16;

double log_prior_of(double power) { return power == 1 ? 0 : log_other_response; }

double log_density(const Eigen::Array3d& off, const Eigen::Array3d& sigma) {
  return -0.5 * (off / sigma).square().sum();
}

// What is believed of a light: a normal distribution.
struct LightBelief {
  LogGain mean;
  Eigen::Array3d sigma;  // along the coordinates of light

  // The likeliest light with gains from `least` to `most`, and the log density of what those say.
  std::pair<LogGain, double> given(const LogGain& least, const LogGain& most) const {
    LogGain seen = least;
    for (Known known = least == most;;) {
      const auto likeliest = given(seen, known);
      const LogGain beyond = known.select(0, (least - likeliest.first).max(likeliest.first - most));
      Eigen::Index channel = 0;
      if (!(beyond.maxCoeff(&channel) > 0)) return likeliest;
      seen[channel] = std::clamp(likeliest.first[channel], least[channel], most[channel]);
      known[channel] = true;
    }
  }

 private:
  // The same where the gains of the known channels are as `seen`.
  std::pair<LogGain, double> given(const LogGain& seen, const Known& known) const {
    constexpr double variance_known = 1e-6, variance_unknown = 1e6;
    Eigen::Matrix3d axes;
    for (Eigen::Index i = 0; i < 3; ++i) axes.col(i) = gain_of(Eigen::Array3d(Eigen::Vector3d::Unit(i)));
    const Eigen::Matrix3d covariance = axes * sigma.square().matrix().asDiagonal() * axes.transpose();
    Eigen::Matrix3d of_seen = covariance;
    of_seen.diagonal().array() += known.select(Eigen::Array3d::Constant(variance_known), variance_unknown);
    const Eigen::Vector3d change = known.select(seen - mean, 0).matrix();
    const Eigen::Vector3d weighted = of_seen.ldlt().solve(change);
    return {mean + (covariance * weighted).array(), -0.5 * change.dot(weighted)};
  }
};

// The colour of a picture's greys as log channels, of what is neither dark nor clipped: half way between the
// mean of all surfaces and the brightest ones, which are white more often than not (Minkowski norms:
// Finlayson and Trezzi 2004, "Shades of gray and colour constancy").
class GreyMean {
 public:
  void add(int b, int g, int r, double weight) {
    if (std::min({b, g, r}) < 6 || std::max({b, g, r}) > 250) return;
    const Eigen::Array3d level(b / 255.0, g / 255.0, r / 255.0);
    logs_ += weight * level.log();
    powers_ += weight * level.pow(norm);
    weights_ += weight;
  }
  LogGain value() const {
    if (weights_ == 0) return LogGain::Constant(std::log(0.4));
    return 0.5 * (logs_ / weights_ + (powers_ / weights_).log() / norm);
  }

 private:
  static constexpr double norm = 12;
  Eigen::Array3d logs_ = Eigen::Array3d::Zero(), powers_ = Eigen::Array3d::Zero();
  double weights_ = 0;
};

LogGain greys_of(const cv::Mat& bgr) {
  constexpr int stride = 4;
  GreyMean mean;
  for (int v = 0; v < bgr.rows; v += stride)
    for (int u = 0; u < bgr.cols; u += stride) {
      const cv::Vec3b& c = bgr.at<cv::Vec3b>(v, u);
      mean.add(c[0], c[1], c[2], 1);
    }
  return mean.value();
}

LogGain greys_of(const OccupiedCells& cells) {
  GreyMean mean;
  const auto level = [](std::uint32_t cell, int c) {
    return static_cast<int>(4 * (cell >> (6 * c) & 63) + 2);
  };
  for (const CellCount& cell : cells)
    mean.add(level(cell.cell, 0), level(cell.cell, 1), level(cell.cell, 2), cell.count);
  return mean.value();
}

}  // namespace

LightSearch::LightSearch(const Detector& detector)
    : detector_(detector), taught_greys_(greys_of(detector.colors().background)) {
  for (const ColorClass& color_class : detector.colors().classes)
    of_class_.push_back(middle_color(color_class));
  const auto add = [&](const Eigen::Array3d& sigma, double power, int levels, int temperatures, int tints) {
    for (int level = -levels; level <= levels; ++level)
      for (int temperature = -temperatures; temperature <= temperatures; ++temperature)
        for (int tint = -tints; tint <= tints; ++tint) {
          const Eigen::Array3d off = step * Eigen::Array3d(level, temperature, tint);
          const double log_prior = log_density(off, sigma);
          if (log_prior >= least_log_prior_tried)
            trials_.push_back({off, power, &sigma == &sigma_of_taught, log_prior + log_prior_of(power)});
        }
  };
  add(sigma_by_greys, 1, 4, 2, 1);
  add(sigma_by_greys, 1 / srgb_power, 1, 1, 0);
  add(sigma_by_greys, srgb_power, 1, 1, 0);
  add(sigma_of_taught, 1, 4, 0, 0);
  std::stable_sort(trials_.begin(), trials_.end(),
                   [](const Trial& a, const Trial& b) { return a.log_prior > b.log_prior; });
}

void LightSearch::begin(std::size_t likeliest) {
  next_trial_ = 0;
  end_ = std::min(likeliest, trials_.size());
  things_.clear();
}

std::optional<LightSearch::Found> LightSearch::go_on(const cv::Mat& bgr, std::size_t lights,
                                                     double least_of_all) {
  const LogGain greys = greys_of(bgr);
  for (; lights > 0 && !is_done(); --lights, ++next_trial_) {
    const Trial& trial = trials_[next_trial_];
    const Eigen::Array3d about = trial.of_taught ? Eigen::Array3d::Zero() : by_greys(greys, trial.power);
    for (const Guess& guess : look(bgr, {gain_of(about + trial.off) / trial.power, trial.power}, greys)) {
      add(guess);
      if (guess.log_odds >= sure_log_odds) next_trial_ = end_ - 1;
    }
  }
  if (!is_done()) return std::nullopt;
  const Thing* likeliest = nullptr;
  for (const Thing& thing : things_) {
    const bool is_sure = thing.log_odds >= least_of_all || thing.best.log_odds >= least_log_odds;
    if (is_sure && (!likeliest || thing.log_odds > likeliest->log_odds)) likeliest = &thing;
  }
  if (!likeliest) return std::nullopt;
  Guess best = likeliest->best;
  // Rather under the light that shows the ball's colour as it was taught, if that shows it still.
  for (const Guess& again : look(bgr, best.refined, greys))
    if (again.log_odds > best.log_odds - 1) best = again;
  return Found{best.light, std::min(least_log_odds, best.second_look - 0.5)};
}

bool LightSearch::Guess::is_same_thing(const Guess& other) const {
  const double radius_px = other.outline.radius_px;
  return (outline.center_px - other.outline.center_px).norm() < 0.3 * radius_px &&
         std::abs(outline.radius_px - radius_px) < 0.3 * radius_px;
}

void LightSearch::add(const Guess& guess) {
  for (Thing& thing : things_) {
    if (!guess.is_same_thing(thing.best)) continue;
    const double more = std::max(guess.log_odds, thing.log_odds);
    thing.log_odds = more + std::log1p(std::exp(std::min(guess.log_odds, thing.log_odds) - more));
    if (guess.log_odds > thing.best.log_odds) thing.best = guess;
    return;
  }
  things_.push_back({guess, guess.log_odds});
}

// What the greys say of a light, in its coordinates against the taught one: nothing of its tint.
Eigen::Array3d LightSearch::by_greys(const LogGain& greys, double power) const {
  Eigen::Array3d coordinates = light_coordinates(power * greys - taught_greys_);
  coordinates[2] = 0;
  return coordinates;
}

const std::vector<LightSearch::Guess>& LightSearch::look(const cv::Mat& bgr, const AssumedLight& light,
                                                         const LogGain& greys) {
  detector_.set_light(cells_in(light));
  detector_.forget_response();
  guesses_.clear();
  for (const BallObservation& ball : detector_.detect(bgr)) {
    const SurfaceColor now = middle_color(bgr, ball.outline), &taught = of_class_[ball.color_class - 1u];
    const double full = std::log(255);
    LogGain least = light.power * (now.least() - full) - (taught.most() - full);
    LogGain most = light.power * (now.most() - full) - (taught.least() - full);
    if (!(now.known && taught.known).any())
      least = most = light.power * light.gain;  // it may be in this light
    const auto of_other =
        LightBelief{gain_of(by_greys(greys, light.power)), sigma_by_greys}.given(least, most);
    const auto of_taught = LightBelief{LogGain::Zero(), sigma_of_taught}.given(least, most);
    const auto& [gain, log_prior] =
        std::max(of_other, of_taught, [](const auto& a, const auto& b) { return a.second < b.second; });
    const CameraResponse& response = detector_.response();
    const bool linear = &response == &CameraResponse::linear(response.coarse_chroma);
    const double prior =
        log_prior + log_prior_of(light.power) + (light.power < 1 && linear ? log_seen_linear : 0);
    if (prior < least_log_prior) continue;
    const double second_look = detector_.log_odds(bgr, ball);
    const double log_odds = second_look + prior - log_look_alikes_by_size(ball.outline.radius_px);
    guesses_.push_back({light, {gain / light.power, light.power}, ball.outline, log_odds, second_look});
  }
  return guesses_;
}

LogGain light_of_balls(const cv::Mat& bgr, const std::vector<BallObservation>& balls,
                       const ColorTable& colors) {
  constexpr std::size_t least_balls = 2;
  constexpr double agreeing = 0.25, served = 0.35;  // log channels
  std::vector<LogGain> gains;
  for (const BallObservation& ball : balls) {
    const SurfaceColor now = middle_color(bgr, ball.outline);
    const SurfaceColor taught = middle_color(colors.classes[ball.color_class - 1u]);
    const Known known = now.known && taught.known;
    if (known.any()) gains.push_back(completed(now.log_bgr - taught.log_bgr, known));
  }
  if (gains.size() < least_balls) return LogGain::Zero();
  LogGain middle;
  for (Eigen::Index c = 0; c < 3; ++c) {
    std::vector<double> of_channel;
    for (const LogGain& gain : gains) of_channel.push_back(gain[c]);
    middle[c] = median(of_channel);
  }
  const auto agree =
      static_cast<std::size_t>(std::count_if(gains.begin(), gains.end(), [&](const LogGain& gain) {
        return (gain - middle).abs().maxCoeff() < agreeing;
      }));
  if (agree < least_balls || 3 * agree < 2 * gains.size() || middle.abs().maxCoeff() < served)
    return LogGain::Zero();
  return confined(middle);
}

}  // namespace ballservo
