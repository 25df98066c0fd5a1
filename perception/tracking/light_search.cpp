#include "perception/tracking/light_search.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {
namespace {

// A light against the taught one, in coordinates of light (log channels of the taught camera). Its level and
// temperature are about what the greys say; the standard deviations are of that. A tint no lamp has.
const Eigen::Array3d sigma(1.2, 0.18, 0.08);
// Or it is the taught light after all, in which the ball's colour could not be told from what is around it.
const Eigen::Array3d sigma_of_taught(0.4, 0.1, 0.05);
// The taught table bears half a step of each.
const Eigen::Array3d step(0.5, 0.22, 0.12);
// sRGB is close to the power 2.2 of the light. Pictures are mostly sRGB; the edges of a linear one say so.
constexpr double srgb_power = 2.2, log_other_response = -4, log_seen_linear = 2;
// That something is a ball does not say which: its light must be probable beside.
constexpr double least_log_prior = -3.5;
// Lights that are less probable than that by the greys alone are not tried.
constexpr double least_log_prior_tried = -2.5;
// So surely that no other light need be asked.
constexpr double sure_log_odds = 16;

double log_prior(const Eigen::Array3d& off, double power) {
  return -0.5 * (off / sigma).square().sum() + (power == 1 ? 0 : log_other_response);
}

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
  const auto add = [&](double power, int levels, int temperatures, int tints) {
    for (int level = -levels; level <= levels; ++level)
      for (int temperature = -temperatures; temperature <= temperatures; ++temperature)
        for (int tint = -tints; tint <= tints; ++tint) {
          const Eigen::Array3d off = step * Eigen::Array3d(level, temperature, tint);
          if (log_prior(off, 1) >= least_log_prior_tried) trials_.push_back({off, power});
        }
  };
  add(1, 4, 2, 1);
  add(1 / srgb_power, 1, 1, 0);
  add(srgb_power, 1, 1, 0);
  std::stable_sort(trials_.begin(), trials_.end(), [](const Trial& a, const Trial& b) {
    return log_prior(a.off, a.power) > log_prior(b.off, b.power);
  });
}

void LightSearch::begin(std::size_t likeliest) {
  next_trial_ = 0;
  end_ = std::min(likeliest, trials_.size());
  best_ = {};
}

std::optional<AssumedLight> LightSearch::go_on(const cv::Mat& bgr, std::size_t lights) {
  const LogGain greys = greys_of(bgr);
  for (; lights > 0 && !is_done(); --lights, ++next_trial_) {
    const Trial& trial = trials_[next_trial_];
    Eigen::Array3d by_greys = light_coordinates(trial.power * greys - taught_greys_);
    by_greys[2] = 0;
    const AssumedLight light{gain_of(by_greys + trial.off) / trial.power, trial.power};
    const Guess guess = look(bgr, light, by_greys);
    if (guess.log_odds <= best_.log_odds) continue;
    // Under the light that shows the ball's colour as it was taught, if that shows it still.
    const Guess again = look(bgr, guess.light, by_greys);
    best_ = again.log_odds > guess.log_odds - 1 ? again : Guess{light, guess.log_odds};
    if (best_.log_odds >= sure_log_odds) next_trial_ = end_ - 1;
  }
  if (!is_done() || best_.log_odds < least_log_odds) return std::nullopt;
  return best_.light;
}

LightSearch::Guess LightSearch::look(const cv::Mat& bgr, const AssumedLight& light,
                                     const Eigen::Array3d& by_greys) {
  detector_.set_light(cells_in(light));
  detector_.doubt_response();
  Guess best;
  for (const BallObservation& ball : detector_.detect(bgr)) {
    const AssumedLight refined = refined_by(bgr, ball, light);
    const Eigen::Array3d coordinates = light_coordinates(light.power * refined.gain);
    const CameraResponse& response = detector_.response();
    const bool linear = &response == &CameraResponse::linear(response.coarse_chroma);
    const double of_other =
        log_prior(coordinates - by_greys, light.power) + (light.power < 1 && linear ? log_seen_linear : 0);
    const double of_taught =
        light.power == 1 ? -0.5 * (coordinates / sigma_of_taught).square().sum() : of_other;
    const double prior = std::max(of_other, of_taught);
    if (prior < least_log_prior) continue;
    const double log_odds =
        detector_.log_odds(bgr, ball) + prior - log_look_alikes_by_size(ball.outline.radius_px);
    if (log_odds > best.log_odds) best = {refined, log_odds};
  }
  return best;
}

AssumedLight LightSearch::refined_by(const cv::Mat& bgr, const BallObservation& ball,
                                     const AssumedLight& light) const {
  const SurfaceColor now = middle_color(bgr, ball.outline), &taught = of_class_[ball.color_class - 1u];
  const double full = std::log(255);
  const LogGain gain = (now.log_bgr - full) - (taught.log_bgr - full) / light.power;
  AssumedLight refined = light;
  for (Eigen::Index c = 0; c < 3; ++c) {
    const auto channel = static_cast<std::size_t>(c);
    if (now.known[channel] && taught.known[channel]) refined.gain[c] = gain[c];
  }
  return refined;
}

}  // namespace ballservo
