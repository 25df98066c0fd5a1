#include "perception/judgement/ball_shading.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace ballservo {
namespace {

constexpr int least_lit_pixels = 24;
constexpr int passes = 6;
constexpr double glare_sigmas = 2.5;  // above what the fit leaves over, root mean square

cv::Rect box_around(const OutlineEllipse& outline, cv::Size size) {
  const double reach = 1.2 * outline.radius_px + 1;
  const auto corner = [&](double outside) -> cv::Point {
    const Eigen::Array2d at = outline.center_px.array() + outside;
    const Eigen::Array2i inside = at.max(0).min(Eigen::Array2d(size.width, size.height)).cast<int>();
    return {inside.x(), inside.y()};
  };
  return {corner(-reach), corner(reach + 1)};
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

  /// A dark and a light part: means, and the largest squares between two (Otsu 1979, eq. 14, times pixels).
  struct Parts {
    double squares = 0, dark = 0, light = 0;
  };
  Parts two_parts(double pixels, double sum) const {
    Parts best;
    double dark = 0, dark_sum = 0;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      dark += pixels_[i];
      dark_sum += sums_[i];
      const double light = pixels - dark;
      if (dark == 0 || light == 0) continue;
      const double dark_mean = dark_sum / dark, light_mean = (sum - dark_sum) / light;
      const double squares = dark * light / pixels * std::pow(light_mean - dark_mean, 2);
      if (squares > best.squares) best = {squares, dark_mean, light_mean};
    }
    return best;
  }

 private:
  static constexpr int steps_ = 128;
  double per_step_;
  std::array<int, steps_> pixels_{};
  std::array<double, steps_> sums_{};
};

// Least squares of the brightness over the terms of the normals.
struct LambertFit {
  void add(const Eigen::Vector4d& terms, double brightness) {
    normal += terms * terms.transpose();
    right += terms * brightness;
    squares += brightness * brightness;
    sum += brightness;
    ++pixels;
  }
  /// |b| as a part of the mean; 0 where there are too few pixels.
  double strength() const {
    if (pixels < least_lit_pixels || !(mean() > 0)) return 0;
    const Eigen::Vector4d p = solve();
    return p.allFinite() ? p.tail<3>().norm() / mean() : 0;
  }
  /// (a, b); a sliver that looks alike from all normals tells nothing.
  Eigen::Vector4d solve() const {
    const Eigen::Matrix4d damped = normal + 1e-6 * Eigen::Matrix4d::Identity();
    return damped.ldlt().solve(right);
  }
  double mean() const { return sum / pixels; }
  double variance() const { return squares / pixels - mean() * mean(); }
  /// Mean square of what the terms leave over.
  double rest(const Eigen::Vector4d& p) const {
    return std::max(0.0, squares - 2 * p.dot(right) + p.dot(normal * p)) / pixels;
  }

  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double squares = 0, sum = 0;
  int pixels = 0;
};

// So much of what is no noise; about 1 where noise is all that is left over.
double part_explained(double rest, double variance, double noise_variance) {
  const double signal = variance - noise_variance;
  return signal > 0 ? std::max(0.0, 1 - (rest - noise_variance) / signal) : 0;
}

// What shows a ball's own surface: pixels of its colour, all around which is its colour too.
struct BallPixels {
  const cv::Mat& bgr;
  const CameraResponse& response;
  const ColoredPixels& colored;
  const RayTable& rays;
  const TangentCone& cone;
  const OutlineEllipse& outline;

  double brightness(int u, int v) const {
    const cv::Vec3b& c = bgr.at<cv::Vec3b>(v, u);
    return static_cast<double>(response.light[c[0]] + response.light[c[1]] + response.light[c[2]]);
  }

