#include "perception/judgement/second_look.hpp"

#include <algorithm>
#include <array>

#include "calibration/color/color_space.hpp"

namespace ballservo {
namespace {

// Larger balls are looked at as if they were about that large; noisy ones in blocks of so many pixels that
// less noise than this is left, down to a radius.
constexpr double fine_radius_px = 16, most_noise = 1.7, least_radius_px = 8;
constexpr double window_radii = 1.7, margin_px = 4;
constexpr int least_pixels = 6, least_side_px = 4;
constexpr double most_brightening = 4;

// The mean of a square of pixels.
cv::Vec3b mean_of_block(const cv::Mat& bgr, const cv::Point& corner, int side) {
  if (side == 1) return bgr.at<cv::Vec3b>(corner);
  cv::Vec3i sum(0, 0, 0);
  for (int v = corner.y; v < corner.y + side; ++v) {
    const cv::Vec3b* const row = bgr.ptr<cv::Vec3b>(v);
    for (int u = corner.x; u < corner.x + side; ++u) sum += cv::Vec3i(row[u]);
  }
  return sum / (side * side);
}

}  // namespace

void SecondLook::set_light(const LightCells& light) {
  constexpr auto cell = static_cast<std::size_t>(ColorTable::side /
                                                 most_brightening);  // even four times as bright, not clipped
  double sum = 0;
  for (const auto& channel : light.taught_cell) sum += channel[cell] / static_cast<double>(cell);
  brightening_ = std::clamp(sum / 3, 1.0, most_brightening);
}

SecondLook::Look SecondLook::look(const cv::Mat& bgr, const ColoredPixels& colored,
                                  const OutlineEllipse& outline) {
  const Eigen::Vector2d& center = outline.center_px;
  const double reach = window_radii * outline.radius_px + margin_px;
  const cv::Rect around(static_cast<int>(center.x() - reach), static_cast<int>(center.y() - reach),
                        static_cast<int>(2 * reach) + 1, static_cast<int>(2 * reach) + 1);
  const cv::Rect box = around & cv::Rect({0, 0}, bgr.size());
  const double radius_px = outline.radius_px, noise = brightening_ * noise_sigma_;
  const int stride = std::max({1, static_cast<int>(radius_px / fine_radius_px),
                               static_cast<int>(std::min(noise / most_noise, radius_px / least_radius_px))});
  const double middle = 0.5 * (stride - 1);
  const cv::Size size(box.width / stride, box.height / stride);
  if (size.width < least_side_px || size.height < least_side_px) return {};
  lab_.resize(static_cast<std::size_t>(size.area()));
  Eigen::Vector3d sum(0, 0, 0);
  int count = 0;
  std::array<std::uint8_t, 256> brightened;
  for (std::size_t level = 0; level < brightened.size(); ++level) {
    brightened[level] =
        static_cast<std::uint8_t>(std::min(255.0, brightening_ * static_cast<double>(level) + 0.5));
  }
  const FastLab& lab_of = fast_lab();
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const int u = box.x + stride * column, v = box.y + stride * row;
      const cv::Vec3b c = mean_of_block(bgr, {u, v}, stride);
      const Eigen::Vector3f lab = lab_of(brightened[c[0]], brightened[c[1]], brightened[c[2]]);
      lab_[static_cast<std::size_t>(row * size.width + column)] = cv::Vec3f(lab[0], lab[1], lab[2]);
      const double right = u + middle - center.x(), down = v + middle - center.y();
      const bool inside = right * right + down * down < radius_px * radius_px;
      if (!inside || !colored.knows(u + stride / 2, v + stride / 2) ||
          !colored.at(u + stride / 2, v + stride / 2))
        continue;
      sum += lab.cast<double>();
      ++count;
    }
  }
  if (count < least_pixels) return {};
  const cv::Mat3f lab(size.height, size.width, lab_.data());
  const Eigen::Vector2d corner = Eigen::Vector2d(box.x, box.y).array() + middle;
  CircleEvidence seen = circle_evidence(lab, {(center - corner) / stride, radius_px / stride}, sum / count);
  const double log_odds = seen.log_odds_of_known_color();
  seen.center_px = stride * seen.center_px + corner;
  seen.radius_px *= stride;
  return {seen, log_odds};
}

}  // namespace ballservo
