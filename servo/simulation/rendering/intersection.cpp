#include <algorithm>
#include <cmath>

#include "servo/simulation/rendering/scene.hpp"

namespace ballservo {

namespace {

Eigen::Vector3d to_solid(const SceneSolid& solid, const Eigen::Vector3d& v) {
  return {solid.cos_yaw * v.x() + solid.sin_yaw * v.y(), -solid.sin_yaw * v.x() + solid.cos_yaw * v.y(),
          v.z()};
}

Eigen::Vector3d from_solid(const SceneSolid& solid, const Eigen::Vector3d& v) {
  return {solid.cos_yaw * v.x() - solid.sin_yaw * v.y(), solid.sin_yaw * v.x() + solid.cos_yaw * v.y(),
          v.z()};
}

double hit_box(const Eigen::Vector3d& o, const Eigen::Vector3d& d, const Eigen::Vector3d& half) {
  double enter = -no_hit, leave = no_hit;
  for (int axis = 0; axis < 3; ++axis) {
    if (d[axis] == 0.0) {
      if (std::abs(o[axis]) > half[axis]) return no_hit;
      continue;
    }
    const double inverse = 1.0 / d[axis];
    const double a = (-half[axis] - o[axis]) * inverse, b = (half[axis] - o[axis]) * inverse;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave && enter > 0.0 ? enter : no_hit;
}

double hit_cylinder(const Eigen::Vector3d& o, const Eigen::Vector3d& d, double radius, double half_height) {
  double enter = -no_hit, leave = no_hit;
  const double a = d.x() * d.x() + d.y() * d.y();
  const double c = o.x() * o.x() + o.y() * o.y() - radius * radius;
  if (a < 1e-15) {
    if (c > 0.0) return no_hit;
  } else {
    const double b = o.x() * d.x() + o.y() * d.y();
    const double discriminant = b * b - a * c;
    if (discriminant < 0.0) return no_hit;
    const double root = std::sqrt(discriminant);
    enter = (-b - root) / a;
    leave = (-b + root) / a;
  }
  if (d.z() == 0.0) {
    if (std::abs(o.z()) > half_height) return no_hit;
  } else {
    const double low = (-half_height - o.z()) / d.z(), high = (half_height - o.z()) / d.z();
    enter = std::max(enter, std::min(low, high));
    leave = std::min(leave, std::max(low, high));
  }
  return enter <= leave && enter > 0.0 ? enter : no_hit;
}

double hit_disc(const Eigen::Vector3d& o, const Eigen::Vector3d& d, double radius) {
  if (d.x() == 0.0) return no_hit;
  const double t = -o.x() / d.x();
  if (t <= 0.0) return no_hit;
  const double y = o.y() + t * d.y(), z = o.z() + t * d.z();
  return y * y + z * z <= radius * radius ? t : no_hit;
}

}  // namespace

double hit_solid(const SceneSolid& solid, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d o = to_solid(solid, origin - solid.center), d = to_solid(solid, direction);
  switch (solid.kind) {
    case SceneSolid::Kind::box:
      return hit_box(o, d, solid.half);
    case SceneSolid::Kind::cylinder:
      return hit_cylinder(o, d, solid.half.x(), solid.half.z());
    case SceneSolid::Kind::disc:
      return hit_disc(o, d, solid.half.z());
  }
  return no_hit;
}

void describe_hit(const SceneSolid& solid, const Eigen::Vector3d& p, const Eigen::Vector3d& direction,
                  SurfaceHit& hit, int& face) {
  const Eigen::Vector3d q = to_solid(solid, p - solid.center);
  Eigen::Vector3d normal, u_axis, v_axis;
  const double radial = std::hypot(q.x(), q.y());
  // On a cylinder's rim both are near zero; the nearer surface counts.
  const bool end = solid.half.z() - std::abs(q.z()) < solid.half.x() - radial;
  if (solid.kind == SceneSolid::Kind::cylinder && !end) {
    face = 0;
    normal = Eigen::Vector3d(q.x(), q.y(), 0) / std::max(radial, 1e-12);
    u_axis = {-normal.y(), normal.x(), 0};
    v_axis = {0, 0, 1};
    hit.uv_m = {solid.half.x() * std::atan2(q.y(), q.x()), q.z()};
  } else {
    int axis = solid.kind == SceneSolid::Kind::disc ? 0 : 2;
    if (solid.kind == SceneSolid::Kind::box) (solid.half - q.cwiseAbs()).minCoeff(&axis);
    const bool positive =
        solid.kind == SceneSolid::Kind::disc ? to_solid(solid, direction).x() <= 0 : q[axis] > 0;
    const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    face = 2 * axis + (positive ? 1 : 0);
    normal = Eigen::Vector3d::Unit(axis) * (positive ? 1.0 : -1.0);
    u_axis = Eigen::Vector3d::Unit(u);
    v_axis = Eigen::Vector3d::Unit(v);
    hit.uv_m = {q[u], q[v]};
  }
  hit.normal = from_solid(solid, normal);
  hit.u_axis = from_solid(solid, u_axis);
  hit.v_axis = from_solid(solid, v_axis);
}

}  // namespace ballservo