  /// Calls see(normal, u, v) for some `per_radius` pixels along a radius; the normal to the camera is (0, 0,
  /// 1).
  template <typename See>
  void for_each(const See& see, double per_radius = 20) const {
    const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(cone.axis);
    const cv::Rect box = box_around(outline, bgr.size()) & cv::Rect(colored.window, colored.pixels.size());
    const int step = std::max(1, static_cast<int>(outline.radius_px / per_radius));
    // Within the blur of the outline the background shines in.
    const double sine = std::sin(cone.alpha_rad), reach = sine * (1 - std::min(0.4, 1.5 / outline.radius_px));
    for (int v = box.y + 1; v < box.br().y - 1; v += step) {
      for (int u = box.x + 1; u < box.br().x - 1; u += step) {
        const Eigen::Vector3d* const ray = rays.pixel_ray(u, v);
        if (!ray || !is_own(u, v) || cone.axis.dot(*ray) <= 0) continue;
        const Eigen::Vector2d across = basis.transpose() * *ray;
        if (across.norm() > reach) continue;
        const Eigen::Vector2d n = across / sine;
        see(Eigen::Vector3d(n.x(), n.y(), std::sqrt(std::max(0.0, 1 - n.squaredNorm()))), u, v);
      }
    }
  }
  bool is_own(int u, int v) const {
    return colored.at(u, v) && colored.at(u - 1, v) && colored.at(u + 1, v) && colored.at(u, v - 1) &&
           colored.at(u, v + 1);
  }
};

// Of the lighter part alone, without what lies between: see BallShading.
double strength_of_lighter(const BallPixels& ball, double dark, double light) {
  const double least = light - (light - dark) / 3;
  LambertFit lit;
  ball.for_each([&](const Eigen::Vector3d& n, int u, int v) {
    const double here = ball.brightness(u, v);
    if (here >= least) lit.add({1, n.x(), n.y(), n.z()}, here);
  });
  return lit.strength();
}

}  // namespace

BallShading ball_shading(const cv::Mat& bgr, const CameraResponse& response, const ColoredPixels& colored,
                         const RayTable& rays, const TangentCone& cone, const OutlineEllipse& outline) {
  const BallPixels ball{bgr, response, colored, rays, cone, outline};
  LambertFit all;
  BrightnessHistogram histogram(3 * static_cast<double>(response.light.back()));
  double bends2 = 0;
  ball.for_each([&](const Eigen::Vector3d& n, int u, int v) {
    const double here = ball.brightness(u, v);
    all.add({1, n.x(), n.y(), n.z()}, here);
    histogram.add(here);
    const double bend = ball.brightness(u - 1, v) - 2 * here + ball.brightness(u + 1, v);
    bends2 += bend * bend;
  });
  if (all.pixels < least_lit_pixels || !(all.mean() > 0) || !(all.variance() > 0)) return {};
  Eigen::Vector4d p = all.solve();
  if (!p.allFinite()) return {};
  const double noise_variance = bends2 / (6 * all.pixels);  // of independent noise: 1 + 4 + 1 times its own
  const auto parts = histogram.two_parts(all.pixels, all.sum);
  const double between = parts.squares / all.pixels;
  double rest = all.rest(p);
  BallShading shading{p.tail<3>().norm() / all.mean(), part_explained(rest, all.variance(), noise_variance),
                      part_explained(all.variance() - between, all.variance(), noise_variance)};
  shading.strength_of_lighter = strength_of_lighter(ball, parts.dark, parts.light);
  // One lamp leaves the side turned away in the dark, and a glossy ball mirrors it: the fit says where.
  for (int pass = 0; pass < passes; ++pass) {
    const double glare = glare_sigmas * std::sqrt(rest);
    LambertFit lit;
    ball.for_each([&](const Eigen::Vector3d& n, int u, int v) {
      const bool is_dark = p.tail<3>().dot(n) <= 0;
      const Eigen::Vector4d terms =
          is_dark ? Eigen::Vector4d(1, 0, 0, 0) : Eigen::Vector4d(1, n.x(), n.y(), n.z());
      const double here = ball.brightness(u, v);
      if (here <= p.dot(terms) + glare) lit.add(terms, here);
    });
    p = lit.solve();
    if (lit.pixels < least_lit_pixels || !p.allFinite()) break;
    rest = lit.rest(p);
    shading.explained = std::max(shading.explained, part_explained(rest, lit.variance(), noise_variance));
  }
  return shading;
}

double shading_strength(const cv::Mat& bgr, const CameraResponse& response, const ColoredPixels& colored,
                        const RayTable& rays, const TangentCone& cone, const OutlineEllipse& outline) {
  const BallPixels ball{bgr, response, colored, rays, cone, outline};
  constexpr double per_radius = 10;  // enough for three numbers
  LambertFit all;
  ball.for_each(
      [&](const Eigen::Vector3d& n, int u, int v) {
        all.add({1, n.x(), n.y(), n.z()}, ball.brightness(u, v));
      },
      per_radius);
  return all.strength();
}

}  // namespace ballservo
