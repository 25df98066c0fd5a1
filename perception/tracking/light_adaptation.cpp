#include "perception/tracking/light_adaptation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
namespace ballservo {
namespace {

// A picture whose channels changed by less did not change its light.
constexpr double least_change = 0.05;

constexpr double follow_s = 0.15;  // time constant of following
constexpr double sudden_change_log =
    0.12;                       // change of a ball's log channel from picture to picture that is a jump
constexpr double trust = 1.25;  // times what the picture says a slow change may be
constexpr double drift_s = 30;  // over which is forgotten what the pictures alone say
// Of a ball to be learnt from; what is half covered says little.
constexpr double min_quality = 0.3, min_fill = 0.4;
constexpr double forget_s = 300;  // without a ball, and the taught light is back
// A change of level that the taught table serves by itself (log channels), having been learnt with some room.
constexpr double level_room = 0.2;

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
LogGain agreed(const LogGain& balls, const LogGain& picture, double trusted) {
  const Eigen::Array3d seen = trusted * light_coordinates(picture);
  return gain_of(light_coordinates(balls).max(seen.min(0.0)).min(seen.max(0.0)));
}

}  // namespace

void LightAdaptation::begin(const cv::Mat& bgr) {
  previous_ = picture_;
  picture_.take(bgr);
  const SurfaceColor change = picture_.change_since(previous_);
  belief_.picture_change += completed(change.log_bgr, change.known);
  votes_ = {};
  jumped_ = false;
}

bool LightAdaptation::may_be_taught_light() const {
  const SurfaceColor change = picture_.change_since(then_);
  double along = 0, whole = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    if (!change.known[c]) continue;
    const auto i = static_cast<Eigen::Index>(c);
    along -= change.log_bgr[i] * belief_.gain[i];
    whole += belief_.gain[i] * belief_.gain[i];
  }
  return along > 0.5 * whole && whole > least_change * least_change;
}

bool LightAdaptation::assume_change() {
  const SurfaceColor change = picture_.change_since(then_);
  if (largest(change.log_bgr, change.known) < least_change) return false;
  before_jump_ = belief_.gain;
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
  return agreed(ball, picture, trust);
}

void LightAdaptation::jump(const LogGain& change) {
  believe(confined(belief_.gain + change));
  jumped_ = true;
}

void LightAdaptation::learn(const cv::Mat& bgr, const BallObservation& ball, BallLight& light) {
  if (ball.quality < min_quality || ball.support.fill < min_fill) return;
  const SurfaceColor now = middle_color(bgr, ball.outline);
  if (!any(now.known)) return;
  const SurfaceColor last = std::exchange(light.last, now);
  const bool sudden = largest(now.log_bgr - last.log_bgr, both(now.known, last.known)) > sudden_change_log;
  if (!any(both(now.known, light.reference.known)) || sudden) {
    if (sudden && !jumped_) jump(sudden_change(now, last));
    light.reference = {now.log_bgr - belief_.gain, now.known};
  }
  // What the ball is too dark or too bright to say, the picture says.
  LogGain here = belief_.start + belief_.picture_change;
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
  votes_.sum += here;
  ++votes_.balls;
}

void LightAdaptation::return_to_taught() {
  believe(LogGain::Zero());
  serve_light();
}

void LightAdaptation::finish(double time_s) {
  const double passed_s = std::clamp(time_s - time_s_, 0.0, 1.0);
  time_s_ = time_s;
  if (votes_.balls > 0) {
    const LogGain change = votes_.sum / votes_.balls - belief_.start;
    const LogGain seen = confined(belief_.start + agreed(change, belief_.picture_change, trust));
    belief_.gain += (1 - std::exp(-passed_s / follow_s)) * (seen - belief_.gain);
    // What the pictures alone say is forgotten: their sum drifts, and would bear out anything in the end.
    belief_.picture_change += std::min(1.0, passed_s / drift_s) *
                              (agreed(change, belief_.picture_change, 1) - belief_.picture_change);
    then_ = picture_;
    learnt_s_ = time_s;
  } else {
    believe(time_s - learnt_s_ > forget_s ? LogGain(LogGain::Zero()) : belief_.gain);
  }
  serve_light();
}

void LightAdaptation::believe(const LogGain& gain) { belief_ = {gain, gain, LogGain::Zero()}; }

// The light that colours should be looked up for: the taught one serves a little further than it was taught,
// in level above all.
LogGain LightAdaptation::table_gain() {
  Eigen::Array3d light = light_coordinates(belief_.gain);
  const double room = level_room * std::sqrt(3.0);
  light[0] -= std::clamp(light[0], -room, room);
  const LogGain gain = gain_of(light);
  significant_ = gain.abs().maxCoeff() > (significant_ ? 0.5 : 1.0) * significant_gain;
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
