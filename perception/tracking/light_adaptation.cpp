#include "perception/tracking/light_adaptation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {
namespace {

// A picture whose channels changed by less did not change its light.
constexpr double least_change = 0.05;

using Known = std::array<bool, 3>;

Known both(const Known& a, const Known& b) { return {a[0] && b[0], a[1] && b[1], a[2] && b[2]}; }
bool any(const Known& known) { return known[0] || known[1] || known[2]; }

double largest(const LogGain& change, const Known& known) {
  double result = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    if (known[c]) result = std::max(result, std::abs(change[static_cast<Eigen::Index>(c)]));
  }
  return result;
}

// As much of what the balls say as the picture says too, in level and in colour apart (a ball that rolls into
// a shadow changes its level alone).
LogGain agreed(const LogGain& balls, const LogGain& picture, double trust) {
  const Eigen::Array3d seen = trust * light_coordinates(picture);
  return gain_of(light_coordinates(balls).max(seen.min(0.0)).min(seen.max(0.0)));
}

}  // namespace

void LightAdaptationOptions::validate() const {
  FaultList faults;
  const auto positive = [&](const char* name, double value) {
    if (!(value > 0) || !std::isfinite(value)) faults.add(name, number_text(value), "a number above 0");
  };
  const auto fraction = [&](const char* name, double value) {
    if (!(value >= 0 && value <= 1)) faults.add(name, number_text(value), "a number from 0 to 1");
  };
  positive("bounds.level", bounds.level);
  positive("bounds.temperature", bounds.temperature);
  positive("bounds.tint", bounds.tint);
  positive("follow_s", follow_s);
  positive("sudden", sudden);
  positive("trust", trust);
  positive("drift_s", drift_s);
  fraction("min_quality", min_quality);
  fraction("min_fill", min_fill);
  positive("forget_s", forget_s);
  positive("significant", significant);
  positive("level_room", level_room);
  faults.throw_if_any();
}

LightAdaptation::LightAdaptation(const LightAdaptationOptions& options) : options_(options) {
  options_.validate();
}

void LightAdaptation::begin(const cv::Mat& bgr) {
  previous_ = picture_;
  picture_.take(bgr);
  const SurfaceColor change = picture_.change_since(previous_);
  picture_change_ += completed(change.log_bgr, change.known);
  sum_ = LogGain::Zero();
  balls_ = 0;
  jumped_ = false;
}

bool LightAdaptation::may_be_taught_light() const {
  const SurfaceColor change = picture_.change_since(then_);
  double along = 0, whole = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    if (!change.known[c]) continue;
    const auto i = static_cast<Eigen::Index>(c);
    along -= change.log_bgr[i] * gain_[i];
    whole += gain_[i] * gain_[i];
  }
  return along > 0.5 * whole && whole > least_change * least_change;
}

bool LightAdaptation::assume_change() {
  const SurfaceColor change = picture_.change_since(then_);
  if (largest(change.log_bgr, change.known) < least_change) return false;
  before_jump_ = gain_;
  jump(completed(change.log_bgr, change.known));
  serve_light();
  return true;
}

void LightAdaptation::settle_change(bool found) {
  if (found) return;
  jumped_ = false;
  believe(before_jump_);
  serve_light();
}

// What the picture says of a sudden change of a ball; nothing where it did not change.
LogGain LightAdaptation::sudden_change(const SurfaceColor& now, const SurfaceColor& last) const {
  const SurfaceColor change = picture_.change_since(then_);
  if (largest(change.log_bgr, change.known) < least_change) return LogGain::Zero();
  const LogGain picture = completed(change.log_bgr, change.known);
  LogGain ball = picture;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto i = static_cast<Eigen::Index>(c);
    if (now.known[c] && last.known[c]) ball[i] = now.log_bgr[i] - last.log_bgr[i];
  }
  return agreed(ball, picture, options_.trust);
}

void LightAdaptation::jump(const LogGain& change) {
  believe(options_.bounds.confine(gain_ + change));
  jumped_ = true;
}

void LightAdaptation::learn(const cv::Mat& bgr, const BallObservation& ball, BallLight& light) {
  if (ball.quality < options_.min_quality || ball.support.fill < options_.min_fill) return;
  const SurfaceColor now = middle_color(bgr, ball.outline);
  if (!any(now.known)) return;
  const SurfaceColor last = std::exchange(light.last, now);
  const bool sudden = largest(now.log_bgr - last.log_bgr, both(now.known, last.known)) > options_.sudden;
  if (!any(both(now.known, light.reference.known)) || sudden) {
    if (sudden && !jumped_) jump(sudden_change(now, last));
    light.reference = {now.log_bgr - gain_, now.known};
  }
  // What the ball is too dark or too bright to say, the picture says.
  LogGain here = start_ + picture_change_;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto i = static_cast<Eigen::Index>(c);
    if (!now.known[c]) continue;
    if (light.reference.known[c]) {
      here[i] = now.log_bgr[i] - light.reference.log_bgr[i];
    } else {  // a channel that comes out of the dark
      light.reference.known[c] = true;
      light.reference.log_bgr[i] = now.log_bgr[i] - here[i];
    }
  }
  sum_ += here;
  ++balls_;
}

void LightAdaptation::return_to_taught() {
  believe(LogGain::Zero());
  serve_light();
}

void LightAdaptation::finish(double time_s) {
  const double passed_s = std::clamp(time_s - time_s_, 0.0, 1.0);
  time_s_ = time_s;
  if (balls_ > 0) {
    const LogGain change = sum_ / balls_ - start_;
    const LogGain seen = options_.bounds.confine(start_ + agreed(change, picture_change_, options_.trust));
    gain_ += (1 - std::exp(-passed_s / options_.follow_s)) * (seen - gain_);
    // What the pictures alone say is forgotten: their sum drifts, and would bear out anything in the end.
    picture_change_ +=
        std::min(1.0, passed_s / options_.drift_s) * (agreed(change, picture_change_, 1) - picture_change_);
    then_ = picture_;
    learnt_s_ = time_s;
  } else {
    believe(time_s - learnt_s_ > options_.forget_s ? LogGain(LogGain::Zero()) : gain_);
  }
  serve_light();
}

void LightAdaptation::believe(const LogGain& gain) {
  gain_ = start_ = gain;
  picture_change_ = LogGain::Zero();
}

// The light that colours should be looked up for: the taught one serves a little further than it was taught,
// in level above all.
LogGain LightAdaptation::table_gain() {
  Eigen::Array3d light = light_coordinates(gain_);
  const double room = options_.level_room * std::sqrt(3.0);
  light[0] -= std::clamp(light[0], -room, room);
  const LogGain gain = gain_of(light);
  significant_ = gain.abs().maxCoeff() > (significant_ ? 0.5 : 1.0) * options_.significant;
  return significant_ ? gain : LogGain(LogGain::Zero());
}

void LightAdaptation::serve_light() {
  const LogGain gain = table_gain();
  constexpr int levels = 256 / ColorTable::side;
  for (std::size_t c = 0; c < 3; ++c) {
    const double factor = std::exp(-gain[static_cast<Eigen::Index>(c)]);
    for (int cell = 0; cell < ColorTable::side; ++cell) {
      // What the taught light would have shown, clipped as the camera clips it.
      const double level = factor * (levels * cell + 0.5 * (levels - 1));
      cells_.taught_cell[c][static_cast<std::size_t>(cell)] =
          static_cast<std::uint8_t>(std::min(255.0, level + 0.5) / levels);
    }
  }
}

}  // namespace ballservo
