#include <algorithm>
#include <cmath>
#include <limits>

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

bool is_side(const SceneSolid& solid, int face) {
  return solid.kind == SceneSolid::Kind::cylinder && face == 0;
}

Triples to_solid(const SceneSolid& solid, const Triples& v) {
  const auto cosine = static_cast<float>(solid.cos_yaw), sine = static_cast<float>(solid.sin_yaw);
  return {cosine * v.x + sine * v.y, cosine * v.y - sine * v.x, v.z};
}

/// Where rays come in between two planes and go out again, across one axis.
struct Crossing {
  Floats enter, leave;
};

Crossing cross_slab(double o, Floats d, double half) {
  const Floats a = spread(-half - o) / d, b = spread(half - o) / d;
  return {min(a, b), max(a, b)};
}

/// The face of an axis that rays come in through.
Ints entered_face(int axis, Floats d) { return (d > 0.0f ? Ints{} : Ints{} + 1) + 2 * axis; }

}  // namespace

BALLSERVO_WIDE void hit_solid(const SceneSolid& solid, int index, const Eigen::Vector3d& origin,
                              const Triples& directions, SurfaceHits& nearest) {
  const Eigen::Vector3d o = to_solid(solid, origin - solid.center);
  const Triples d = to_solid(solid, directions);
  Floats enter, leave;
  Ints face;
  switch (solid.kind) {
    case SceneSolid::Kind::box: {
      const Crossing x = cross_slab(o.x(), d.x, solid.half.x()), y = cross_slab(o.y(), d.y, solid.half.y()),
                     z = cross_slab(o.z(), d.z, solid.half.z());
      enter = max(max(x.enter, y.enter), z.enter);
      leave = min(min(x.leave, y.leave), z.leave);
      face = enter == x.enter   ? entered_face(0, d.x)
             : enter == y.enter ? entered_face(1, d.y)
                                : entered_face(2, d.z);
      break;
    }
    case SceneSolid::Kind::cylinder: {
      const auto radius = static_cast<float>(solid.half.x());
      const auto ox = static_cast<float>(o.x()), oy = static_cast<float>(o.y());
      const Floats a = max(d.x * d.x + d.y * d.y, spread(1e-15f)), b = ox * d.x + oy * d.y;
      // b^2 - a c without the difference of two large numbers.
      const Floats across = ox * d.y - oy * d.x, discriminant = a * radius * radius - across * across;
      const Floats root = square_root(max(discriminant, spread(0.0f)));
      const Crossing z = cross_slab(o.z(), d.z, solid.half.z());
      const Floats none = spread(std::numeric_limits<float>::infinity());
      const Floats side = discriminant < 0.0f ? none : (-b - root) / a;
      enter = max(side, z.enter);
      leave = min((root - b) / a, z.leave);
      face = enter == side ? Ints{} : entered_face(2, d.z);
      break;
    }
    case SceneSolid::Kind::disc: {
      const auto radius = static_cast<float>(solid.half.z());
      enter = leave = spread(-o.x()) / d.x;
      const Floats y = static_cast<float>(o.y()) + enter * d.y, z = static_cast<float>(o.z()) + enter * d.z;
      leave = y * y + z * z <= radius * radius ? leave : spread(0.0f);
      face = entered_face(0, d.x);
      break;
    }
  }
  const Ints hit = (enter <= leave) & (enter > 0.0f) & (enter < nearest.t);
  nearest.t = hit ? enter : nearest.t;
  nearest.surface = hit ? face + 8 * (index + 1) : nearest.surface;
}

BALLSERVO_WIDE SurfacePoints points_of_face(const SceneSolid& solid, int face, const Eigen::Vector3d& origin,
                                            const Floats& t, const Triples& directions) {
  const Eigen::Vector3f o = to_solid(solid, origin - solid.center).cast<float>();
  const Triples d = to_solid(solid, directions);
  const Floats ways[] = {d.x, d.y, d.z};
  const Floats q[] = {o.x() + t * d.x, o.y() + t * d.y, o.z() + t * d.z};
  if (is_side(solid, face)) {
    const auto radius = static_cast<float>(solid.half.x());
    const Floats nx = q[0] / radius, ny = q[1] / radius;
    const auto cosine = static_cast<float>(solid.cos_yaw), sine = static_cast<float>(solid.sin_yaw);
    return {{radius * angle_of(q[1], q[0]), q[2]},
            nx * d.x + ny * d.y,
            nx * d.y - ny * d.x,
            d.z,
            {cosine * nx - sine * ny, sine * nx + cosine * ny, spread(0.0f)}};
  }
  const FacePlane plane = face_plane(face);
  const Eigen::Vector3d normal = from_solid(solid, plane.sign * Eigen::Vector3d::Unit(plane.axis));
  return {{q[plane.u], q[plane.v]}, ways[plane.axis], ways[plane.u], ways[plane.v], spread(normal)};
}

Eigen::Vector2d half_extent_of_face(const SceneSolid& solid, int face) {
  if (is_side(solid, face)) return {M_PI * solid.half.x(), solid.half.z()};
  const FacePlane plane = face_plane(face);
  return {solid.half[plane.u], solid.half[plane.v]};
}

std::pair<Eigen::Vector3d, Eigen::Vector3d> place_on_face(const SceneSolid& solid, int face,
                                                          const Eigen::Vector2d& uv_m) {
  Eigen::Vector3d q, normal;
  if (is_side(solid, face)) {
    const double angle_rad = uv_m.x() / solid.half.x();
    normal = {std::cos(angle_rad), std::sin(angle_rad), 0};
    q = solid.half.x() * normal;
    q.z() = uv_m.y();
  } else {
    const FacePlane plane = face_plane(face);
    normal = plane.sign * Eigen::Vector3d::Unit(plane.axis);
    q[plane.u] = uv_m.x();
    q[plane.v] = uv_m.y();
    q[plane.axis] = plane.sign * solid.half[plane.axis];
  }
  return {solid.center + from_solid(solid, q), from_solid(solid, normal)};
}

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

}  // namespace ballservo
