#include "perception/tracking/light_gain.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ballservo {
namespace {

// Grey levels between which a channel is believed: where it is darker, a response curve lifts the noise above
// the signal.
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

// The mean of the values between the quartiles of a histogram; each value counts as far as it lies between.
double middle_mean(const std::array<std::uint16_t, 256>& counts, int total) {
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

}  // namespace

Eigen::Array3d light_coordinates(const LogGain& gain) {
  return (light_directions().transpose() * gain.matrix()).array();
}

LogGain gain_of(const Eigen::Array3d& coordinates) {
  return (light_directions() * coordinates.matrix()).array();
}

LogGain confined(const LogGain& gain) {
  const Eigen::Array3d bounds(2.1 * std::sqrt(3.0), 2.4, 0.05);
  return gain_of(light_coordinates(gain).max(-bounds).min(bounds));
}

SurfaceColor middle_color(const cv::Mat& bgr, const OutlineEllipse& outline) {
  SurfaceColor color;
  const double reach = clear_of_rim * outline.radius_px;
  if (!(reach < 1e5) || !(outline.center_px.cwiseAbs().maxCoeff() < 1e6)) return color;
  std::array<std::array<std::uint16_t, 256>, 3> counts{};
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
  if (10 * total < 8 * places) return color;
  for (std::size_t c = 0; c < 3; ++c) {
    const double value = middle_mean(counts[c], total);
    color.known[c] = is_clear(value);
    color.log_bgr[static_cast<Eigen::Index>(c)] = std::log(std::max(value, 1.0));
  }
  return color;
}

LogGain completed(const LogGain& change, const std::array<bool, 3>& known) {
  const auto count = std::count(known.begin(), known.end(), true);
  if (count == 3) return change;
  if (count == 0) return LogGain::Zero();
  LogGain result = change;
  if (count == 2) {  // the one that leaves no tint
    const auto missing = std::find(known.begin(), known.end(), false) - known.begin();
    result[missing] = 0;
    const Eigen::Vector3d tint = light_directions().col(2);
    result[missing] = -tint.dot(result.matrix()) / tint[missing];
    return result;
  }
  const auto only = std::find(known.begin(), known.end(), true) - known.begin();
  return LogGain::Constant(change[only]);
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
    // The median by counting ratios in steps of 2 %, then the mean of what lies near it.
    constexpr int steps = 512;
    constexpr float step = 0.02f, near = 0.2f;
    std::array<std::uint16_t, steps> counts{};
    std::array<float, columns * rows> ratios;
    std::size_t total = 0;
    for (std::size_t k = 0; k < bgr_.size(); ++k) {
      const std::uint8_t now = bgr_[k][c], before = then.bgr_[k][c];
      if (std::min(now, before) < dark || std::max(now, before) > clipped) continue;
      const float ratio = logs[now] - logs[before];
      ++counts[static_cast<std::size_t>(ratio / step + 0.5f * steps)];
      ratios[total++] = ratio;
    }
    if (total < ratios.size() / 10) continue;
    std::size_t below = 0, bin = 0;
    while (2 * (below + counts[bin]) < total) below += counts[bin++];
    const float median = step * (static_cast<float>(bin) + 0.5f - 0.5f * steps);
    float sum = 0, taken = 0;
    for (std::size_t k = 0; k < total; ++k) {
      const float is_near = std::abs(ratios[k] - median) < near ? 1.0f : 0.0f;
      sum += is_near * ratios[k];
      taken += is_near;
    }
    change.known[c] = true;
    change.log_bgr[static_cast<Eigen::Index>(c)] = sum / taken;
  }
  return change;
}

}  // namespace ballservo
