// The world at one instant, laid out for ray casting: nearest surfaces and the light that they send back.
//
// Rays are p = origin + t * direction with unit directions; t is in metres. All in the world frame.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "servo/simulation/world/quad_grid.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

/// A ball at its place.
struct SceneBall {
  Eigen::Vector3d center{0, 0, 0};
  double radius = 0;
  Material material;
};

/// An obstacle with what ray tests need of it.
struct SceneSolid {
  enum class Kind { box, cylinder, disc } kind = Kind::box;
  Eigen::Vector3d center{0, 0, 0};
  Eigen::Vector3d half{
      0, 0, 0};  ///< box: half sizes; cylinder: (radius, radius, half height); disc: (0, radius, radius)
  double cos_yaw = 1, sin_yaw = 0;
  double bounding_radius = 0;
  Material material;
};

/// Where rays meet the nearest surfaces, one a lane: `t` beyond every float where a ray has no direction.
struct SurfaceHits {
  Floats t;
  Ints surface;  ///< 0-5: the room's faces; then 8 + 8 * solid + face (of a cylinder 0 is the side)
};

/// Points of one surface as rays of unit length meet them.
struct SurfacePoints {
  Pairs uv_m;                             ///< surface coordinates for the texture
  Floats along_normal, along_u, along_v;  ///< the directions' parts
  Triples normal;
};

template <typename Scalar>
Triples spread(const Eigen::Matrix<Scalar, 3, 1>& v) {
  return {spread(v.x()), spread(v.y()), spread(v.z())};
}

/// Of the flat faces of the room (in the world's axes) and of the solids (in their own): -x +x -y +y -z +z.
/// The axis across the face, on which side of the middle it lies, and the axes along which its surface
/// coordinates run. Normals point outwards for solids, inwards for the room.
struct FacePlane {
  int axis, u, v;
  double sign;
};
constexpr FacePlane face_plane(int face) {
  const int axis = face / 2;
  return {axis, axis == 0 ? 1 : 0, axis == 2 ? 1 : 2, face % 2 == 1 ? 1.0 : -1.0};
}
constexpr int floor_face = 4, ceiling_face = 5;  ///< of the room

/// The solid to which a surface belongs; -1: the room.
constexpr int solid_of(int surface) { return surface / 8 - 1; }

/// Points on the unit disc, spread evenly (Vogel, Mathematical Biosciences 1979).
template <std::size_t count>
const std::array<Eigen::Vector2d, count>& disc_samples() {
  static const std::array<Eigen::Vector2d, count> samples = [] {
    std::array<Eigen::Vector2d, count> points;
    for (std::size_t k = 0; k < count; ++k) {
      const double radius = std::sqrt((static_cast<double>(k) + 0.5) / count);
      const double angle = 2.399963229728653 * static_cast<double>(k);
      points[k] = {radius * std::cos(angle), radius * std::sin(angle)};
    }
    return points;
  }();
  return samples;
}

inline constexpr double no_hit = std::numeric_limits<double>::infinity();

/// Distance along the ray to a solid's surface, `no_hit` where it misses it or starts inside.
double hit_solid(const SceneSolid& solid, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction);

/// Of many rays: `nearest` becomes solid `index` where they meet it first.
void hit_solid(const SceneSolid& solid, int index, const Eigen::Vector3d& origin, const Triples& directions,
               SurfaceHits& nearest);

/// Points of one face of the solid, which lie at t along the rays.
SurfacePoints points_of_face(const SceneSolid& solid, int face, const Eigen::Vector3d& origin,
                             const Floats& t, const Triples& directions);

/// A face's extent in surface coordinates, from -half to +half.
Eigen::Vector2d half_extent_of_face(const SceneSolid& solid, int face);
/// The point (world) and the normal there of a face's surface coordinates.
std::pair<Eigen::Vector3d, Eigen::Vector3d> place_on_face(const SceneSolid& solid, int face,
                                                          const Eigen::Vector2d& uv_m);

/// Whether a light map serves for it: it sends back the same to all sides, and nothing of its own.
inline bool is_plainly_lit(const Material& material) {
  return material.specular == 0.0 && !material.luminous;
}

/// Lamps and solids stand still, so this is worked out once: what every plainly lit surface gets of the lamps
/// that change alike, in the shade of the solids but not of the balls, on a grid of 4 cm (coarser where a
/// surface is longer than 16 m, finer around a cylinder), interpolated in between.
class LightMap {
 public:
  explicit LightMap(const World& world);

  /// By how much the lamps of each course shine brighter than the world says.
  std::vector<Rgb> gains(double time_s) const;

  /// The light of all lamps on points, with those gains. `surface` and `uv_m` as in SurfaceHits and
  /// SurfacePoints.
  Triples light(int surface, const Pairs& uv_m, const std::vector<Rgb>& gains) const;

