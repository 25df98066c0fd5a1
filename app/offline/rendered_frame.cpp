#include "app/offline/rendered_frame.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "calibration/files/random.hpp"
#include "servo/simulation/camera_renderer.hpp"

namespace ballservo {
namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double margin_px = 10;  // the ring around the outline must lie in the picture too
constexpr double jitter_px = 1.5, jitter_depth = 0.02;

// The camera looks along the world's x axis, upright.
Eigen::Isometry3d level_camera(const Eigen::Vector3d& p_WC) {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  X_WC.translation() = p_WC;
  return X_WC;
}

Eigen::Vector3d ball_place(const ComparisonCondition& condition, double azimuth_rad) {
  const double lateral = condition.depth_m * std::tan(condition.off_axis_rad);
  return {lateral * std::cos(azimuth_rad), lateral * std::sin(azimuth_rad), condition.depth_m};
}

bool inside_picture(const ComparisonCondition& condition, const Eigen::Vector3d& p_CB, double margin) {
  const auto outline = project_outline(condition.camera, p_CB, condition.radius_m(), 64);
  const ImageSize size = condition.camera.size();
  return !outline.empty() && std::all_of(outline.begin(), outline.end(), [&](const Eigen::Vector2d& p) {
    return p.x() >= margin && p.y() >= margin && p.x() <= size.width_px - 1 - margin &&
           p.y() <= size.height_px - 1 - margin;
  });
}

// Evenly spread directions off the axis in which the whole ball is in the picture.
std::vector<double> usable_azimuths(const ComparisonCondition& condition) {
  constexpr int directions = 72;
  std::vector<double> usable;
  for (int k = 0; k < directions; ++k) {
    const double azimuth = 2 * pi * k / directions;
    if (inside_picture(condition, ball_place(condition, azimuth), margin_px + 3)) usable.push_back(azimuth);
  }
  return usable;
}

// How far from a disc's centre (in radii) a straight edge runs that hides the given fraction of it: the area
// of a circular segment, (acos d - d sqrt(1 - d^2)) / pi.
double edge_distance(double hidden_fraction) {
  double low = -1, high = 1;
  for (int k = 0; k < 60; ++k) {
    const double d = (low + high) / 2;
    const double area = (std::acos(d) - d * std::sqrt(1 - d * d)) / pi;
    (area > hidden_fraction ? low : high) = d;
  }
  return (low + high) / 2;
}

Rgb muted(const Rgb& color, double grey, double share) {
  return share * color + (1 - share) * Rgb::Constant(grey);
}

// A colour for the background: any hue but the ball's own, half grey.
Rgb background_color(const std::string& ball_color, RandomEngine& engine) {
  constexpr std::array<const char*, 8> words{"grey", "white", "black",  "cyan",
                                             "blue", "green", "yellow", "purple"};
  std::string word;
  do {
    word = words[uniform_index(engine, static_cast<std::uint32_t>(words.size()))];
  } while (word == ball_color);
  return muted(*color_from_word(word), uniform(engine, 0.1, 0.6), 0.4);
}

Texture background_texture(const std::string& ball_color, RandomEngine& engine) {
  Texture texture;
  texture.pattern = all_patterns[uniform_index(engine, static_cast<std::uint32_t>(all_patterns.size()))];
  texture.color = background_color(ball_color, engine);
  texture.color_2 = 0.6 * texture.color + 0.4 * background_color(ball_color, engine);
  texture.scale_m = uniform(engine, 0.05, 0.4);
  return texture;
}

Obstacle box(const Eigen::Vector3d& center, const Eigen::Vector3d& size, double yaw_rad,
             const Texture& texture) {
  Obstacle obstacle;
  obstacle.shape = BoxShape{size};
  obstacle.center_m = center;
  obstacle.yaw_rad = yaw_rad;
  obstacle.material.texture = texture;
  return obstacle;
}

// Which side of the ball an occluder hides (picture axes). Not the upper one: the lamp hangs there, and a
// shadow with an edge of its own is another condition than a hidden part.
Eigen::Vector2d occluder_side(RandomEngine& engine) {
  constexpr std::array<std::array<int, 2>, 3> sides{{{-1, 0}, {1, 0}, {0, 1}}};
  const auto& side = sides[uniform_index(engine, 3)];
  return {side[0], side[1]};
}

// A card close before the ball whose straight edge hides the wanted part of it.
Obstacle occluder(const ComparisonCondition& condition, const Eigen::Isometry3d& X_WC,
                  const Eigen::Vector3d& p_CB, const Eigen::Vector2d& side, RandomEngine& engine) {
  const auto outline = project_sphere(condition.camera, p_CB, condition.radius_m());
  if (!outline) throw std::logic_error("a ball that is in the picture has an outline");
  const double card_depth = std::max(0.7 * p_CB.z(), p_CB.z() - 4 * condition.radius_m());
  const Eigen::Vector2d edge_px =
      outline->center_px + outline->radius_px * edge_distance(condition.occlusion) * side;
  const auto ray = condition.camera.unproject(edge_px);
  if (!ray) throw std::logic_error("a pixel of the ball has a ray");
  const double size_m = 5 * condition.radius_m();
  Eigen::Vector3d center_C = *ray * (card_depth / ray->z());
  center_C.head<2>() += 0.5 * size_m * side;
  Texture texture = background_texture(condition.ball_color, engine);
  texture.color = muted(texture.color, 0.35, 0.3);
  texture.color_2 = muted(texture.color_2, 0.3, 0.3);
  return box(X_WC * center_C, {0.001, size_m, size_m}, 0, texture);
}

// Boxes behind the ball.
void add_clutter(const ComparisonCondition& condition, const Eigen::Isometry3d& X_WC,
                 const Eigen::Vector3d& p_CB, RandomEngine& engine, World& world) {
  constexpr int count = 14;
  for (int k = 0; k < count; ++k) {
    const double size = p_CB.z() * uniform(engine, 0.05, 0.25);
    const Eigen::Vector3d center_C{p_CB.x() + p_CB.z() * uniform(engine, -0.7, 0.7),
                                   p_CB.y() + p_CB.z() * uniform(engine, -0.5, 0.5),
                                   p_CB.z() * uniform(engine, 1.5, 1.9)};
    const double width = size * uniform(engine, 0.4, 1.6), height = size * uniform(engine, 0.4, 1.6);
    const double yaw_rad = uniform(engine, -0.6, 0.6);
    world.obstacles.push_back(box(X_WC * center_C, {0.3 * size, width, height}, yaw_rad,
                                  background_texture(condition.ball_color, engine)));
  }
}

}  // namespace

