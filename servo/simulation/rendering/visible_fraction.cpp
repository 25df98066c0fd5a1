#include "servo/simulation/rendering/visible_fraction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "servo/simulation/rendering/shadow.hpp"

namespace ballservo {

namespace {

constexpr int rows = 256, border_points = 32;

/// A function on the square about the disc, as the polynomial of degree two in each direction through nine of
/// its values.
class NinePoints {
 public:
  NinePoints(double half, const std::array<double, 9>& values) : half_(half), values_(values) {}

  /// Its coefficients along a row: c[0] + c[1] x + c[2] x^2.
  std::array<double, 3> row(double y) const {
    const std::array<double, 3> across = weights(y / half_);
    std::array<double, 3> at{};
    for (std::size_t column = 0; column < 3; ++column) {
      for (std::size_t k = 0; k < 3; ++k) at[column] += across[k] * values_[3 * k + column];
    }
    return {at[1], 0.5 * (at[2] - at[0]) / half_, (0.5 * (at[0] + at[2]) - at[1]) / (half_ * half_)};
  }

 private:
  static std::array<double, 3> weights(double s) { return {0.5 * s * (s - 1), 1 - s * s, 0.5 * s * (s + 1)}; }
  double half_;
  std::array<double, 9> values_;
};

double value(const std::array<double, 3>& c, double x) { return c[0] + x * (c[1] + x * c[2]); }
double integral(const std::array<double, 3>& c, double from, double to) {
  const auto primitive = [&c](double x) { return x * (c[0] + x * (c[1] / 2 + x * c[2] / 3)); };
  return primitive(to) - primitive(from);
}

/// Keeps the part of the span in which sign * (c - bound) >= 0: one end's part where the signs at the ends
/// differ.
void keep(const std::array<double, 3>& c, double sign, double bound, ShadowSpan& span) {
  const auto good = [&](double x) { return sign * (value(c, x) - bound) >= 0; };
  const bool low = good(span.low), high = good(span.high);
  if (low && high) return;
  if (!low && !high) {
    span.high = span.low;
    return;
  }
  double inside = low ? span.low : span.high, outside = low ? span.high : span.low;
  for (int k = 0; k < 40; ++k) {
    const double middle = 0.5 * (inside + outside);
    (good(middle) ? inside : outside) = middle;
  }
  (low ? span.high : span.low) = inside;
}

/// What the camera makes of the plane of the disc: pixels, and their area for an area there.
struct DiscPicture {
  NinePoints u_px, v_px, area;
};

std::optional<DiscPicture> picture_of(const Camera& camera, const Eigen::Matrix3d& R_CD, double half) {
  std::array<double, 9> u{}, v{}, area{};
  for (std::size_t k = 0; k < 9; ++k) {
    const double x = half * (static_cast<double>(k % 3) - 1), y = half * (static_cast<double>(k / 3) - 1);
    const Eigen::Vector3d p = R_CD * Eigen::Vector3d(x, y, 1);
    const auto pixel = camera.project(p);
    const auto jacobian = camera.project_jacobian(p);
    if (!pixel || !jacobian) return std::nullopt;
    u[k] = pixel->x();
    v[k] = pixel->y();
    area[k] = std::abs((*jacobian * R_CD.leftCols<2>()).determinant());
  }
  return DiscPicture{{half, u}, {half, v}, {half, area}};
}

/// Whether the outline lies in the picture with a little room.
bool well_inside(const Camera& camera, const Eigen::Matrix3d& R_CD, double tangent) {
  // Between two points of 32 the outline bulges by half a per cent of its radius.
  const double reach = 1.01 * tangent;
  for (int k = 0; k < border_points; ++k) {
    const double angle = 2 * M_PI * k / border_points;
    const auto pixel =
        camera.project(R_CD * Eigen::Vector3d(reach * std::cos(angle), reach * std::sin(angle), 1));
    if (!pixel || pixel->x() < -0.5 || pixel->y() < -0.5 || pixel->x() > camera.size().width_px - 0.5 ||
        pixel->y() > camera.size().height_px - 0.5)
      return false;
  }
  return true;
}

/// Of a span what no shadow covers, weighted.
double unhidden(const std::vector<Shadow>& shadows, double y, const ShadowSpan& span,
                const std::array<double, 3>& weight, std::vector<ShadowSpan>& hidden) {
  hidden.clear();
  for (const Shadow& shadow : shadows) {
    if (const auto part = shadow.at(y)) hidden.push_back(*part);
  }
  std::sort(hidden.begin(), hidden.end(),
            [](const ShadowSpan& a, const ShadowSpan& b) { return a.low < b.low; });
  double sum = 0, from = span.low;
  for (const ShadowSpan& part : hidden) {
    const double to = std::min(part.low, span.high);
    if (to > from) sum += integral(weight, from, to);
    from = std::max(from, part.high);
  }
  return from < span.high ? sum + integral(weight, from, span.high) : sum;
}

}  // namespace

double visible_fraction(const Camera& camera, const Scene& scene, const Eigen::Isometry3d& X_WC,
                        std::size_t ball) {
  const auto disc = BallDisc::of(scene.balls()[ball], X_WC);
  if (!disc) return 0;
  std::vector<Shadow> shadows;
  for (const SceneSolid& solid : scene.solids()) {
    if (auto shadow = Shadow::of(solid, *disc)) shadows.push_back(*std::move(shadow));
  }
  for (std::size_t k = 0; k < scene.balls().size(); ++k) {
    if (k == ball) continue;
    if (auto shadow = Shadow::of(scene.balls()[k], *disc)) shadows.push_back(*std::move(shadow));
  }
  const Eigen::Matrix3d R_CD = X_WC.linear().transpose() * disc->R_WD;
  const bool whole = well_inside(camera, R_CD, disc->tangent);
  if (whole && shadows.empty()) return 1;
  const auto picture = picture_of(camera, R_CD, disc->tangent);
  if (!picture) return 0;

  const double right_px = camera.size().width_px - 0.5, bottom_px = camera.size().height_px - 0.5;
  double area = 0, visible = 0;
  std::vector<ShadowSpan> hidden;
  for (int row = 0; row < rows; ++row) {
    const double y = disc->tangent * (2 * (row + 0.5) / rows - 1);
    const double half = std::sqrt(disc->tangent * disc->tangent - y * y);
    ShadowSpan span{-half, half};
    const auto weight = picture->area.row(y);
    area += integral(weight, span.low, span.high);
    if (!whole) {
      const auto u = picture->u_px.row(y), v = picture->v_px.row(y);
      keep(u, 1, -0.5, span);
      keep(u, -1, right_px, span);
      keep(v, 1, -0.5, span);
      keep(v, -1, bottom_px, span);
    }
    if (span.low < span.high) visible += unhidden(shadows, y, span, weight, hidden);
  }
  return area > 0 ? std::clamp(visible / area, 0.0, 1.0) : 0.0;
}

}  // namespace ballservo
