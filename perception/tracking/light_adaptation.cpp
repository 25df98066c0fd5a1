#include "perception/tracking/light_adaptation.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ballservo {
namespace {

// Grey levels between which a channel is believed: a response curve lifts noise in the dark over the signal.
constexpr int dark = 25, clipped = 250;
constexpr double clear_of_rim = 0.7;  // radii
constexpr int samples_across = 20;

// Columns: level, temperature (1 / wavelength of blue, green and red without its mean: where Wien's law moves
// the log channels), tint.
const Eigen::Matrix3d& light_directions() {
  static const Eigen::Matrix3d directions = [] {
    const Eigen::Vector3d inverse(1 / 450.0, 1 / 540.0, 1 / 600.0);
    Eigen::Matrix3d columns;
    columns.col(0) = Eigen::Vector3d::Ones().normalized();
    columns.col(1) = (inverse.array() - inverse.mean()).matrix().normalized();
    columns.col(2) = columns.col(0).cross(columns.col(1));
    return columns;
  }();
  return directions;
}

using LevelCounts = std::array<std::uint32_t, 256>;

// The mean of the values between the quartiles of a histogram; each value counts as far as it lies between.
double middle_mean(const LevelCounts& counts, double total) {
  const double low = 0.25 * total, high = 0.75 * total;
  double below = 0, sum = 0;
  for (std::size_t value = 0; value < counts.size() && below < high; ++value) {
    const double above = below + counts[value];
    sum += static_cast<double>(value) * std::max(0.0, std::min(above, high) - std::max(below, low));
    below = above;
  }
  return sum / (high - low);
}

const std::array<float, 256>& log_levels() {
  static const std::array<float, 256> logs = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 1; i < values.size(); ++i) values[i] = std::log(static_cast<float>(i));
    return values;
  }();
  return logs;
}

bool is_clear(double value) { return value >= dark && value <= clipped; }

SurfaceColor middle_color(const std::array<LevelCounts, 3>& counts, double total) {
  SurfaceColor color;
  for (std::size_t c = 0; c < 3; ++c) {
    const double value = middle_mean(counts[c], total);
    color.known[static_cast<Eigen::Index>(c)] = is_clear(value);
    color.log_bgr[static_cast<Eigen::Index>(c)] = std::log(std::max(value, 1.0));
  }
  return color;
}

// A picture whose channels changed by less did not change its light.
constexpr double least_change = 0.05;

constexpr double follow_s = 0.15;           // time constant of following
constexpr double sudden_change_log = 0.12;  // of a ball's log channel, from picture to picture: a jump
constexpr double trust = 1.25;              // times what the picture says a slow change may be
constexpr double drift_s = 30;              // over which is forgotten what the pictures alone say
// Of a ball to be learnt from; what is half covered says little.
constexpr double min_learning_quality = 0.3, min_learning_fill = 0.4;
constexpr double forget_s = 300;  // without a ball, and the taught light is back
// A change of level that the taught table serves by itself (log channels), having been learnt with some room.
constexpr double level_room = 0.2;

double largest(const LogGain& change, const Known& known) { return known.select(change.abs(), 0).maxCoeff(); }

// As much of what the balls say as the picture says too, in level and in colour apart (a ball that rolls into
// a shadow changes its level alone).
LogGain agreed(const LogGain& balls, const LogGain& picture, double trusted) {
  const Eigen::Array3d seen = trusted * light_coordinates(picture);
  return gain_of(light_coordinates(balls).max(seen.min(0.0)).min(seen.max(0.0)));
}

}  // namespace

Eigen::Array3d light_coordinates(const LogGain& gain) {
  return (light_directions().transpose() * gain.matrix()).array();
}

LogGain gain_of(const Eigen::Array3d& coordinates) {
  return (light_directions() * coordinates.matrix()).array();
}

LightCells cells_in(const AssumedLight& light) {
  constexpr int levels = 256 / ColorTable::side;
  LightCells cells;
  for (std::size_t c = 0; c < 3; ++c) {
    const double factor = std::exp(-light.gain[static_cast<Eigen::Index>(c)]);
    for (int cell = 0; cell < ColorTable::side; ++cell) {
      const double shown = factor * (levels * cell + 0.5 * (levels - 1));
      const double level = light.power == 1 ? shown : 255 * std::pow(shown / 255, light.power);
      cells.taught_cell[c][static_cast<std::size_t>(cell)] =
          static_cast<std::uint8_t>(std::min(255.0, level + 0.5) / levels);
    }
  }
  return cells;
}

