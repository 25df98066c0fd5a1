// The simulated room and everything in it, as plain data: what scenarios fill, renderers and collision tests
// read, and reports draw from above.
//
// World frame W: z up, the floor at z = 0; metres.
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "servo/simulation/world/light_course.hpp"
#include "servo/simulation/world/rolling_motion.hpp"
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
};

struct World {
  Room room;
  std::vector<Ball> balls;
  std::vector<Obstacle> obstacles;
  std::vector<Light> lights;
  Rgb ambient{0.3, 0.3, 0.3};                  ///< light from everywhere
  std::vector<AmbientLight> changing_ambient;  ///< and what of it changes, besides

  /// The ball of that name, or null.
  const Ball* find_ball(const std::string& name) const;
};

/// Where an obstacle stands, seen from above: the corners of its outline counter-clockwise (world, m); a
/// circle where `radius_m` > 0 (then the only point is its centre).
struct FloorOutline {
  std::vector<Eigen::Vector2d> points_m;
  double radius_m = 0;
};
FloorOutline floor_outline(const Obstacle& obstacle);

}  // namespace ballservo