 private:
  struct Grid {
    Eigen::Vector2d origin_m{0, 0};
    Eigen::Vector2d cells_per_m{1, 1};
    std::vector<QuadGrid> lights;  // of each course: red, green, blue; none: nothing to be lit
  };
  std::vector<LightCourse> courses_;
  std::vector<Grid> grids_;  // by surface
};

class Scene {
 public:
  /// `light_map`, of the same world, may stand in for the lamps where no ball shades them; it must outlive
  /// the scene.
  Scene(const World& world, double time_s, const LightMap* light_map = nullptr);

  const std::vector<SceneBall>& balls() const { return balls_; }
  const std::vector<SceneSolid>& solids() const { return solids_; }
  const Material& material_of(int surface) const;

  /// The nearest surfaces of the room or of solids among `candidates` (indices of solids), balls apart, that
  /// rays of unit length meet.
  SurfaceHits hit_surfaces(const Eigen::Vector3d& origin, const Triples& directions,
                           const std::vector<int>& candidates) const;

  /// Distance to the first solid (room and balls apart) before t_max along the ray, or t_max.
  double hit_solids(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double t_max) const;

  /// What a point of `surface` (as in SurfaceHits) sends towards the viewer, at t along a ray of unit length.
  /// `pixel_rad` is the angle that a pixel spans, for the texture.
  Rgb shade_surface(int surface, float t, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                    double pixel_rad) const;

  /// Whether a ball may keep light off somewhere in the box.
  bool ball_may_shade(const Eigen::AlignedBox3f& box) const;

  /// The same of many points; only of those whose light is mapped: `shaded` tells which they are.
  /// `beside_ball`: whether a ball may keep light off any of them.
  void shade_surfaces(const SurfaceHits& hits, const Eigen::Vector3d& origin, const Triples& directions,
                      double pixel_rad, bool beside_ball, Triples& colors, Ints& shaded) const;

  /// What the ball sends towards the viewer from the point that the ray meets, or where it misses the point
  /// of the ball nearest to the ray.
  Rgb shade_ball(int ball, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

  /// What a point of the room (own_solid -1) or of a solid gets of a lamp, as a share of its intensity.
  double lamp_share(const Light& lamp, const Eigen::Vector3d& p, const Eigen::Vector3d& normal,
                    int own_solid) const;

 private:
  SurfacePoints points_of(int surface, const Floats& t, const Eigen::Vector3d& origin,
                          const Triples& directions) const;
  /// Whether the light map knows all the light on a surface, but for the balls' shadows.
  bool light_is_mapped(int surface) const;
  /// What is said of `points_on_it` alone.
  Triples shade_mapped(int surface, const Ints& points_on_it, const Floats& t, const Eigen::Vector3d& origin,
                       const Triples& directions, const Triples& p, double pixel_rad, bool beside_ball) const;
  /// The light of the lamps that balls keep off points of a surface.
  Triples lamp_light_kept_off(int surface, const Ints& points_on_it, const Triples& p,
                              const Triples& normal) const;
  Floats openness_beside_balls(const Triples& p, const Triples& normal) const;
  /// What of a lamp's light comes to a point of a surface.
  struct LampLight {
    Eigen::Vector3d to_light;
    double facing;                   // the cosine
    double past_solids, past_balls;  // the shares of the lamp that they do not hide
    double square_m2;                // of the distance
  };
  std::optional<LampLight> lamp_light(const Light& light, const Eigen::Vector3d& p,
                                      const Eigen::Vector3d& normal, int own_ball, int own_solid) const;
  Rgb reflected(const Material& material, const Rgb& albedo, const Eigen::Vector3d& p,
                const Eigen::Vector3d& normal, const Eigen::Vector3d& to_viewer, const Rgb& ambient,
                int own_ball, int own_solid) const;
  /// At points that own_ball, if any, does not hide the lamp from.
  Floats share_past_balls(const Light& light, const Triples& p, int own_ball) const;
  double share_past_solids(const Light& light, const Eigen::Vector3d& p, const Eigen::Vector3d& to_light,
                           double distance, int own_solid) const;

  /// Where a ball may keep a lamp's light off: behind `from_m` along the axis from the lamp, within a radius
  /// that grows from the ball on.
  struct ShadeCone {
    Eigen::Vector3f lamp, axis;
    float ball_m, from_m, radius, growth;
  };

  Room room_;
  std::vector<SceneBall> balls_;
  std::vector<ShadeCone> shade_cones_;
  std::vector<SceneSolid> solids_;
  std::vector<Light> lights_;  // as bright as they are now
  Rgb ambient_;
  const LightMap* light_map_;
  std::vector<Rgb> course_gains_;  // of the light map, now
};

}  // namespace ballservo