LogGain confined(const LogGain& gain) {
  const Eigen::Array3d bounds(2.1 * std::sqrt(3.0), 2.4, 0.05);
  return gain_of(light_coordinates(gain).max(-bounds).min(bounds));
}

SurfaceColor middle_color(const cv::Mat& bgr, const OutlineEllipse& outline) {
  SurfaceColor color;
  const double reach = clear_of_rim * outline.radius_px;
  if (!(reach < 1e5) || !(outline.center_px.cwiseAbs().maxCoeff() < 1e6)) return color;
  std::array<LevelCounts, 3> counts{};
  int total = 0, places = 0;
  for (int j = 0; j < samples_across; ++j) {
    for (int i = 0; i < samples_across; ++i) {
      const Eigen::Vector2d offset((i + 0.5) * 2 / samples_across - 1, (j + 0.5) * 2 / samples_across - 1);
      if (offset.squaredNorm() > 1) continue;
      ++places;
      const Eigen::Vector2d p = outline.center_px + reach * offset;
      const auto u = static_cast<int>(std::floor(p.x() + 0.5)), v = static_cast<int>(std::floor(p.y() + 0.5));
      if (u < 0 || v < 0 || u >= bgr.cols || v >= bgr.rows) continue;
      const cv::Vec3b& pixel = bgr.at<cv::Vec3b>(v, u);
      for (std::size_t c = 0; c < 3; ++c) ++counts[c][pixel[static_cast<int>(c)]];
      ++total;
    }
  }
  return 10 * total < 8 * places ? color : middle_color(counts, total);
}

SurfaceColor middle_color(const ColorClass& color_class) {
  std::array<LevelCounts, 3> counts{};
  double total = 0;
  for (const CellCount& cell : color_class.cells) {
    for (std::size_t c = 0; c < 3; ++c) counts[c][4 * (cell.cell >> (6 * c) & 63) + 2] += cell.count;
    total += cell.count;
  }
  return total > 0 ? middle_color(counts, total) : SurfaceColor{};
}

LogGain SurfaceColor::least() const {
  return (known || log_bgr >= std::log(clipped)).select(log_bgr, -std::numeric_limits<double>::infinity());
}

LogGain SurfaceColor::most() const {
  return known.select(
      log_bgr, (log_bgr >= std::log(clipped))
                   .select(LogGain::Constant(std::numeric_limits<double>::infinity()), std::log(dark)));
}

LogGain completed(const LogGain& change, const Known& known) {
  const LogGain seen = known.select(change, 0);
  if (known.count() < 2) return LogGain::Constant(seen.sum());
  const LogGain tint = light_directions().col(2);
  return known.select(change, -(tint * seen).sum() / tint);  // what leaves no tint
}

void PictureSamples::take(const cv::Mat& bgr) {
  size_ = bgr.size();
  std::size_t k = 0;
  for (int j = 0; j < rows; ++j) {
    const cv::Vec3b* const row = bgr.ptr<cv::Vec3b>((2 * j + 1) * bgr.rows / (2 * rows));
    for (int i = 0; i < columns; ++i, ++k) {
      const cv::Vec3b& pixel = row[(2 * i + 1) * bgr.cols / (2 * columns)];
      bgr_[k] = {pixel[0], pixel[1], pixel[2]};
    }
  }
}

