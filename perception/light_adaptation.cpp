#include "perception/light_adaptation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/files/fault.hpp"
#include "calibration/files/numbers.hpp"

namespace ballservo {
namespace {

// A picture whose channels changed by less did not change its light.
constexpr double least_change = 0.05;
// Cells this near to black (12 grey levels) are noise: they stay as they were taught.
constexpr int dark_cells = 3;

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
  positive("agreement", agreement);
  fraction("min_quality", min_quality);
  fraction("min_fill", min_fill);
  positive("forget_s", forget_s);
  positive("table_step", table_step);
  if (slices < 1 || slices > ColorTable::side) faults.add("slices", std::to_string(slices), "1 to 64");
  faults.throw_if_any();
}

LightAdaptation::LightAdaptation(std::shared_ptr<const ColorTable> taught,
                                 const LightAdaptationOptions& options)
    : taught_(std::move(taught)), adapted_(std::make_shared<ColorTable>(*taught_)), options_(options) {
  options_.validate();
}

void LightAdaptation::begin(const cv::Mat& bgr) {
  picture_.take(bgr);
  sum_ = LogGain::Zero();
  balls_ = 0;
  at_once_ = false;
}

// Whether the whole picture changed, and as the surface did.
bool LightAdaptation::picture_agrees(const SurfaceColor& now, const SurfaceColor& before) const {
  const SurfaceColor change = picture_.change_since(then_);
  if (largest(change.log_bgr, change.known) < least_change) return false;
  const Known common = both(change.known, both(now.known, before.known));
  return any(common) && largest(now.log_bgr - before.log_bgr - change.log_bgr, common) <= options_.agreement;
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

bool LightAdaptation::assume_change(const cv::Mat& bgr, const OutlineEllipse& expected,
                                    const BallLight& light) {
  const SurfaceColor now = middle_color(bgr, expected);
  if (!picture_agrees(now, light.last)) return false;
  // The ball itself says best how much; the picture where the ball is clipped or dark.
  const SurfaceColor picture = picture_.change_since(then_);
  const Known by_ball = both(now.known, light.last.known);
  LogGain change = LogGain::Zero();
  Known known{};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto i = static_cast<Eigen::Index>(c);
    known[c] = by_ball[c] || picture.known[c];
    change[i] = by_ball[c] ? now.log_bgr[i] - light.last.log_bgr[i] : picture.log_bgr[i];
  }
  before_change_ = gain_;
  gain_ = options_.bounds.confine(gain_ + completed(change, known));
  rebuild();
  return true;
}

void LightAdaptation::settle_change(bool found) {
  if (found) return;
  gain_ = before_change_;
  rebuild();
}

void LightAdaptation::learn(const cv::Mat& bgr, const BallObservation& ball, BallLight& light) {
  if (ball.quality < options_.min_quality || ball.support.fill < options_.min_fill) return;
  const SurfaceColor now = middle_color(bgr, ball.outline);
  if (!any(now.known)) return;
  const Known common = both(now.known, light.last.known);
  const bool first = !any(light.last.known) || !any(both(now.known, light.reference.known));
  const bool sudden = !first && largest(now.log_bgr - light.last.log_bgr, common) > options_.sudden;
  const bool another_light = sudden && picture_agrees(now, light.last);
  light.last = now;
  ++balls_;
  if (first || (sudden && !another_light)) {  // another thing, or another side of it: the light is as it was
    light.reference = {now.log_bgr - gain_, now.known};
    sum_ += gain_;
    return;
  }
  at_once_ |= another_light;
  const Known known = both(now.known, light.reference.known);
  const LogGain here = gain_ + completed(now.log_bgr - light.reference.log_bgr - gain_, known);
  sum_ += here;
  for (std::size_t c = 0; c < 3; ++c) {  // a channel that comes out of the dark
    if (!now.known[c] || light.reference.known[c]) continue;
    const auto i = static_cast<Eigen::Index>(c);
    light.reference.known[c] = true;
    light.reference.log_bgr[i] = now.log_bgr[i] - here[i];
  }
}

void LightAdaptation::return_to_taught() {
  gain_ = LogGain::Zero();
  rebuild();
}

void LightAdaptation::finish(double time_s) {
  const double passed_s = std::clamp(time_s - time_s_, 0.0, 1.0);
  time_s_ = time_s;
  if (balls_ > 0) {
    const double share = at_once_ ? 1 : 1 - std::exp(-passed_s / options_.follow_s);
    gain_ = options_.bounds.confine(gain_ + share * (sum_ / balls_ - gain_));
    then_ = picture_;
    learnt_s_ = time_s;
  } else if (time_s - learnt_s_ > options_.forget_s) {
    gain_ = LogGain::Zero();
  }
  if (patched_rows_ == ColorTable::side && (gain_ - built_).abs().maxCoeff() > options_.table_step)
    start_patching();
  if (patched_rows_ < ColorTable::side) {
    const int end = std::min(ColorTable::side,
                             patched_rows_ + (ColorTable::side + options_.slices - 1) / options_.slices);
    patch_rows(patched_rows_, end);
    patched_rows_ = end;
  }
}

void LightAdaptation::start_patching() {
  built_ = gain_;
  patched_rows_ = 0;
  constexpr int levels = 256 / ColorTable::side;
  for (std::size_t c = 0; c < 3; ++c) {
    const double factor = std::exp(-built_[static_cast<Eigen::Index>(c)]);
    for (int cell = 0; cell < ColorTable::side; ++cell) {
      // What the taught light would have shown, clipped as the camera clips it.
      const double level = factor * (levels * cell + 0.5 * (levels - 1));
      taught_cell_[c][static_cast<std::size_t>(cell)] =
          static_cast<std::uint8_t>(std::min(255.0, level + 0.5) / levels);
    }
  }
}

// Rows of red of the table, whole planes of green and blue.
void LightAdaptation::patch_rows(int first, int end) {
  for (int r = first; r < end; ++r) {
    for (int g = 0; g < ColorTable::side; ++g) {
      const int taught_row = (taught_cell_[2][static_cast<std::size_t>(r)] << 12) |
                             (taught_cell_[1][static_cast<std::size_t>(g)] << 6);
      const ClassIndex* const from = &taught_->table[static_cast<std::size_t>(taught_row)];
      const auto row = static_cast<std::size_t>((r << 12) | (g << 6));
      ClassIndex* const to = &adapted_->table[row];
      for (std::size_t b = 0; b < ColorTable::side; ++b) to[b] = from[taught_cell_[0][b]];
      if (r < dark_cells && g < dark_cells) std::copy_n(&taught_->table[row], dark_cells, to);
    }
  }
}

void LightAdaptation::rebuild() {
  start_patching();
  patch_rows(0, ColorTable::side);
  patched_rows_ = ColorTable::side;
}

}  // namespace ballservo
