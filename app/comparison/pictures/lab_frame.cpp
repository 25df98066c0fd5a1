#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "app/comparison/pictures/painters.hpp"

namespace ballservo {
namespace {

constexpr double jitter_px = 1.5;

Rgb muted(const Rgb& color, double grey, double share) {
  return share * color + (1 - share) * Rgb::Constant(grey);
}

// A colour for the background: any hue but the ball's own, half grey; the nearer to the ball's the less
// contrast is wanted.
Rgb background_color(const ComparisonCondition& condition, RandomEngine& engine) {
  const std::string& ball_color = condition.ball_color;
  constexpr std::array<const char*, 8> words{"grey", "white", "black",  "cyan",
                                             "blue", "green", "yellow", "purple"};
  std::string word;
  do {
    word = words[uniform_index(engine, static_cast<std::uint32_t>(words.size()))];
  } while (word == ball_color);
  const Rgb color = muted(*color_from_word(word), uniform(engine, 0.1, 0.6), 0.4);
  return condition.contrast * color + (1 - condition.contrast) * *color_from_word(ball_color);
}

Texture background_texture(const ComparisonCondition& condition, RandomEngine& engine) {
  return random_texture([&] { return background_color(condition, engine); }, 0.05, engine);
}

// Which side of the ball an occluder hides (picture axes). By chance not the upper one: the lamp hangs there,
// and a shadow with an edge of its own is another condition than a hidden part.
Eigen::Vector2d occluder_side(OcclusionSide wanted, RandomEngine& engine) {
  const std::size_t drawn = uniform_index(engine, 3);
  return picture_sides[wanted == OcclusionSide::any ? drawn : static_cast<std::size_t>(wanted) - 1];
}

// A card close before the ball whose straight edge hides the wanted part of it.
void add_card(Stage& stage, const Eigen::Vector2d& side, RandomEngine& engine) {
  const ComparisonCondition& condition = stage.condition;
  const Eigen::Vector3d& p_CB = stage.p_CB;
  const auto outline = project_sphere(condition.camera, p_CB, condition.radius_m());
  if (!outline) throw std::logic_error("a ball that is in the picture has an outline");
  const double card_depth = std::max(0.7 * p_CB.z(), p_CB.z() - 4 * condition.radius_m());
  const Eigen::Vector2d edge_px =
      outline->center_px + outline->radius_px * hiding_edge_distance(condition.occlusion) * side;
  const auto ray = condition.camera.unproject(edge_px);
  if (!ray) throw std::logic_error("a pixel of the ball has a ray");
  const double size_m = 5 * condition.radius_m();
  Eigen::Vector3d center_C = *ray * (card_depth / ray->z());
  center_C.head<2>() += 0.5 * size_m * side;
  Texture texture = background_texture(condition, engine);
  texture.color = muted(texture.color, 0.35, 0.3);
  texture.color_2 = muted(texture.color_2, 0.3, 0.3);
  stage.put(BoxShape{{0.001, size_m, size_m}}, center_C, 0, texture);
}

// Boxes behind the ball.
void add_lab_clutter(Stage& stage, RandomEngine& engine) {
  const ComparisonCondition& condition = stage.condition;
  const Eigen::Vector3d& p_CB = stage.p_CB;
  constexpr int count = 14;
  for (int k = 0; k < count; ++k) {
    const double size = p_CB.z() * uniform(engine, 0.05, 0.25);
    const Eigen::Vector3d center_C{p_CB.x() + p_CB.z() * uniform(engine, -0.7, 0.7),
                                   p_CB.y() + p_CB.z() * uniform(engine, -0.5, 0.5),
                                   p_CB.z() * uniform(engine, 1.5, 1.9)};
    const double width = size * uniform(engine, 0.4, 1.6), height = size * uniform(engine, 0.4, 1.6);
    const double yaw_rad = uniform(engine, -0.6, 0.6);
    stage.put(BoxShape{{0.3 * size, width, height}}, center_C, yaw_rad,
              background_texture(condition, engine));
  }
}

// Boxes right behind the ball whose outlines cross its own.
void add_ring_clutter(Stage& stage, RandomEngine& engine) {
  const ComparisonCondition& condition = stage.condition;
  const Eigen::Vector3d& p_CB = stage.p_CB;
  const double r = condition.radius_m(), behind = p_CB.z() + 1.3 * r;
  const double scale = behind / p_CB.z();
  for (int k = 0; k < static_cast<int>(condition.ring_clutter); ++k) {
    const Eigen::Vector2d place = p_CB.head<2>() * scale + r * scale * uniform(engine, 0.8, 1.15) *
                                                               unit_vector(uniform(engine, 0, 2 * M_PI));
    const Eigen::Vector3d size(0.002, uniform(engine, 0.3, 0.9) * r, uniform(engine, 0.3, 0.9) * r);
    const double depth = behind + 0.02 * r * k;  // one before the other, never in one place
    stage.put(BoxShape{size}, Eigen::Vector3d(place.x(), place.y(), depth), 0,
              background_texture(condition, engine));
  }
}

Texture nearly_ball_colored(const ComparisonCondition& condition, double low, double high,
                            RandomEngine& engine) {
  Texture texture;
  texture.color = *color_from_word(condition.ball_color) * uniform(engine, low, high);
  return texture;
}

// Boxes of nearly the ball's colour, clear of it in the picture, and a bar of it that touches it.
void add_same_color(Stage& stage, RandomEngine& engine) {
  const ComparisonCondition& condition = stage.condition;
  const Eigen::Vector3d& p_CB = stage.p_CB;
  const double z = p_CB.z(), r = condition.radius_m();
  for (int k = 0; k < static_cast<int>(condition.same_color); ++k) {
    const double side = r * uniform(engine, 0.7, 2), depth = z * uniform(engine, 1.15, 1.4);
    const double apart = uniform(engine, 1.2 * r + 1.5 * side, 6 * r + 3 * side);
    const Eigen::Vector2d place = p_CB.head<2>() + apart * unit_vector(uniform(engine, 0, 2 * M_PI));
    stage.put(BoxShape{{0.3 * side, side * uniform(engine, 0.5, 1.5), side * uniform(engine, 0.5, 1.5)}},
              depth / z * Eigen::Vector3d(place.x(), place.y(), z), uniform(engine, -0.6, 0.6),
              nearly_ball_colored(condition, 0.7, 1.1, engine));
  }
  if (!condition.touching) return;
  const double width = r * uniform(engine, 0.4, 1.2), length = r * uniform(engine, 3, 6);
  const double shift = uniform(engine, 0.88, 0.98) * r + width / 2;
  const double side = uniform01(engine) < 0.5 ? -1 : 1;
  const double scale = (z + r) / z;
  const Eigen::Vector3d center(p_CB.x() + side * shift, p_CB.y() + uniform(engine, -0.3, 0.3) * length, z);
  stage.put(BoxShape{{0.002, scale * width, scale * length}}, scale * center, 0,
            nearly_ball_colored(condition, 0.85, 1.1, engine));
}

// The camera's places while it is exposed: along a line in the picture's plane, the middle one at its own.
std::vector<CameraView> exposure_views(const Stage& stage, RandomEngine& engine) {
  const ComparisonCondition& condition = stage.condition;
  if (!(condition.motion_blur_px > 0)) return {{stage.X_WC, 0}};
  const Eigen::Vector2d way = unit_vector(uniform(engine, 0, 2 * M_PI)) * condition.motion_blur_px *
                              stage.p_CB.z() / condition.camera.focal_px();
  std::vector<CameraView> views;
  for (int k = 0; k < motion_views; ++k) {
    const double part = (k + 0.5) / motion_views - 0.5;
    CameraView view{stage.X_WC, 0};
    view.X_WC.translation() += stage.X_WC.linear() * Eigen::Vector3d(part * way.x(), part * way.y(), 0);
    views.push_back(view);
  }
  return views;
}

}  // namespace

RenderedFrame lab_frame(const ComparisonCondition& condition, RandomEngine& engine, int frame) {
  const std::vector<double> azimuths = usable_azimuths(condition);
  if (azimuths.empty()) throw std::invalid_argument("the condition cannot be rendered: " + condition.name);
  const double azimuth = azimuths[uniform_index(engine, static_cast<std::uint32_t>(azimuths.size()))];
  Eigen::Vector3d p_CB = place_off_axis(condition, azimuth);
  p_CB *= uniform(engine, 1 - depth_jitter, 1 + depth_jitter);
  const double m_per_px = p_CB.z() / condition.camera.focal_px();
  p_CB.x() += uniform(engine, -jitter_px, jitter_px) * m_per_px;
  p_CB.y() += uniform(engine, -jitter_px, jitter_px) * m_per_px;

  const double lateral = std::max(2.0, 3 * p_CB.head<2>().norm());
  const double height = 4 + 2 * lateral;
  Stage stage{condition, p_CB,
              level_camera({0, uniform(engine, -0.5, 0.5) * lateral,
                            height / 2 + uniform(engine, -0.4, 0.4) * lateral})};
  World& world = stage.world;
  world.room = {-1 - p_CB.z(), 2 * p_CB.z() + 1.5, -2 * lateral - 2, 2 * lateral + 2, height, {}, {}, {}};
  world.room.wall.texture = background_texture(condition, engine);
  world.room.floor.texture = background_texture(condition, engine);

  Ball& ball = stage.put_ball(*color_from_word(condition.ball_color));
  ball.material.texture.pattern = condition.ball_pattern;
  ball.material.texture.color_2 = 0.6 * ball.material.texture.color;
  ball.material.texture.scale_m = 0.4 * condition.diameter_m;
  ball.material.specular = 0.15;

  if (condition.background == ComparisonBackground::plain) {
    world.room.wall.texture.pattern = world.room.floor.texture.pattern = Pattern::plain;
  } else {
    add_lab_clutter(stage, engine);
  }

  // A lamp from the camera's side, above, as bright at the ball wherever it hangs.
  Eigen::Vector3d to_lamp_C(uniform(engine, -0.7, 0.7), uniform(engine, -0.9, -0.4),
                            uniform(engine, -0.9, -0.4));
  if (condition.light_angle_rad) {
    const Eigen::Vector2d across = to_lamp_C.head<2>().normalized() * std::sin(*condition.light_angle_rad);
    to_lamp_C = {across.x(), across.y(), -std::cos(*condition.light_angle_rad)};
  }
  if (condition.occlusion > 0) {
    const Eigen::Vector2d side = occluder_side(condition.occlusion_side, engine);
    add_card(stage, side, engine);
    if (side.x() != 0) to_lamp_C.x() = -side.x() * std::abs(to_lamp_C.x());
    if (side.y() != 0) to_lamp_C.y() = -side.y() * std::abs(to_lamp_C.y());
  }
  Light lamp;
  lamp.position_m = ball.position_m + stage.X_WC.linear() * to_lamp_C;
  lamp.intensity = Rgb::Constant(condition.light_level * uniform(engine, 0.5, 0.7) * to_lamp_C.squaredNorm());
  world.lights.push_back(lamp);
  world.ambient = Rgb::Constant(condition.light_level * uniform(engine, 0.55, 0.7));
  add_ring_clutter(stage, engine);
  add_same_color(stage, engine);

  const std::vector<CameraView> views = exposure_views(stage, engine);
  return stage.picture(views, engine, static_cast<std::uint64_t>(frame));
}

}  // namespace ballservo