SurfaceColor PictureSamples::change_since(const PictureSamples& then) const {
  SurfaceColor change;
  if (empty() || size_ != then.size_) return change;
  const std::array<float, 256>& logs = log_levels();
  for (std::size_t c = 0; c < 3; ++c) {
    // The median by counting ratios in steps of 2 %, then the mean of what lies near it. Bins lie evenly
    // about no change and the median between their edges: off by half a step, the mean would drift in noise.
    constexpr int steps = 512;
    constexpr float step = 0.02f, near = 0.2f;
    std::array<std::uint16_t, steps> counts{};
    std::array<float, columns * rows> ratios;
    std::size_t total = 0;
    for (std::size_t k = 0; k < bgr_.size(); ++k) {
      const std::uint8_t now = bgr_[k][c], before = then.bgr_[k][c];
      if (std::min(now, before) < dark || std::max(now, before) > clipped) continue;
      const float ratio = logs[now] - logs[before];
      ++counts[static_cast<std::size_t>(ratio / step + 0.5f * steps + 0.5f)];
      ratios[total++] = ratio;
    }
    if (total < ratios.size() / 10) continue;
    const float half = 0.5f * static_cast<float>(total);
    float below = 0;
    std::size_t bin = 0;
    while (below + counts[bin] < half) below += counts[bin++];
    const float into_bin = (half - below) / counts[bin];
    const float median = step * (static_cast<float>(bin) - 0.5f + into_bin - 0.5f * steps);
    float sum = 0, taken = 0;
    for (std::size_t k = 0; k < total; ++k) {
      const float is_near = std::abs(ratios[k] - median) < near ? 1.0f : 0.0f;
      sum += is_near * ratios[k];
      taken += is_near;
    }
    change.known[static_cast<Eigen::Index>(c)] = true;
    change.log_bgr[static_cast<Eigen::Index>(c)] = sum / taken;
  }
  return change;
}

void LightAdaptation::begin(const cv::Mat& bgr) {
  previous_ = picture_;
  picture_.take(bgr);
  const SurfaceColor change = picture_.change_since(previous_);
  belief_.picture_change += completed(change.log_bgr, change.known);
  votes_ = {};
  jumped_ = false;
}

void LightAdaptation::assume(const AssumedLight& light) {
  assumed_ = light;
  believe(LogGain::Zero());
  serve_light();
}

bool LightAdaptation::may_be_taught_light() const {
  if (!assumed_.is_taught()) return true;
  const SurfaceColor change = picture_.change_since(then_);
  const LogGain gain = change.known.select(belief_.gain, 0);
  const double along = -(change.log_bgr * gain).sum(), whole = gain.square().sum();
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
  const LogGain ball = (now.known && last.known).select(now.log_bgr - last.log_bgr, picture);
  return agreed(ball, picture, trust);
}

void LightAdaptation::jump(const LogGain& change) {
  believe(confined(belief_.gain + change));
  jumped_ = true;
}

void LightAdaptation::learn(const cv::Mat& bgr, const BallObservation& ball, BallLight& light) {
  if (ball.quality < min_learning_quality || ball.support.fill < min_learning_fill) return;
  const SurfaceColor now = middle_color(bgr, ball.outline);
  if (!now.known.any()) return;
  const SurfaceColor last = std::exchange(light.last, now);
  const bool sudden = largest(now.log_bgr - last.log_bgr, now.known && last.known) > sudden_change_log;
  if (!(now.known && light.reference.known).any() || sudden) {
    if (sudden && !jumped_) jump(sudden_change(now, last));
    light.reference = {now.log_bgr - belief_.gain, now.known};
  }
  // What the ball is too dark or too bright to say, the picture says.
  SurfaceColor& reference = light.reference;
  const LogGain here = (now.known && reference.known)
                           .select(now.log_bgr - reference.log_bgr, belief_.start + belief_.picture_change);
  // A channel that comes out of the dark.
  reference.log_bgr = (now.known && !reference.known).select(now.log_bgr - here, reference.log_bgr);
  reference.known = reference.known || now.known;
  votes_.sum += here;
  ++votes_.balls;
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
    const bool forgets = time_s - learnt_s_ > forget_s;
    if (forgets) assumed_ = {};
    believe(forgets ? LogGain(LogGain::Zero()) : belief_.gain);
  }
  serve_light();
}

void LightAdaptation::believe(const LogGain& gain) { belief_ = {gain, gain, LogGain::Zero()}; }

// The light to look colours up for: the taught one serves a little further than taught, above all in level.
LogGain LightAdaptation::table_gain() {
  Eigen::Array3d light = light_coordinates(belief_.gain);
  const double room = level_room * std::sqrt(3.0);
  light[0] -= std::clamp(light[0], -room, room);
  const LogGain gain = gain_of(light);
  significant_ = gain.abs().maxCoeff() > (significant_ ? 0.5 : 1.0) * significant_gain;
  return significant_ ? gain : LogGain(LogGain::Zero());
}

void LightAdaptation::serve_light() { cells_ = cells_in({assumed_.gain + table_gain(), assumed_.power}); }

}  // namespace ballservo
