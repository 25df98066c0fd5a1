#include "calibration/circles/circle_evidence.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <bitset>
#include <boost/container/static_vector.hpp>
#include <cmath>
#include <numeric>

#include "calibration/base/statistics.hpp"

namespace ballservo {
namespace {

constexpr int ray_count = 64;
/// Samples of a disc: a square of 25 to either side, or of 47 where there are less than two pixels a sample.
constexpr std::size_t most_samples = 2304, most_along_ray = 192;
template <class T>
using Samples = boost::container::static_vector<T, most_samples>;
template <class T>
using RaySamples = boost::container::static_vector<T, most_along_ray>;
constexpr double alike_enough = 0.3;

cv::Vec3f at(const cv::Mat3f& lab, double x, double y) {
  const int x0 = std::clamp(static_cast<int>(std::floor(x)), 0, lab.cols - 2);
  const int y0 = std::clamp(static_cast<int>(std::floor(y)), 0, lab.rows - 2);
  const auto fx = static_cast<float>(x - x0), fy = static_cast<float>(y - y0);
  const cv::Vec3f *upper = lab[y0] + x0, *lower = lab[y0 + 1] + x0;
  return (1 - fy) * ((1 - fx) * upper[0] + fx * upper[1]) + fy * ((1 - fx) * lower[0] + fx * lower[1]);
}

/// The pixel at a place; null outside the picture.
const cv::Vec3f* pixel_at(const cv::Mat3f& lab, const Eigen::Vector2d& place_px) {
  const cv::Point p(cvRound(place_px.x()), cvRound(place_px.y()));
  return cv::Rect({0, 0}, lab.size()).contains(p) ? &lab(p) : nullptr;
}

const std::array<Eigen::Vector2d, ray_count>& directions() {
  static const auto result = [] {
    std::array<Eigen::Vector2d, ray_count> rays;
    for (int k = 0; k < ray_count; ++k)
      rays[k] = {std::cos(2 * M_PI * k / ray_count), std::sin(2 * M_PI * k / ray_count)};
    return rays;
  }();
  return result;
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

using RaySet = std::bitset<ray_count>;

/// Where the disc and what lies around it are looked at: on which rays, and from how far inside on (radii).
struct SampledRays {
  RaySet inside = RaySet().set(), around = RaySet().set();
  double nearest = 0;
};

/// How probably a colour is the disc's rather than that of what lies around it: two histograms of Lab, of
/// which neighbouring cells share what lies between them. So the rim of a marbled ball is seen where its hue
/// fails.
class Belonging {
 public:
  Belonging(const cv::Mat3f& lab, const Outline& circle, const SampledRays& sampled = {})
      : sampled_(sampled) {
    std::array<double, 2> sums{};
    for_each_sample(lab, circle, [&](const cv::Vec3f& c, int side, double weight) {
      Eigen::Array4f on_side = Eigen::Array4f::Zero();
      on_side[side] = on_side[side + 2] = static_cast<float>(weight);
      for_each_pair(c, [&](CellPair cells, const Eigen::Array4f& shares) { cells += shares * on_side; });
      sums[side] += weight;
    });
    const Eigen::Array2f each = Eigen::Array2d(sums[0], sums[1]).max(1e-9).inverse().cast<float>();
    const Eigen::Array4f part(each[0], each[1], each[0], each[1]);
    for (std::size_t i = 0; i < cells_.size(); i += 4) {
      CellPair cells(&cells_[i]);
      cells = cells * part + unseen;
    }
  }
  double operator()(const cv::Vec3f& c) {
    Eigen::Array4f density = Eigen::Array4f::Zero();
    for_each_pair(c, [&](const CellPair& cells, const Eigen::Array4f& shares) { density += shares * cells; });
    const float inside = density[0] + density[2];
    return inside / (inside + density[1] + density[3]);
  }
  /// How much more the disc's colours belong to it than those around it do: 1 where they are others, 0 where
  /// nothing tells them apart.
  double distinctness(const cv::Mat3f& lab, const Outline& circle) {
    std::array<double, 2> sums{}, belong{};
    for_each_sample(lab, circle, [&](const cv::Vec3f& c, int side, double weight) {
      belong[side] += weight * (*this)(c);
      sums[side] += weight;
    });
    return sums[0] > 0 && sums[1] > 0 ? belong[0] / sums[0] - belong[1] / sums[1] : 0;
  }
  /// How much of what belongs to the disc and lies near its rim has the ball's hue: of a fist around a ball
  /// nothing.
  double part_of_rim(const cv::Mat3f& lab, const Outline& circle, const Likeness& like) {
    constexpr double near_rim = 0.6;
    double belong = 0, alike = 0;
    for_each_sample(lab, circle, [&](const cv::Vec3f& c, int side, double reach) {
      if (side != 0 || reach < near_rim) return;
      const double part = (*this)(c);
      belong += part;
      alike += part * like(c);
    });
    return belong > 0 ? alike / belong : 0;
  }

 private:
  static constexpr float lightness_cell = 12, chroma_cell = 8;
  static constexpr float unseen = 1e-3F;  // density that a colour has which no sample showed
  static constexpr int levels = 10, chromas = 28;

  /// On every other ray, inside the rim (0) and around it (1), far enough off for its blur.
  template <class Visit>
  void for_each_sample(const cv::Mat3f& lab, const Outline& circle, Visit visit) const {
    constexpr int steps = 10;
    constexpr double inner = 0.85, around = 1.15, outer = 1.6;
    for (int k = 0; k < ray_count; k += 2) {
      const Eigen::Vector2d ray = circle.radius_px * (circle.shape * directions()[k]);
      for (int i = 0; i < 2 * steps; ++i) {
        const double part = (i / 2 + 0.5) / steps,
                     reach = i % 2 ? around + (outer - around) * part : inner * part;
        if (!(i % 2 ? sampled_.around : sampled_.inside)[k] || reach < sampled_.nearest) continue;
        if (const cv::Vec3f* c = pixel_at(lab, circle.center_px + reach * ray)) visit(*c, i % 2, reach);
      }
    }
  }
  /// Two cells that are neighbours in b: (inside, around) of the one, then of the other.
  using CellPair = Eigen::Map<Eigen::Array4f>;
  template <class Visit>
  void for_each_pair(const cv::Vec3f& c, Visit visit) {
    const float l = std::clamp(c[0] / lightness_cell, 0.0F, levels - 1.01F),
                a = std::clamp(c[1] / chroma_cell + chromas / 2, 0.0F, chromas - 1.01F),
                b = std::clamp(c[2] / chroma_cell + chromas / 2, 0.0F, chromas - 1.01F);
    const int il = static_cast<int>(l), ia = static_cast<int>(a), ib = static_cast<int>(b);
    const float fl = l - static_cast<float>(il), fa = a - static_cast<float>(ia),
                fb = b - static_cast<float>(ib);
    const Eigen::Array4f along_b(1 - fb, 1 - fb, fb, fb);
    for (int i = 0; i < 4; ++i) {
      const int dl = i & 1, da = i >> 1;
      visit(CellPair(&cells_[static_cast<std::size_t>(2 * (((il + dl) * chromas + ia + da) * chromas + ib))]),
            (dl ? fl : 1 - fl) * (da ? fa : 1 - fa) * along_b);
    }
  }

  SampledRays sampled_;
  std::array<float, 2 * levels * chromas * chromas> cells_{};
};

/// How far what hides a part of the disc is other than what lies around the rest of it. Nothing hides half a
/// disc: the ground around it goes on where its other half would be.
double difference_of_cover(const cv::Mat3f& lab, const Outline& circle, const Likeness& like) {
  constexpr double most_whole = 0.8;  // of the rays, where nothing much is hidden
  RaySet covered, seen;
  for (int k = 0; k < ray_count; ++k) {
    int samples = 0;
    double alike = 0;
    for (const double reach : {0.65, 0.75, 0.85}) {
      const Eigen::Vector2d ray = reach * circle.radius_px * (circle.shape * directions()[k]);
      if (const cv::Vec3f* c = pixel_at(lab, circle.center_px + ray)) alike += like(*c), ++samples;
    }
    if (samples > 0) (alike < alike_enough * samples ? covered : seen).set(k);
  }
  if (seen.none() || seen.count() > most_whole * (seen.count() + covered.count())) return 1;
  return Belonging(lab, circle, {covered, seen, 0.4}).distinctness(lab, circle);
}

/// How far an edge may lie off a ball's outline: noise and blur alone; or perspective, JPEG, a fuzzy skin,
/// the softness of a moving hand (`rough`, of the radius).
double tight_sigma(double radius_px) { return std::hypot(0.12, 0.005 * radius_px); }
double loose_sigma(double radius_px, double rough) { return std::hypot(0.35, rough * radius_px); }
constexpr double smooth_rim = 0.02, rough_rim = 0.035;

struct Edge {
  double radius_px = 0, contrast = 0;
  double share = 0;  ///< how probably it is its ray's outline, before any circle is known
};

struct Ray {
  boost::container::static_vector<Edge, 3> edges;
  bool in_picture = false;
};

constexpr double least_contrast = 4;

/// Where the ball may end, along every ray, or every `stride`th: the strongest edges from what belongs to the
/// disc to what does not.
std::array<Ray, ray_count> rays_of(const cv::Mat3f& lab, const Outline& circle, int stride) {
  constexpr double nearest = 0.5, farthest = 1.5;
  constexpr double despite = 0.7;      // against an edge, that what lies behind belongs to the disc as well
  constexpr double least_share = 0.3;  // of the ray's strongest edge; weaker ones are its texture
  const double step = std::max(0.35, circle.radius_px / 40);
  const int half = std::max(2, static_cast<int>(std::lround(std::max(1.0, 0.08 * circle.radius_px) / step)));
  const int blurred = half / 2;  // what lies so near an edge is a mixture
  const int first = static_cast<int>(nearest * circle.radius_px / step) - 2 * half,
            count = static_cast<int>(farthest * circle.radius_px / step) + 2 * half + 2 - first;
  RaySamples<cv::Vec3f> color(static_cast<std::size_t>(count + 1));  // sums of all before
  RaySamples<double> belong(color.size()), score(color.size());
  Belonging belonging(lab, circle);
  std::array<Ray, ray_count> rays;
  for (int k = 0; k < ray_count; k += stride) {
    const Eigen::Vector2d ray = circle.shape * directions()[k],
                          rim = circle.center_px + circle.radius_px * ray;
    if (rim.x() < 1 || rim.y() < 1 || rim.x() > lab.cols - 2 || rim.y() > lab.rows - 2) continue;
    rays[k].in_picture = true;
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d p = circle.center_px + step * (first + i) * ray;
      const cv::Vec3f c =
          at(lab, std::clamp(p.x(), 0.0, lab.cols - 1.0), std::clamp(p.y(), 0.0, lab.rows - 1.0));
      color[i + 1] = color[i] + c;
      belong[i + 1] = belong[i] + belonging(c);
    }
    std::fill(score.begin(), score.end(), 0.0);
    for (int i = 2 * half; i + 2 * half <= count; ++i) {
      const double inside = (belong[i - blurred] - belong[i - 2 * half]) / (2 * half - blurred),
                   outside = (belong[i + 2 * half] - belong[i + blurred]) / (2 * half - blurred);
      score[i] = cv::norm(color[i + half] - 2 * color[i] + color[i - half]) / half * inside *
                 (1 - despite * outside);
    }
    auto& edges = rays[k].edges;
    double sum = 0;
    while (edges.size() < edges.capacity()) {
      const auto peak = std::max_element(score.begin(), score.end());
      const double best = *peak;
      if (best < least_contrast || (!edges.empty() && best < least_share * edges.front().contrast)) break;
      const auto from = peak - std::min<std::ptrdiff_t>(half, peak - score.begin()),
                 to = peak + std::min<std::ptrdiff_t>(half + 1, score.end() - peak);
      double weights = 0, moment = 0;
      for (auto i = from; i != to; ++i) {
        const double weight = std::max(0.0, *i - 0.5 * best);
        weights += weight;
        moment += weight * (first + static_cast<double>(i - score.begin()) - 0.5);
      }
      edges.push_back({step * moment / weights, best, best * best});
      sum += best * best;
      std::fill(from, to, 0.0);
    }
    for (Edge& edge : edges) edge.share /= sum;
  }
  return rays;
}

constexpr double hidden = 0.3;  // of a ball's rim, expected
using Harmonics = Eigen::Matrix<double, 5, 1>;

Harmonics harmonics(int k) {
  const Eigen::Vector2d &once = directions()[k], &twice = directions()[2 * k % ray_count];
  return (Harmonics() << 1, once, twice).finished();
}

Harmonics fit(const std::array<Ray, ray_count>& rays, const Outline& circle) {
  const double r = circle.radius_px;
  Harmonics x = Harmonics::Zero();
  x[0] = r;
  const Harmonics prior = (Harmonics() << 0.2 * r, 0.2 * r, 0.2 * r, 0.03 * r, 0.03 * r).finished();
  for (const double scale : {0.1 * r, 0.06 * r, 0.04 * r, 0.03 * r, 0.02 * r}) {
    const double sigma = std::max(scale, loose_sigma(r, smooth_rim));
    Eigen::Matrix<double, 5, 5> normal = (sigma / prior.array()).square().matrix().asDiagonal();
    Harmonics right = normal * (Harmonics() << r, 0, 0, 0, 0).finished();
    for (int k = 0; k < ray_count; ++k) {
      const Harmonics h = harmonics(k);
      for (const Edge& edge : rays[k].edges) {
        const double z = (edge.radius_px - h.dot(x)) / (2 * sigma);
        const double w = edge.share / ((1 + z * z) * (1 + z * z));
        normal += w * h * h.transpose();
        right += w * edge.radius_px * h;
      }
    }
    x = normal.ldlt().solve(right);
  }
  return x;
}

void judge_shading(const cv::Mat3f& lab, const Outline& circle, const Likeness& like,
                   CircleEvidence& result) {
  const Eigen::Matrix2d to_unit = circle.shape.inverse() / circle.radius_px;
  const double reach = 0.88 * circle.radius_px * circle.shape.norm() / std::sqrt(2.0);
  const int step = std::max(1, static_cast<int>(reach / 12));
  Samples<Eigen::Vector4d> normals;
  Samples<Eigen::Array3d> lights;
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
      if (alike < alike_enough || lights.size() == lights.capacity()) continue;
      color += Eigen::Vector3d(c[0], c[1], c[2]);
      const double f = (c[0] + 16) / 116;
      normals.emplace_back(1, n.x(), n.y(), std::sqrt(1 - n.squaredNorm()));
      lights.push_back(Eigen::Array3d(f + c[1] / 500, f, f - c[2] / 200).max(0).cube());  // X, Y, Z
    }
  }
  result.filled = all > 0 ? filled / all : 0;
  if (lights.empty()) return;
  result.color = color / static_cast<double>(lights.size());
  if (lights.size() < 12) return;
  // What is as bright as that the camera has clipped: it looks flat but in the light of which it has least.
  constexpr double clipped = 86;  // L of pure green is 88, of yellow 97
  Eigen::Index by = 1;
  if (result.color.x() > clipped)
    std::accumulate(lights.begin(), lights.end(), Eigen::Array3d(0, 0, 0)).minCoeff(&by);
  Samples<double> light;
  for (const Eigen::Array3d& each : lights) light.push_back(each[by]);
  Samples<double> weight(light.size(), 1.0);
  Eigen::Vector4d x;
  for (int round = 0; round < 5; ++round) {
    Eigen::Matrix4d normal = 1e-6 * Eigen::Matrix4d::Identity();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (std::size_t i = 0; i < light.size(); ++i) {
      normal += weight[i] * normals[i] * normals[i].transpose();
      right += weight[i] * light[i] * normals[i];
    }
    x = normal.ldlt().solve(right);
    Samples<double> off;
    for (std::size_t i = 0; i < light.size(); ++i) off.push_back(std::abs(light[i] - x.dot(normals[i])));
    const double scale = 3 * sigma_of_median * upper_median(off) + 1e-4;
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

/// Mixture of edges on the circle, on a rim as rough as that, and of what hides it, which a ray meets inside
/// the circle: beyond it the ball has no surface.
Contour contour_of(const std::array<Ray, ray_count>& rays, const Harmonics& x, int stride, double rough) {
  constexpr double precise = 0.4;  // of the edges of a smooth ball
  constexpr double beyond = 0.15;  // of the edges off the circle
  const double r = x[0], tight = tight_sigma(r), loose = loose_sigma(r, rough), wide = 0.15 * r,
               uniform = 1 / r;
  const double exact = rough == smooth_rim ? precise : 0;
  const auto gauss = [](double v, double s) {
    return std::exp(-0.5 * v * v / (s * s)) / (s * std::sqrt(2 * M_PI));
  };
  Contour result;
  int seen = 0, on = 0;
  boost::container::static_vector<double, ray_count> contrast;
  for (int k = 0; k < ray_count; ++k) {
    if (!rays[k].in_picture) continue;
    ++seen;
    if (rays[k].edges.empty()) {
      result.ratio += std::log(hidden / 0.5) * stride / ray_count;
      continue;
    }
    double circle = 0, any = 0, nearest = 2.5 * loose;
    const Edge* rim = nullptr;
    for (const Edge& edge : rays[k].edges) {
      const double away = edge.radius_px - harmonics(k).dot(x);
      const double off = 2 * uniform * (away < 0 ? 1 - beyond : beyond);
      circle += edge.share *
                (exact * gauss(away, tight) + (1 - hidden - exact) * gauss(away, loose) + hidden * off);
      any += edge.share * (0.5 * gauss(away, wide) + 0.5 * uniform);
      if (std::abs(away) <= nearest) nearest = std::abs(away), rim = &edge;
    }
    result.ratio += std::log(circle / any) * stride / ray_count;
    if (rim) {
      ++on;
      contrast.push_back(rim->contrast);
    }
  }
  if (seen > 0) result.arc = static_cast<double>(on) / seen;
  if (!contrast.empty()) result.edge = upper_median(contrast);
  return result;
}

/// The rim is as rough as suits the picture.
Contour judge_contour(const std::array<Ray, ray_count>& rays, const Harmonics& x, int stride) {
  const Contour smooth = contour_of(rays, x, stride, smooth_rim),
                rough = contour_of(rays, x, stride, rough_rim);
  return smooth.ratio >= rough.ratio ? smooth : rough;
}

constexpr double whole_rim = 0.4;  // hands and marbling leave that of it

}  // namespace

double CircleEvidence::sphere() const {
  return shading * std::min(1.0, relief / 0.15) * std::min(1.0, rim / whole_rim);
}

constexpr double vivid = 2;

// Shaded as a sphere and of a colour of its own, a thing may be a leaf or a sleeve as well: it needs a rim
// that is a circle's.
double CircleEvidence::log_odds() const {
  constexpr double least_contour = 0.25, no_circle = 80;
  const double chroma = std::max(1.0, color.tail<2>().norm());
  return log_odds_of_known_color() - vivid + std::clamp(4 * std::log(chroma / 25), -6.0, vivid) -
         no_circle * std::max(0.0, least_contour - contour);
}

constexpr double something = 0.3, nothing_hides_it = 12;

// A perfect circle may be a disc: beyond some certainty its roundness counts as far as it is shaded.
double CircleEvidence::log_odds_of_known_color() const {
  return -4 + std::clamp(8 * contour, -8.0, 9 + 7 * sphere()) + 8 * sphere() - 4.5 + vivid +
         std::clamp(std::log(std::max(1.0, edge) / 12), -1.5, 1.5) +
         std::clamp(6 * (distinct - 0.7), -2.0, 2.0) +
         std::max(-8.0, std::min(0.0, 4 * std::log(std::max(1e-3, rim) / whole_rim))) -
         std::min(3.0, std::max(0.0, ellipse - 0.03) / 0.03) -
         nothing_hides_it * std::max(0.0, 1 - hidden_by / something) - pattern;
}

CircleEvidence circle_evidence(const cv::Mat3f& lab, const Outline& outline, const Eigen::Vector3d& color) {
  Outline circle = outline;
  CircleEvidence result;
  Harmonics x;
  Contour contour;
  constexpr int most_rounds = 6;
  constexpr double settled = 0.02;  // radii
  constexpr double small_px = 10;   // half the rays are two pixels apart there
  bool moves = true;
  for (int round = 0;; ++round) {
    const int stride = round == 0 || circle.radius_px < small_px ? 2 : 1;
    const auto rays = rays_of(lab, circle, stride);
    x = fit(rays, circle);
    contour = judge_contour(rays, x, stride);
    if ((round >= 1 && !moves) || round == most_rounds || contour.ratio < -0.3) break;
    const Eigen::Vector2d shift = circle.shape * Eigen::Vector2d(x[1], x[2]);
    if (!x.allFinite() || shift.norm() > 0.5 * circle.radius_px || x[0] < 0.6 * circle.radius_px ||
        x[0] > 1.6 * circle.radius_px)
      break;
    moves = shift.norm() + std::abs(x[0] - circle.radius_px) > settled * circle.radius_px;
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
  const Outline found{result.center_px, result.radius_px, circle.shape};
  const Likeness like(color);
  Belonging belonging(lab, found);
  result.distinct = belonging.distinctness(lab, found);
  result.rim = belonging.part_of_rim(lab, found, like);
  judge_shading(lab, found, like, result);
  result.hidden_by = difference_of_cover(lab, found, like);
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
