#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "calibration/camera/sphere_outline.hpp"
#include "servo/simulation/rendering/scene.hpp"
#include "servo/simulation/rendering/truth.hpp"

namespace ballservo {

namespace {

constexpr int rows = 256, border_points = 32, round_corners = 48;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// The part of a line of constant y, from low to high.
struct ShadowSpan {
  double low = 0, high = 0;
};

/// The ball as seen from a camera: a circle of radius `tangent` about the origin of the plane z = 1 of a
/// frame whose z axis points to its centre.
struct BallDisc {
  Eigen::Vector3d origin_W{0, 0, 0};                   ///< the camera
  Eigen::Matrix3d R_WD = Eigen::Matrix3d::Identity();  ///< columns: the plane's axes, and the ray
  double tangent = 0;                                  ///< of half the angle that the ball spans
  double distance_m = 0;
  double near_m = 0, far_m = 0;  ///< along the ray: what hides the ball lies between the two
};

/// What one thing in front of a ball hides of it, in the plane of its disc: convex.
struct Shadow {
  std::vector<Eigen::Vector2d> polygon;  ///< counter-clockwise; else a conic:
  Eigen::Vector3d cone_axis{0, 0, 1};    ///< the other ball's centre
  double cone_square = 0;                ///< |centre|^2 - radius^2

