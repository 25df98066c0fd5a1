#include "calibration/teaching/ball_evidence.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "calibration/base/statistics.hpp"

namespace ballservo {
namespace {

constexpr int ray_count = 64;
constexpr double alike_enough = 0.3;
constexpr double pi = 3.14159265358979323846;

cv::Vec3f at(const cv::Mat3f& lab, double x, double y) {
  const int x0 = std::clamp(static_cast<int>(std::floor(x)), 0, lab.cols - 2);
  const int y0 = std::clamp(static_cast<int>(std::floor(y)), 0, lab.rows - 2);
  const auto fx = static_cast<float>(x - x0), fy = static_cast<float>(y - y0);
  const cv::Vec3f *upper = lab[y0] + x0, *lower = lab[y0 + 1] + x0;
  return (1 - fy) * ((1 - fx) * upper[0] + fx * upper[1]) + fy * ((1 - fx) * lower[0] + fx * lower[1]);
}

/// How well a colour agrees with the ball's in hue, 0 to 1, whatever the light's strength.
class Likeness {
 public:
  explicit Likeness(const Eigen::Vector3d& color)
      : own_(color.tail<2>() / (color.x() + 16)), strength_(std::max(1e-9, own_.norm())) {
    own_ /= strength_;
  }
  double operator()(const cv::Vec3f& c) const {
    const Eigen::Vector2d s = Eigen::Vector2d(c[1], c[2]) / (c[0] + 16.0);
    const double along = s.dot(own_), across = own_.x() * s.y() - own_.y() * s.x();
    if (along < 0.25 * strength_) return 0;
    const double angle = across / (0.3 * std::max(along, 0.5 * strength_));
    return 1 / ((1 + 0.35 * angle * angle) * (1 + 0.35 * angle * angle));
  }