std::string why_not_rendered(const ComparisonCondition& condition) {
  if (!(condition.depth_m * (1 - jitter_depth) > 1.05 * condition.radius_m())) {
    return "a camera inside the ball or touching it";
  }
  if (usable_azimuths(condition).empty()) return "a ball that is partly or wholly outside the picture";
  return "";
}

RenderedFrame render_comparison_frame(const ComparisonCondition& condition, std::uint64_t seed, int frame) {
  RandomEngine engine =
      random_stream(seed, "comparison/" + condition.name, static_cast<std::uint64_t>(frame));
  const std::vector<double> azimuths = usable_azimuths(condition);
  if (azimuths.empty()) throw std::invalid_argument("the condition cannot be rendered: " + condition.name);
  const double azimuth = azimuths[uniform_index(engine, static_cast<std::uint32_t>(azimuths.size()))];
  Eigen::Vector3d p_CB = ball_place(condition, azimuth);
  p_CB *= uniform(engine, 1 - jitter_depth, 1 + jitter_depth);
  const double m_per_px = p_CB.z() / condition.camera.focal_px();
  p_CB.x() += uniform(engine, -jitter_px, jitter_px) * m_per_px;
  p_CB.y() += uniform(engine, -jitter_px, jitter_px) * m_per_px;

  const double lateral = std::max(2.0, 3 * p_CB.head<2>().norm());
  const double height = 4 + 2 * lateral;
  const Eigen::Isometry3d X_WC = level_camera(
      {0, uniform(engine, -0.5, 0.5) * lateral, height / 2 + uniform(engine, -0.4, 0.4) * lateral});
  World world;
  world.room = {-1 - p_CB.z(), 2 * p_CB.z() + 1.5, -2 * lateral - 2, 2 * lateral + 2, height, {}, {}, {}};
  world.room.wall.texture = background_texture(condition.ball_color, engine);
  world.room.floor.texture = background_texture(condition.ball_color, engine);

  Ball ball;
  ball.name = ball.class_name = condition.ball_color;
  ball.diameter_m = condition.diameter_m;
  ball.material.texture.color = *color_from_word(condition.ball_color);
  ball.material.specular = 0.15;
  ball.position_m = X_WC * p_CB;
  world.balls.push_back(ball);

  if (condition.background == ComparisonBackground::plain) {
    world.room.wall.texture.pattern = world.room.floor.texture.pattern = Pattern::plain;
  } else {
    add_clutter(condition, X_WC, p_CB, engine, world);
  }

  // A lamp from the camera's side, above, as bright at the ball wherever it hangs.
  Eigen::Vector3d to_lamp_C(uniform(engine, -0.7, 0.7), uniform(engine, -0.9, -0.4),
                            uniform(engine, -0.9, -0.4));
  if (condition.occlusion > 0) {
    const Eigen::Vector2d side = occluder_side(engine);
    world.obstacles.push_back(occluder(condition, X_WC, p_CB, side, engine));
    if (side.x() != 0) to_lamp_C.x() = -side.x() * std::abs(to_lamp_C.x());
  }
  Light lamp;
  lamp.position_m = ball.position_m + X_WC.linear() * to_lamp_C;
  lamp.intensity = Rgb::Constant(uniform(engine, 0.5, 0.7) * to_lamp_C.squaredNorm());
  world.lights.push_back(lamp);
  world.ambient = Rgb::Constant(uniform(engine, 0.55, 0.7));

  const CameraView view{X_WC, 0};
  RenderedFrame rendered;
  rendered.truth = ball_truth(condition.camera, world, view).front();
  const CameraRenderer renderer(condition.camera, std::move(world), condition.sensor);
  rendered.bgr = renderer.render({view}, engine(), static_cast<std::uint64_t>(frame));
  return rendered;
}

}  // namespace ballservo