  std::optional<ShadowSpan> at(double y) const;
};

using Edge = std::pair<Eigen::Vector3d, Eigen::Vector3d>;

/// The edges of a solid in its own frame; round ones as prisms.
std::vector<Edge> edges_of(const SceneSolid& solid) {
  std::vector<Eigen::Vector2d> base;
  if (solid.kind == SceneSolid::Kind::cylinder) {
    // Between the polygons inside and outside of the circle.
    const double step = 2 * M_PI / round_corners;
    const double radius = solid.half.x() * 0.5 * (1 + 1 / std::cos(0.5 * step));
    for (int k = 0; k < round_corners; ++k)
      base.emplace_back(radius * std::cos(k * step), radius * std::sin(k * step));
  } else {
    const double a = solid.half.x(), b = solid.half.y();
    base = {{-a, -b}, {a, -b}, {a, b}, {-a, b}};
  }
  std::vector<Edge> edges;
  const auto point = [](const Eigen::Vector2d& p, double z) { return Eigen::Vector3d(p.x(), p.y(), z); };
  const double h = solid.half.z();
  for (std::size_t k = 0; k < base.size(); ++k) {
    const Eigen::Vector2d &p = base[k], &q = base[(k + 1) % base.size()];
    edges.push_back({point(p, -h), point(q, -h)});
    edges.push_back({point(p, h), point(q, h)});
    edges.push_back({point(p, -h), point(p, h)});
  }
  return edges;
}

std::vector<Edge> edges_of_disc(double radius) {
  std::vector<Edge> edges;
  const auto point = [radius](int k) {
    const double angle = 2 * M_PI * k / round_corners;
    return Eigen::Vector3d(0, radius * std::cos(angle), radius * std::sin(angle));
  };
  for (int k = 0; k < round_corners; ++k) edges.push_back({point(k), point(k + 1)});
  return edges;
}

/// Convex hull, counter-clockwise (Andrew, Information Processing Letters 9, 1979).
std::vector<Eigen::Vector2d> hull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(),
            [](const auto& a, const auto& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  std::vector<Eigen::Vector2d> chain(2 * points.size() + 1);
  std::size_t count = 0;
  const auto add = [&](const Eigen::Vector2d& p, std::size_t from) {
    while (count >= from + 2 && cross(chain[count - 1] - chain[count - 2], p - chain[count - 2]) <= 0)
      --count;
    chain[count++] = p;
  };
  for (const auto& p : points) add(p, 0);
  const std::size_t lower = count - 1;
  for (std::size_t k = points.size() - 1; k-- > 0;) add(points[k], lower);
  chain.resize(count > 1 ? count - 1 : count);
  return chain;
}

/// Whether something within that radius of a point (in the disc's frame) could hide any of it.
bool near_cone(const Eigen::Vector3d& p_D, double radius, const BallDisc& disc) {
  const double distance = p_D.norm();
  if (distance <= radius) return true;
  if (p_D.z() - radius >= disc.far_m || p_D.z() + radius <= 0) return false;
  return std::atan2(p_D.head<2>().norm(), p_D.z()) < std::atan(disc.tangent) + std::asin(radius / distance);
}

/// Nothing where the camera is inside the ball. The axes are those of `R_WC` turned as little as need be.
std::optional<BallDisc> disc_of(const SceneBall& ball, const Eigen::Isometry3d& X_WC) {
  const Eigen::Vector3d away = ball.center - X_WC.translation();
  BallDisc disc;
  disc.distance_m = away.norm();
  if (!(disc.distance_m > ball.radius)) return std::nullopt;
  disc.origin_W = X_WC.translation();
  const Eigen::Vector3d ray_C = X_WC.linear().transpose() * away / disc.distance_m;
  disc.R_WD.leftCols<2>() = X_WC.linear() * perpendicular_basis(ray_C);
  disc.R_WD.col(2) = away / disc.distance_m;
  const double sine = ball.radius / disc.distance_m;
  disc.tangent = sine / std::sqrt(1 - sine * sine);
  // All that is seen of the ball lies before the plane of the circle where rays touch it, and so does all
  // that hides it.
  disc.far_m = disc.distance_m * (1 - sine * sine);
  disc.near_m = 1e-4 * disc.distance_m;
  return disc;
}

/// Nothing where it hides nothing of the disc.
std::optional<Shadow> shadow_of(const SceneSolid& solid, const BallDisc& disc) {
  const Eigen::Vector3d center_D = disc.R_WD.transpose() * (solid.center - disc.origin_W);
  if (!near_cone(center_D, solid.bounding_radius, disc)) return std::nullopt;
  Eigen::Matrix3d R_WS;
  R_WS << solid.cos_yaw, -solid.sin_yaw, 0, solid.sin_yaw, solid.cos_yaw, 0, 0, 0, 1;
  const Eigen::Matrix3d R_DS = disc.R_WD.transpose() * R_WS;
  std::vector<Eigen::Vector2d> points;
  const auto add = [&](const Eigen::Vector3d& p_D) { points.emplace_back(p_D.head<2>() / p_D.z()); };
  const auto inside = [&](const Eigen::Vector3d& p_D) {
    return p_D.z() >= disc.near_m && p_D.z() <= disc.far_m;
  };
  const auto edges = solid.kind == SceneSolid::Kind::disc ? edges_of_disc(solid.half.z()) : edges_of(solid);
  for (const auto& [from, to] : edges) {
    const Eigen::Vector3d a = center_D + R_DS * from, b = center_D + R_DS * to;
    if (inside(a)) add(a);
    if (inside(b)) add(b);
    for (const double z : {disc.near_m, disc.far_m}) {
      if ((a.z() < z) != (b.z() < z)) add(a + (z - a.z()) / (b.z() - a.z()) * (b - a));
    }
  }
  if (points.size() < 3) return std::nullopt;
  Shadow shadow;
  shadow.polygon = hull(std::move(points));
  if (shadow.polygon.size() < 3) return std::nullopt;
  // Some edge has the whole disc on its outer side.
  for (std::size_t k = 0; k < shadow.polygon.size(); ++k) {
    const Eigen::Vector2d& p = shadow.polygon[k];
    const Eigen::Vector2d along = (shadow.polygon[(k + 1) % shadow.polygon.size()] - p).normalized();
    if (cross(along, -p) <= -disc.tangent) return std::nullopt;
  }
  return shadow;
}

std::optional<Shadow> shadow_of(const SceneBall& ball, const BallDisc& disc) {
  const Eigen::Vector3d center_D = disc.R_WD.transpose() * (ball.center - disc.origin_W);
  if (center_D.z() >= disc.distance_m || !near_cone(center_D, ball.radius, disc)) return std::nullopt;
  Shadow shadow;
  shadow.cone_axis = center_D;
  shadow.cone_square = center_D.squaredNorm() - ball.radius * ball.radius;
  return shadow;
}

std::optional<ShadowSpan> Shadow::at(double y) const {
  if (!polygon.empty()) {
    ShadowSpan span{infinity, -infinity};
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const Eigen::Vector2d &a = polygon[k], &b = polygon[k + 1 == polygon.size() ? 0 : k + 1];
      if ((a.y() <= y) == (b.y() <= y)) continue;
      const double x = a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
      span.low = std::min(span.low, x);
      span.high = std::max(span.high, x);
    }
    return span.low < span.high ? std::make_optional(span) : std::nullopt;
  }
  // The rays p = (x, y, 1) within the other ball's tangent cone: (p . c)^2 >= |p|^2 (|c|^2 - r^2), p . c > 0.
  if (cone_square <= 0) return ShadowSpan{-infinity, infinity};
  const Eigen::Vector3d& c = cone_axis;
  const double rest = c.y() * y + c.z();
  const double a = c.x() * c.x() - cone_square, b = c.x() * rest, e = rest * rest - cone_square * (y * y + 1);
  const double discriminant = b * b - a * e;
  if (discriminant <= 0 || a == 0) return std::nullopt;
  const double root = std::sqrt(discriminant), one = (-b - root) / a, other = (-b + root) / a;
  const ShadowSpan between{std::min(one, other), std::max(one, other)};
  if (a < 0) {
    const double middle = 0.5 * (one + other);
    return c.x() * middle + rest > 0 ? std::make_optional(between) : std::nullopt;
  }
  return c.x() > 0 ? ShadowSpan{between.high, infinity} : ShadowSpan{-infinity, between.low};
}

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
  const auto disc = disc_of(scene.balls()[ball], X_WC);
  if (!disc) return 0;
  std::vector<Shadow> shadows;
  for (const SceneSolid& solid : scene.solids()) {
    if (auto shadow = shadow_of(solid, *disc)) shadows.push_back(*std::move(shadow));
  }
  for (std::size_t k = 0; k < scene.balls().size(); ++k) {
    if (k == ball) continue;
    if (auto shadow = shadow_of(scene.balls()[k], *disc)) shadows.push_back(*std::move(shadow));
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