 private:
  Eigen::Vector2d own_;
  double strength_;
};

/// How far an edge may lie off a ball's outline: noise and blur alone; or perspective, JPEG, a fuzzy skin.
double tight_sigma(double radius_px) { return std::hypot(0.12, 0.005 * radius_px); }
double loose_sigma(double radius_px) { return std::hypot(0.35, 0.02 * radius_px); }

struct Edge {
  double radius_px = 0, contrast = 0;
  bool in_picture = false;
};

std::array<Eigen::Vector2d, ray_count> directions() {
  std::array<Eigen::Vector2d, ray_count> result;
  for (int k = 0; k < ray_count; ++k)
    result[k] = {std::cos(2 * pi * k / ray_count), std::sin(2 * pi * k / ray_count)};
  return result;
}

/// Along every ray, or every `stride`th.
std::array<Edge, ray_count> edges_of(const cv::Mat3f& lab, const Outline& circle, const Likeness& like,
                                     int stride) {
  constexpr double nearest = 0.5, farthest = 1.5;
  const double step = std::max(0.35, circle.radius_px / 40);
  const int half = std::max(2, static_cast<int>(std::lround(std::max(1.0, 0.08 * circle.radius_px) / step)));
  const int first = static_cast<int>(nearest * circle.radius_px / step) - half,
            last = static_cast<int>(farthest * circle.radius_px / step) + half + 2;
  std::vector<cv::Vec3f> color(static_cast<std::size_t>(last - first));
  std::vector<double> alike(color.size()), score(color.size());
  static const auto rays = directions();
  std::array<Edge, ray_count> edges;
  for (int k = 0; k < ray_count; k += stride) {
    const Eigen::Vector2d ray = circle.shape * rays[k], rim = circle.center_px + circle.radius_px * ray;
    if (rim.x() < 1 || rim.y() < 1 || rim.x() > lab.cols - 2 || rim.y() > lab.rows - 2) continue;
    edges[k].in_picture = true;
    for (std::size_t i = 0; i < color.size(); ++i) {
      const Eigen::Vector2d p = circle.center_px + step * (first + static_cast<int>(i)) * ray;
      color[i] = at(lab, std::clamp(p.x(), 0.0, lab.cols - 1.0), std::clamp(p.y(), 0.0, lab.rows - 1.0));
      alike[i] = like(color[i]);
    }
    std::fill(score.begin(), score.end(), 0.0);
    std::size_t best = 0;
    for (std::size_t i = half; i + half <= color.size(); ++i) {
      cv::Vec3f inner(0, 0, 0), outer(0, 0, 0);
      double inside = 0;
      for (int j = 1; j <= half; ++j) {
        inner += color[i - j];
        outer += color[i + j - 1];
        inside += alike[i - j];
      }
      score[i] = cv::norm(outer - inner) / half * inside / half;
      if (score[i] > score[best]) best = i;
    }
    if (best == 0) continue;
    double sum = 0, moment = 0;
    for (std::size_t i = best - std::min<std::size_t>(best, half);
         i <= std::min(color.size() - 1, best + half); ++i) {
      const double weight = score[i] > 0.5 * score[best] ? score[i] - 0.5 * score[best] : 0;
      sum += weight;
      moment += weight * (first + static_cast<double>(i) - 0.5);
    }
    edges[k].radius_px = step * moment / sum;
    edges[k].contrast = score[best];
  }
  return edges;
}

constexpr double least_contrast = 4;
constexpr double hidden = 0.3;  // of a ball's rim, expected
using Harmonics = Eigen::Matrix<double, 5, 1>;

Harmonics harmonics(int k) {
  const double a = 2 * pi * k / ray_count;
  return (Harmonics() << 1, std::cos(a), std::sin(a), std::cos(2 * a), std::sin(2 * a)).finished();
}

Harmonics fit(const std::array<Edge, ray_count>& edges, const Outline& circle) {
  const double r = circle.radius_px;
  Harmonics x = Harmonics::Zero();
  x[0] = r;
  const Harmonics prior = (Harmonics() << 0.2 * r, 0.2 * r, 0.2 * r, 0.03 * r, 0.03 * r).finished();
  for (const double scale : {0.1 * r, 0.06 * r, 0.04 * r, 0.03 * r, 0.02 * r}) {
    const double sigma = std::max(scale, loose_sigma(r));
    Eigen::Matrix<double, 5, 5> normal = (sigma / prior.array()).square().matrix().asDiagonal();
    Harmonics right = normal * (Harmonics() << r, 0, 0, 0, 0).finished();
    for (int k = 0; k < ray_count; ++k) {
      if (!edges[k].in_picture || edges[k].contrast < least_contrast) continue;
      const Harmonics h = harmonics(k);
      const double z = (edges[k].radius_px - h.dot(x)) / (2 * sigma);
      const double w = 1 / ((1 + z * z) * (1 + z * z));
      normal += w * h * h.transpose();
      right += w * edges[k].radius_px * h;
    }
    x = normal.ldlt().solve(right);
  }
  return x;
}

void judge_shading(const cv::Mat3f& lab, const Outline& circle, const Likeness& like, BallEvidence& result) {
  const Eigen::Matrix2d to_unit = circle.shape.inverse() / circle.radius_px;
  const double reach = 0.88 * circle.radius_px * circle.shape.norm() / std::sqrt(2.0);
  const int step = std::max(1, static_cast<int>(reach / 12));
  std::vector<Eigen::Vector4d> normals;
  std::vector<double> light;
  int all = 0;
  double filled = 0;
  Eigen::Vector3d color(0, 0, 0);
  for (int y = static_cast<int>(std::ceil(circle.center_px.y() - reach)); y <= circle.center_px.y() + reach;
       y += step) {
    for (int x = static_cast<int>(std::ceil(circle.center_px.x() - reach)); x <= circle.center_px.x() + reach;
         x += step) {
      if (x < 0 || y < 0 || x >= lab.cols || y >= lab.rows) continue;
      const Eigen::Vector2d n = to_unit * (Eigen::Vector2d(x, y) - circle.center_px);
      if (!(n.squaredNorm() <= 0.88 * 0.88)) continue;
      ++all;
      const cv::Vec3f c = lab(y, x);
      const double alike = like(c);
      filled += alike;
      if (alike < alike_enough) continue;
      color += Eigen::Vector3d(c[0], c[1], c[2]);
      const double f = (c[0] + 16) / 116;
      normals.emplace_back(1, n.x(), n.y(), std::sqrt(1 - n.squaredNorm()));
      light.push_back(f * f * f);
    }
  }
  result.filled = all > 0 ? filled / all : 0;
  if (!light.empty()) result.color = color / static_cast<double>(light.size());
  if (light.size() < 12) return;
  std::vector<double> weight(light.size(), 1);
  Eigen::Vector4d x;
  for (int round = 0; round < 5; ++round) {
    Eigen::Matrix4d normal = 1e-6 * Eigen::Matrix4d::Identity();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (std::size_t i = 0; i < light.size(); ++i) {
      normal += weight[i] * normals[i] * normals[i].transpose();
      right += weight[i] * light[i] * normals[i];
    }
    x = normal.ldlt().solve(right);
    std::vector<double> off;
    for (std::size_t i = 0; i < light.size(); ++i) off.push_back(std::abs(light[i] - x.dot(normals[i])));
    const double scale = 3 * 1.4826 * upper_median(off) + 1e-4;
    for (std::size_t i = 0; i < light.size(); ++i) {
      const double z = (light[i] - x.dot(normals[i])) / scale;
      weight[i] = 1 / ((1 + z * z) * (1 + z * z));
    }
  }
  double sum = 0, mean = 0, total = 0, rest = 0;
  for (std::size_t i = 0; i < light.size(); ++i) sum += weight[i], mean += weight[i] * light[i];
  mean /= sum;
  for (std::size_t i = 0; i < light.size(); ++i) {
    total += weight[i] * (light[i] - mean) * (light[i] - mean) / sum;
    const double off = light[i] - x.dot(normals[i]);
    rest += weight[i] * off * off / sum;
  }
  result.shading = total > 0 ? std::max(0.0, 1 - rest / total) : 0;
  result.relief = std::sqrt(std::max(0.0, total - rest)) / std::max(1e-6, mean);
}

/// Mean log likelihood ratio a ray.
struct Contour {
  double ratio = 0, arc = 0, edge = 0;
};

Contour judge_contour(const std::array<Edge, ray_count>& edges, const Harmonics& x, int stride) {
  const double r = x[0], tight = tight_sigma(r), loose = loose_sigma(r), wide = 0.15 * r, uniform = 1 / r;
  const auto gauss = [](double v, double s) {
    return std::exp(-0.5 * v * v / (s * s)) / (s * std::sqrt(2 * pi));
  };
  Contour result;
  int seen = 0, on = 0;
  std::vector<double> contrast;
  for (int k = 0; k < ray_count; ++k) {
    if (!edges[k].in_picture) continue;
    ++seen;
    if (edges[k].contrast < least_contrast) {
      result.ratio += std::log(hidden / 0.5) * stride / ray_count;
      continue;
    }
    const double away = edges[k].radius_px - harmonics(k).dot(x);
    result.ratio += std::log((0.4 * gauss(away, tight) + 0.3 * gauss(away, loose) + hidden * uniform) /
                             (0.5 * gauss(away, wide) + 0.5 * uniform)) *
                    stride / ray_count;
    if (std::abs(away) <= 2.5 * loose) {
      ++on;
      contrast.push_back(edges[k].contrast);
    }
  }
  if (seen > 0) result.arc = static_cast<double>(on) / seen;
  if (!contrast.empty()) result.edge = upper_median(contrast);
  return result;
}

}  // namespace

double BallEvidence::sphere() const { return shading * std::min(1.0, relief / 0.15); }

double BallEvidence::log_odds() const {
  return -4 + std::clamp(8 * contour, -8.0, 10.0) + 8 * sphere() - 4.5 +
         std::clamp(4 * std::log(std::max(1.0, color.tail<2>().norm()) / 25), -6.0, 2.0) +
         std::clamp(std::log(std::max(1.0, edge) / 12), -1.5, 1.5) -
         std::min(3.0, std::max(0.0, ellipse - 0.03) / 0.03);
}

BallEvidence ball_evidence(const cv::Mat3f& lab, const Outline& outline, const Eigen::Vector3d& color) {
  const Likeness like(color);
  Outline circle = outline;
  BallEvidence result;
  Harmonics x;
  Contour contour;
  for (int round = 0;; ++round) {
    const int stride = round == 0 ? 2 : 1;
    const auto edges = edges_of(lab, circle, like, stride);
    x = fit(edges, circle);
    contour = judge_contour(edges, x, stride);
    if (round == 2 || contour.ratio < -0.3) break;
    const Eigen::Vector2d shift = circle.shape * Eigen::Vector2d(x[1], x[2]);
    if (!x.allFinite() || shift.norm() > 0.5 * circle.radius_px || x[0] < 0.6 * circle.radius_px ||
        x[0] > 1.6 * circle.radius_px)
      break;
    circle.center_px += shift;
    circle.radius_px = x[0];
  }
  result.contour = contour.ratio;
  result.arc = contour.arc;
  result.edge = contour.edge;
  result.center_px = circle.center_px + circle.shape * Eigen::Vector2d(x[1], x[2]);
  result.radius_px = x[0];
  result.ellipse = std::hypot(x[3], x[4]) / x[0];
  result.color = color;
  judge_shading(lab, {result.center_px, result.radius_px, circle.shape}, like, result);
  return result;
}

cv::Mat ball_pixels(const cv::Mat3f& lab, const Eigen::Vector3d& color) {
  const Likeness like(color);
  cv::Mat1b result(lab.size());
  std::transform(lab.begin(), lab.end(), result.begin(),
                 [&](const cv::Vec3f& c) { return like(c) >= alike_enough ? 255 : 0; });
  return result;
}

}  // namespace ballservo
