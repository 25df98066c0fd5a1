#include "servo/simulation/rendering/shadow.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {

namespace {

constexpr int round_corners = 48;
constexpr double infinity = std::numeric_limits<double>::infinity();

using Edge = std::pair<Eigen::Vector3d, Eigen::Vector3d>;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

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

}  // namespace

std::optional<BallDisc> BallDisc::of(const SceneBall& ball, const Eigen::Isometry3d& X_WC) {
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

std::optional<Shadow> Shadow::of(const SceneSolid& solid, const BallDisc& disc) {
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
  const auto beyond = [&](int axis, double sign) {
    return std::all_of(points.begin(), points.end(),
                       [&](const Eigen::Vector2d& p) { return sign * p[axis] >= disc.tangent; });
  };
  if (beyond(0, 1) || beyond(0, -1) || beyond(1, 1) || beyond(1, -1)) return std::nullopt;
  Shadow shadow;
  shadow.polygon_ = hull(std::move(points));
  if (shadow.polygon_.size() < 3) return std::nullopt;
  // Some edge has the whole disc on its outer side.
  for (std::size_t k = 0; k < shadow.polygon_.size(); ++k) {
    const Eigen::Vector2d& p = shadow.polygon_[k];
    const Eigen::Vector2d along = (shadow.polygon_[(k + 1) % shadow.polygon_.size()] - p).normalized();
    if (cross(along, -p) <= -disc.tangent) return std::nullopt;
  }
  return shadow;
}

std::optional<Shadow> Shadow::of(const SceneBall& ball, const BallDisc& disc) {
  const Eigen::Vector3d center_D = disc.R_WD.transpose() * (ball.center - disc.origin_W);
  if (center_D.z() >= disc.distance_m || !near_cone(center_D, ball.radius, disc)) return std::nullopt;
  Shadow shadow;
  shadow.cone_axis_ = center_D;
  shadow.cone_square_ = center_D.squaredNorm() - ball.radius * ball.radius;
  return shadow;
}

std::optional<ShadowSpan> Shadow::at(double y) const {
  if (!polygon_.empty()) {
    ShadowSpan span{infinity, -infinity};
    for (std::size_t k = 0; k < polygon_.size(); ++k) {
      const Eigen::Vector2d &a = polygon_[k], &b = polygon_[k + 1 == polygon_.size() ? 0 : k + 1];
      if ((a.y() <= y) == (b.y() <= y)) continue;
      const double x = a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
      span.low = std::min(span.low, x);
      span.high = std::max(span.high, x);
    }
    return span.low < span.high ? std::make_optional(span) : std::nullopt;
  }
  // The rays p = (x, y, 1) within the other ball's tangent cone: (p . c)^2 >= |p|^2 (|c|^2 - r^2), p . c > 0.
  if (cone_square_ <= 0) return ShadowSpan{-infinity, infinity};
  const Eigen::Vector3d& c = cone_axis_;
  const double rest = c.y() * y + c.z();
  const double a = c.x() * c.x() - cone_square_, b = c.x() * rest,
               e = rest * rest - cone_square_ * (y * y + 1);
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

}  // namespace ballservo
