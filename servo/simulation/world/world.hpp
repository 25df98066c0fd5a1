// The simulated room and everything in it, as plain data: what scenarios fill, renderers and collision tests
// read, and reports draw from above.
//
// World frame W: z up, the floor at z = 0; metres.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "servo/motion/unicycle.hpp"
#include "servo/simulation/world/texture.hpp"

namespace ballservo {

/// How a surface answers light: Lambert, with a Blinn-Phong highlight (Blinn, SIGGRAPH 1977).
struct Material {
  Texture texture;
  double specular = 0;    ///< strength of the highlight, 0 to 1
  double shininess = 60;  ///< its exponent
  bool luminous = false;  ///< shows its colour as it is, in any light
};

/// Paint as balls have it: with a highlight.
Material painted_ball(const Rgb& color);

/// Balls move by themselves, whatever touches them.
struct StaticMotion {};
struct LinearMotion {
  Eigen::Vector2d velocity_mps{0, 0};
  double start_s = 0;       ///< rests before
  double duration_s = 1e9;  ///< and after so long
};
struct CircleMotion {
  Eigen::Vector2d center_m{0, 0};
  double rate_radps = 0;  ///< counter-clockwise seen from above
};
/// Where a ball is at which time: straight and steady from one point to the next, at rest at the first before
/// it and at the last after it.
struct WaypointMotion {
  struct Point {
    double time_s = 0;
    Eigen::Vector3d position_m{0, 0, 0};
  };
  std::vector<Point> points;  ///< one or more, times rising
};
/// Rolls straight from `start_s` on, slowed by friction, and is thrown back by the walls of a rectangle.
struct RollingMotion {
  Eigen::Vector2d velocity_mps{0, 0};  ///< at start_s
  double start_s = 0;                  ///< rests before
  double friction_mps2 = 0;            ///< deceleration along the way; it rests once it stands
  double restitution = 1;              ///< share of the speed towards a wall that a bounce gives back
  Eigen::Vector2d low_m{-1e9, -1e9}, high_m{1e9, 1e9};  ///< where its centre can be: the room less its radius

  /// Where a ball that lay at `start_m` is at a time. Exact from bounce to bounce; after 10000 bounces, or
  /// between walls that leave it no room, it rests.
  Eigen::Vector2d place(const Eigen::Vector2d& start_m, double time_s) const;
};
using Motion = std::variant<StaticMotion, LinearMotion, CircleMotion, WaypointMotion, RollingMotion>;

struct Ball {
  std::string name;
  std::string class_name;
  double diameter_m = 0;
  Material material;
  Eigen::Vector3d position_m{0, 0, 0};  ///< of the centre at time 0
  Motion motion;
  bool sonar = false;  ///< whether a sonar echoes from it

  double radius_m() const { return diameter_m / 2; }
  /// The centre at a time (m, world).
  Eigen::Vector3d p_WB(double time_s) const;
  /// The lowest and the highest that its centre ever comes (m).
  std::pair<double, double> heights_m() const;
};

/// A box that stands upright, turned by yaw.
struct BoxShape {
  Eigen::Vector3d size_m{0.3, 0.3, 0.3};
};
/// A cylinder that stands upright.
struct CylinderShape {
  double radius_m = 0.1, height_m = 0.3;
};
/// A thin round plate that stands upright, facing yaw.
struct DiscShape {
  double radius_m = 0.06;
};
using Shape = std::variant<BoxShape, CylinderShape, DiscShape>;

/// A thing that does not move: an obstacle, or something that only looks like a ball.
struct Obstacle {
  std::string name;
  Shape shape;
  Eigen::Vector3d center_m{0, 0, 0};
  double yaw_rad = 0;
  Material material;

  double bottom_m() const;
  double top_m() const;
  /// Radius of a circle around the centre that holds the outline, seen from above.
  double outline_radius_m() const;
  /// Radius of a sphere around the centre that holds the whole shape.
  double bounding_radius_m() const;
};

inline constexpr double min_temperature_k = 1667, max_temperature_k = 25000;

/// What a camera of sRGB's primaries sees of a black body of that temperature (K, from min_temperature_k to
/// max_temperature_k), linear and of luminance 1; a channel outside the gamut is 0. The chromaticity is the
/// cubic approximation of the Planckian locus by Kang, Moon, Hong, Lee, Cho and Kim, Journal of the Korean
/// Physical Society 41(6), 2002, pages 865-871; the primaries are those of IEC 61966-2-1.
Rgb planckian_rgb(double temperature_k);

/// A light at one moment.
struct LightKey {
  double time_s = 0;
  double temperature_k = 6500;
  double level = 1;  ///< factor on its intensity
  bool operator==(const LightKey& other) const {
    return time_s == other.time_s && temperature_k == other.temperature_k && level == other.level;
  }
};

/// How a light changes: linearly in temperature and level from one key to the next, at once where two keys
/// share a time; as the first key before it and as the last one after it.
struct LightCourse {
  double white_balance_k = 6500;  ///< the temperature that the camera shows as white
  std::vector<LightKey> keys;     ///< in order of time; none: the light never changes

  /// Factors on the light's intensity at a time: (1, 1, 1) at the white balance's temperature and level 1.
  Rgb gain(double time_s) const;
  bool operator==(const LightCourse& other) const {
    return white_balance_k == other.white_balance_k && keys == other.keys;
  }
};

/// A lamp: a sphere that shines alike in all directions. `intensity` is what a surface of reflectance 1 shows
/// at 1 m when it faces the lamp; it falls with the square of the distance. Its radius makes shadows soft.
struct Light {
  Eigen::Vector3d position_m{0, 0, 2.4};
  Rgb intensity{1, 1, 1};
  double radius_m = 0;
  LightCourse course{};
};

/// Light from everywhere that changes.
struct AmbientLight {
  Rgb intensity{0.3, 0.3, 0.3};
  LightCourse course{};
};

struct Room {
  double x_min_m = -2, x_max_m = 6.5, y_min_m = -3.5, y_max_m = 3.5, height_m = 2.6;
  Material floor, wall, ceiling;

  Eigen::Vector3d low_m() const { return {x_min_m, y_min_m, 0}; }
  Eigen::Vector3d high_m() const { return {x_max_m, y_max_m, height_m}; }
};

struct World {
  Room room;
  std::vector<Ball> balls;
  std::vector<Obstacle> obstacles;
  std::vector<Light> lights;
  Rgb ambient{0.3, 0.3, 0.3};                  ///< light from everywhere
  std::vector<AmbientLight> changing_ambient;  ///< and what of it changes, besides
};

/// Where a camera is at one instant of an exposure.
struct CameraView {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  double time_s = 0;
};

/// Whether all that moves or changes (balls, lights) is at one time as at the other.
bool looks_alike(const World& world, double time_s, double other_s);

/// The ball or obstacle of that name, or the end.
template <typename Things>
auto find_named(Things& things, const std::string& name) {
  return std::find_if(things.begin(), things.end(), [&](const auto& thing) { return thing.name == name; });
}

/// Where an obstacle stands, seen from above: the corners of its convex outline counter-clockwise (world, m);
/// a circle where `radius_m` > 0 (then the only point is its centre).
struct FloorOutline {
  std::vector<Eigen::Vector2d> points_m;
  double radius_m = 0;

  /// From a point of the floor; 0 inside.
  double distance_m(const Eigen::Vector2d& p) const;
};
FloorOutline floor_outline(const Obstacle& obstacle);

}  // namespace ballservo
