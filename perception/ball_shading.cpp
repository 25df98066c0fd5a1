#include "perception/ball_shading.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace ballservo {
namespace {

constexpr int least_pixels = 24;

cv::Rect box_around(const OutlineEllipse& outline, cv::Size size) {
  const auto clamped = [](double value, int high) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(high)));
  };
  const double reach = 1.2 * outline.radius_px + 1;
  const int left = clamped(outline.center_px.x() - reach, size.width);
  const int top = clamped(outline.center_px.y() - reach, size.height);
  const int right = clamped(outline.center_px.x() + reach + 1, size.width);
  const int bottom = clamped(outline.center_px.y() + reach + 1, size.height);
  return {left, top, right - left, bottom - top};
}

// How bright the pixels are: their number and the sum of their brightness in steps from dark to light.
class BrightnessHistogram {
 public:
  explicit BrightnessHistogram(double brightest) : per_step_(steps_ / brightest) {}

  void add(double brightness) {
    const auto step = static_cast<std::size_t>(std::clamp(brightness * per_step_, 0.0, steps_ - 1.0));
    ++pixels_[step];
    sums_[step] += brightness;
  }

  /// The largest sum of squares between a dark and a light part (Otsu 1979, equation 14, times the pixels).
  double squares_between_two(double pixels, double sum) const {
    double most = 0, dark = 0, dark_sum = 0;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      dark += pixels_[i];
      dark_sum += sums_[i];
      const double light = pixels - dark;
      if (dark == 0 || light == 0) continue;
      const double apart = dark_sum / dark - (sum - dark_sum) / light;
      most = std::max(most, dark * light / pixels * apart * apart);
    }
    return most;
  }

 private:
  static constexpr int steps_ = 128;
  double per_step_;
  std::array<int, steps_> pixels_{};
  std::array<double, steps_> sums_{};
};

}  // namespace

BallShading ball_shading(const cv::Mat& bgr, const CameraResponse& response, const ColoredPixels& colored,
                         const RayTable& rays, const TangentCone& cone, const OutlineEllipse& outline) {
  const cv::Rect box = box_around(outline, bgr.size()) & cv::Rect(colored.window, colored.pixels.size());
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(cone.axis);
  const int step = std::max(1, static_cast<int>(outline.radius_px / 20));
  // Within the blur of the outline the background shines in.
  const double reach = std::sin(cone.alpha_rad) * (1 - std::min(0.4, 1.5 / outline.radius_px));
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double squares = 0;
  int pixels = 0;
  BrightnessHistogram histogram(3 * static_cast<double>(response.light.back()));
  for (int v = box.y; v < box.br().y; v += step) {
    const cv::Vec3b* row = bgr.ptr<cv::Vec3b>(v);
    for (int u = box.x; u < box.br().x; u += step) {
      if (!colored.at(u, v)) continue;
      const Eigen::Vector3d* const ray = rays.pixel_ray(u, v);
      if (!ray || cone.axis.dot(*ray) <= 0) continue;
      const Eigen::Vector2d across = basis.transpose() * *ray;
      if (across.norm() > reach) continue;
      const Eigen::Vector2d n = across / std::sin(cone.alpha_rad);
      const Eigen::Vector4d terms(1, n.x(), n.y(), std::sqrt(std::max(0.0, 1 - n.squaredNorm())));
      const cv::Vec3b& c = row[u];
      const double brightness =
          static_cast<double>(response.light[c[0]] + response.light[c[1]] + response.light[c[2]]);
      normal += terms * terms.transpose();
      right += terms * brightness;
      squares += brightness * brightness;
      histogram.add(brightness);
      ++pixels;
    }
  }
  if (pixels < least_pixels) return {};
  const double mean = right(0) / pixels, variance = squares - right(0) * mean;
  normal.diagonal().array() += 1e-6;  // a sliver that looks alike from all normals tells nothing
  const Eigen::Vector4d p = normal.ldlt().solve(right);
  const double rest = squares - 2 * p.dot(right) + p.dot(normal * p);
  if (!(mean > 0) || !(variance > 0) || !p.allFinite()) return {};
  const double between = histogram.squares_between_two(pixels, right(0));
  return {p.tail<3>().norm() / mean, std::clamp(1 - rest / variance, 0.0, 1.0), between / variance};
}

}  // namespace ballservo
