#include "perception/light_gain.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ballservo {
namespace {

constexpr int dark = 4, clipped = 250;  // grey levels between which a channel is believed
constexpr double clear_of_rim = 0.7;    // radii
constexpr int samples_across = 20;

// 1 / wavelength of blue, green, red, without its mean: where Wien's law moves the log channels.
const Eigen::Vector3d& temperature_direction() {
  static const Eigen::Vector3d direction = [] {
    const Eigen::Vector3d inverse(1 / 450.0, 1 / 540.0, 1 / 600.0);
    return (inverse.array() - inverse.mean()).matrix().normalized().eval();
  }();
  return direction;
}

const Eigen::Vector3d& level_direction() {
  static const Eigen::Vector3d direction = Eigen::Vector3d::Ones().normalized();
  return direction;
}

const Eigen::Vector3d& tint_direction() {
  static const Eigen::Vector3d direction = level_direction().cross(temperature_direction());
  return direction;
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

bool is_clear(double value) { return value >= dark && value <= clipped; }

}  // namespace

LogGain LightBounds::confine(const LogGain& gain) const {
  const auto along = [&](const Eigen::Vector3d& direction, double bound) -> Eigen::Vector3d {
    return std::clamp(direction.dot(gain.matrix()), -bound, bound) * direction;
  };
  return (along(level_direction(), level * std::sqrt(3.0)) + along(temperature_direction(), temperature) +
          along(tint_direction(), tint))
      .array();
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
    result[missing] = -tint_direction().dot(result.matrix()) / tint_direction()[missing];
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
  // Medians by counting ratios in steps of about 2 %, refined by the mean of the step they fall into.
  constexpr int steps = 401;
  constexpr double step = 0.02;
  for (std::size_t c = 0; c < 3; ++c) {
    std::array<std::uint16_t, steps> counts{};
    std::array<float, steps> sums{};
    int total = 0;
    for (std::size_t k = 0; k < bgr_.size(); ++k) {
      const double now = bgr_[k][c], before = then.bgr_[k][c];
      if (now < 2 * dark || before < 2 * dark || now > clipped || before > clipped) continue;
      const double ratio = std::log(now / before);
      const auto bin = static_cast<std::size_t>(std::clamp(ratio / step + 0.5 * steps, 0.0, steps - 1.0));
      ++counts[bin];
      sums[bin] += static_cast<float>(ratio);
      ++total;
    }
    if (total < columns * rows / 10) continue;
    int below = 0;
    std::size_t bin = 0;
    while (2 * (below + counts[bin]) < total) below += counts[bin++];
    change.known[c] = true;
    change.log_bgr[static_cast<Eigen::Index>(c)] = sums[bin] / static_cast<float>(counts[bin]);
  }
  return change;
}

}  // namespace ballservo
