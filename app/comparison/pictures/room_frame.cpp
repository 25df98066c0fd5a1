#include <algorithm>
#include <cmath>

#include "app/comparison/pictures/painters.hpp"

namespace ballservo {
namespace {

// Where things stand is drawn in the picture and in depth.
struct RoomStage : Stage {
  explicit RoomStage(const ComparisonCondition& wanted)
      : Stage{wanted}, channels(own_channel(wanted.ball_color)) {
    ball_color[channels.own] = 0.8;
    ball_color[channels.other_1] = 0.08;
  }

  const Camera& camera = condition.camera;
  BallChannels channels;
  Rgb ball_color{0.05, 0.05, 0.05};
  std::optional<OutlineEllipse> ball;

  Eigen::Vector3d point(const Eigen::Vector2d& pixel_px, double depth_m) const {
    const Eigen::Vector3d ray = *camera.unproject(pixel_px);
    return ray * (depth_m / ray.z());
  }
};

// Any colour but the ball's.
Rgb muted_rgb(const BallChannels& channels, RandomEngine& engine) {
  Rgb color(uniform(engine, 0.1, 0.7), uniform(engine, 0.1, 0.7), uniform(engine, 0.1, 0.7));
  double& own = color[channels.own];
  own = std::min(own, 1.4 * std::max(color[channels.other_1], color[channels.other_2]));
  return color;
}

Texture muted_texture(const BallChannels& channels, RandomEngine& engine) {
  return random_texture([&] { return muted_rgb(channels, engine); }, 0.03, engine);
}

Texture near_texture(const RoomStage& stage, RandomEngine& engine) {
  Texture texture;
  texture.color = stage.ball_color * uniform(engine, 0.6, 1.1);
  texture.color[stage.channels.other_1] *= uniform(engine, 0.7, 1.8);
  texture.color[stage.channels.other_2] *= uniform(engine, 0.7, 1.8);
  if (uniform01(engine) < 0.4) {  // a ramp of near colours
    texture.pattern = Pattern::noise;
    texture.color_2 = texture.color * uniform(engine, 0.3, 0.8);
    texture.scale_m = uniform(engine, 0.05, 0.3);
  }
  return texture;
}

Shape random_solid(double size_m, RandomEngine& engine) {
  const double width = size_m * uniform(engine, 0.5, 1.5), height = size_m * uniform(engine, 0.5, 1.5);
  if (uniform01(engine) < 0.3) return CylinderShape{width / 2, height};
  return BoxShape{{0.5 * size_m, width, height}};
}

Eigen::Vector2d random_pixel(const RoomStage& stage, RandomEngine& engine) {
  return {uniform(engine, 0, stage.camera.size().width_px - 1.0),
          uniform(engine, 0, stage.camera.size().height_px - 1.0)};
}

void add_room_clutter(RoomStage& stage, RandomEngine& engine) {
  const double z = stage.p_CB.z();
  for (int k = 0; k < 40; ++k) {
    const double size_px = uniform(engine, 20, 120), depth_m = z * uniform(engine, 1.3, 2.2);
    const double size_m = size_px * depth_m / stage.camera.focal_px();
    stage.put(random_solid(size_m, engine), stage.point(random_pixel(stage, engine), depth_m + 0.3 * size_m),
              uniform(engine, 0, M_PI), muted_texture(stage.channels, engine));
  }
}

// Things of the ball's colour that do not touch the ball in the picture.
void add_distractors(RoomStage& stage, RandomEngine& engine) {
  const double z = stage.p_CB.z();
  for (int k = 0, attempts = 0; k < static_cast<int>(stage.condition.same_color) && attempts < 100;
       ++attempts) {
    const double size_px = uniform(engine, 15, 80), depth_m = z * uniform(engine, 1.15, 1.4);
    const Eigen::Vector2d pixel = random_pixel(stage, engine);
    const double clear_px = stage.ball ? 1.15 * stage.ball->radius_px + 1.3 * size_px : 0;
    if (stage.ball && (pixel - stage.ball->center_px).norm() < clear_px) continue;
    const double size_m = size_px * depth_m / stage.camera.focal_px();
    stage.put(random_solid(size_m, engine), stage.point(pixel, depth_m + 0.3 * size_m),
              uniform(engine, 0, M_PI), near_texture(stage, engine));
    ++k;
  }
}

// A disc of a ball's colour that no ball can look like: turned away by more than 35 degrees, or a box hides
// more than half of it.
void add_false_disc(RoomStage& stage, RandomEngine& engine) {
  const double radius_px = uniform(engine, 8, 70), depth_m = uniform(engine, 0.9, 1.2);
  const double radius_m = radius_px * depth_m / stage.camera.focal_px();
  const Eigen::Vector2d pixel = random_pixel(stage, engine);
  const Eigen::Vector3d center_C = stage.point(pixel, depth_m);
  const Eigen::Vector3d away = stage.X_WC * center_C - stage.X_WC.translation();
  const double facing_rad = std::atan2(away.y(), away.x());
  const bool cut = uniform01(engine) < 0.6;
  const double turned_rad = cut ? uniform(engine, 0, 0.4) : uniform(engine, 0.61, 1.2);
  stage.put(DiscShape{radius_m}, center_C, facing_rad + (uniform01(engine) < 0.5 ? -turned_rad : turned_rad),
            near_texture(stage, engine));
  if (!cut) return;
  const double edge = hiding_edge_distance(uniform(engine, 0.55, 0.8));
  const bool upright = uniform01(engine) < 0.5;
  const double side = uniform01(engine) < 0.5 ? -1 : 1, size_px = 2.4 * radius_px;
  const double shift_px = side * (edge * radius_px + 0.5 * size_px);
  const double card_depth_m = depth_m - 1.1 * radius_m;
  const double size_m = size_px * card_depth_m / stage.camera.focal_px();
  stage.put(BoxShape{{0.001, size_m, size_m}},
            stage.point(pixel + (upright ? Eigen::Vector2d(shift_px, 0) : Eigen::Vector2d(0, shift_px)),
                        card_depth_m),
            0, muted_texture(stage.channels, engine));
}

// A card before the ball from one of four sides, or a post across it. Gives the side (picture axes).
Eigen::Vector2d add_occluder(RoomStage& stage, RandomEngine& engine) {
  const double z = stage.p_CB.z(), depth_m = z - stage.condition.radius_m() * uniform(engine, 2, 6);
  const OutlineEllipse& ball = *stage.ball;
  const double m_per_px = depth_m / stage.camera.focal_px();
  if (uniform01(engine) < 0.2) {
    double low = 0, high = 1;  // half width of the strip that hides the fraction, in radii
    for (int k = 0; k < 60; ++k) {
      const double w = (low + high) / 2;
      (2 / M_PI * (std::asin(w) + w * std::sqrt(1 - w * w)) < stage.condition.occlusion ? low : high) = w;
    }
    stage.put(BoxShape{{0.001, 2 * low * ball.radius_px * m_per_px, 8 * ball.radius_px * m_per_px}},
              stage.point(ball.center_px, depth_m), 0, muted_texture(stage.channels, engine));
    return {0, 0};
  }
  const Eigen::Vector2d side = picture_sides[uniform_index(engine, 4)];
  const double size_px = 4 * ball.radius_px;
  const double shift_px = hiding_edge_distance(stage.condition.occlusion) * ball.radius_px + 0.5 * size_px;
  stage.put(BoxShape{{0.001, size_px * m_per_px, size_px * m_per_px}},
            stage.point(ball.center_px + shift_px * side, depth_m), 0, muted_texture(stage.channels, engine));
  return side;
}

void add_touching_bar(RoomStage& stage, RandomEngine& engine) {
  const OutlineEllipse& ball = *stage.ball;
  const double depth_m = stage.p_CB.z() + stage.condition.radius_m();
  const double m_per_px = depth_m / stage.camera.focal_px();
  const double width_px = uniform(engine, 0.4, 1.2) * ball.radius_px;
  const double length_px = uniform(engine, 3, 6) * ball.radius_px;
  const double shift_px = uniform(engine, 0.88, 0.98) * ball.radius_px + width_px / 2;
  const double along_px = uniform(engine, -0.3, 0.3) * length_px;
  const bool upright = uniform01(engine) < 0.5;
  const double side = uniform01(engine) < 0.5 ? -1 : 1;
  Texture texture;
  texture.color = stage.ball_color * uniform(engine, 0.85, 1.1);
  const Eigen::Vector2d center_px = ball.center_px + (upright ? Eigen::Vector2d(side * shift_px, along_px)
                                                              : Eigen::Vector2d(along_px, side * shift_px));
  stage.put(BoxShape{{0.002, (upright ? width_px : length_px) * m_per_px,
                      (upright ? length_px : width_px) * m_per_px}},
            stage.point(center_px, depth_m), 0, texture);
}

// A lamp from any side, up to 100 degrees from the camera's, not from that of an occluder, whose shadow on
// the ball would be another condition.
void add_lamp(RoomStage& stage, const Eigen::Vector2d& occluder_side, RandomEngine& engine) {
  const double from_camera_rad = uniform(engine, 0, 100 * M_PI / 180), azimuth = uniform(engine, 0, 2 * M_PI);
  Eigen::Vector3d to_lamp(std::sin(from_camera_rad) * std::cos(azimuth),
                          std::sin(from_camera_rad) * std::sin(azimuth), -std::cos(from_camera_rad));
  if (to_lamp.head<2>().dot(occluder_side) > 0) to_lamp.head<2>() *= -1;
  const double distance_m = uniform(engine, 1.0, 2.0);
  Light lamp;
  lamp.position_m = stage.X_WC * Eigen::Vector3d(stage.p_CB + distance_m * to_lamp);
  lamp.intensity = Rgb::Constant(uniform(engine, 0.45, 0.7) * distance_m * distance_m);
  lamp.radius_m = uniform(engine, 0.02, 0.15);
  stage.world.lights.push_back(lamp);
  stage.world.ambient = Rgb::Constant(uniform(engine, 0.35, 0.5));
}

}  // namespace

RenderedFrame room_frame(const ComparisonCondition& condition, RandomEngine& engine) {
  RoomStage stage(condition);
  stage.p_CB = draw_ball_place(condition, engine);
  const double z = stage.p_CB.z(), reach_m = 2.5 + 1.5 * z;
  stage.X_WC = level_camera({0, 0, reach_m});
  stage.world.room = {-2.5, 2.5 * z + 2, -reach_m, reach_m, 2 * reach_m, {}, {}, {}};
  stage.world.room.wall.texture = muted_texture(stage.channels, engine);
  stage.world.room.floor.texture = muted_texture(stage.channels, engine);

  Eigen::Vector2d occluder_side(0, 0);
  if (condition.has_ball) {
    stage.ball = project_sphere(stage.camera, stage.p_CB, condition.radius_m());
    Ball& ball = stage.put_ball(stage.ball_color);
    ball.material.specular = uniform01(engine) < 0.5 ? uniform(engine, 0, 0.3) : 0;
    ball.material.shininess = uniform(engine, 20, 120);
    if (condition.occlusion > 0) occluder_side = add_occluder(stage, engine);
    if (condition.touching) add_touching_bar(stage, engine);
  } else {
    for (int k = 0; k < 4; ++k) add_false_disc(stage, engine);
  }
  add_room_clutter(stage, engine);
  add_distractors(stage, engine);
  add_lamp(stage, occluder_side, engine);

  return stage.picture({{stage.X_WC, 0}}, engine, 0);
}

}  // namespace ballservo
