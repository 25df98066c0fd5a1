#include "app/comparison/pictures/rendered_frame.hpp"

#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "app/comparison/pictures/painters.hpp"

namespace ballservo {
namespace {

// A pixel of the border, and a ball whose centre lies near it.
Eigen::Vector3d border_place(const ComparisonCondition& condition, double depth_m, RandomEngine& engine) {
  const Camera& camera = condition.camera;
  const double radius_px = condition.radius_m() / depth_m * camera.focal_px();
  const double beyond_px = uniform(engine, -0.1, 0.1) * radius_px;
  const double width = camera.size().width_px, height = camera.size().height_px;
  const double u = uniform(engine, 0.15, 0.85) * width, v = uniform(engine, 0.15, 0.85) * height;
  const std::array<Eigen::Vector2d, 4> places{
      Eigen::Vector2d(-beyond_px, v), Eigen::Vector2d(width - 1 + beyond_px, v),
      Eigen::Vector2d(u, -beyond_px), Eigen::Vector2d(u, height - 1 + beyond_px)};
  const auto ray = camera.unproject(places[uniform_index(engine, 4)]);
  if (!ray) throw std::logic_error("a pixel of the border has a ray");
  return *ray * (depth_m / ray->z());
}

// The first setting that the condition's painter would not show; empty if it shows them all.
std::string not_shown(const ComparisonCondition& c) {
  const bool lab = c.painter == Painter::lab, painted = c.painter == Painter::painted;
  const PaintedLook& look = c.look;
  const std::vector<std::pair<bool, const char*>> settings{
      {lab && !c.has_ball, "no_ball"},
      {lab && c.at_border, "at_border"},
      {!painted && (look.half_shade || look.highlight || look.marbled || look.contact_shadow), "a look"},
      {painted && c.touching, "touching"},
      {painted && (c.sensor.shot_noise > 0 || c.sensor.gain != 1), "noise.shot and gain"},
      {!lab && c.ball_color != "red" && c.ball_color != "green" && c.ball_color != "blue",
       "the ball's color"},
      {!lab && c.ball_pattern != Pattern::plain, "the ball's pattern"},
      {!lab && c.background == ComparisonBackground::plain, "background: plain"},
      {!lab && c.occlusion_side != OcclusionSide::any, "occlusion_side"},
      {!lab && c.contrast != 1, "contrast"},
      {!lab && c.ring_clutter > 0, "ring_clutter"},
      {!lab && (c.light_level != 1 || c.light_angle_rad), "light"},
      {!lab && c.motion_blur_px > 0, "motion_blur_px"}};
  for (const auto& [is_set, name] : settings) {
    if (is_set) return name;
  }
  return "";
}

// The whole outline lies at least `margin_px` inside the picture.
bool inside_picture(const ComparisonCondition& condition, const Eigen::Vector3d& p_CB, double margin_px) {
  const auto outline = project_outline(condition.camera, p_CB, condition.radius_m(), 64);
  return is_inside_picture(outline, condition.camera.size(), margin_px + 0.5);
}

}  // namespace

Eigen::Vector3d draw_ball_place(const ComparisonCondition& condition, RandomEngine& engine) {
  constexpr double margin_px = 12, near_middle = 0.2;
  const double depth_m = condition.depth_m * uniform(engine, 1 - depth_jitter, 1 + depth_jitter);
  if (condition.at_border) return border_place(condition, depth_m, engine);
  for (int attempt = 0; attempt < 1000; ++attempt) {
    const double azimuth = uniform(engine, 0, 2 * M_PI);
    const double lateral = condition.off_axis_rad > 0
                               ? std::tan(condition.off_axis_rad) + uniform(engine, -0.004, 0.004)
                               : near_middle * std::sqrt(uniform01(engine));
    const Eigen::Vector3d p_CB(depth_m * lateral * std::cos(azimuth), depth_m * lateral * std::sin(azimuth),
                               depth_m);
    if (inside_picture(condition, p_CB, margin_px)) return p_CB;
  }
  return {0, 0, depth_m};  // a ball so large that it is whole in the middle only
}

int own_channel(const std::string& ball_color) {
  return ball_color == "red" ? 0 : ball_color == "green" ? 1 : 2;
}

Eigen::Isometry3d level_camera(const Eigen::Vector3d& p_WC) {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  X_WC.translation() = p_WC;
  return X_WC;
}

double hiding_edge_distance(double hidden_fraction) {
  // The area of a circular segment is (acos d - d sqrt(1 - d^2)) / pi of the disc's.
  double low = -1, high = 1;
  for (int k = 0; k < 60; ++k) {
    const double d = (low + high) / 2;
    const double area = (std::acos(d) - d * std::sqrt(1 - d * d)) / M_PI;
    (area > hidden_fraction ? low : high) = d;
  }
  return (low + high) / 2;
}

Ball& Stage::put_ball(const Rgb& color) {
  Ball& ball = world.balls.emplace_back();
  ball.name = ball.class_name = condition.ball_color;
  ball.diameter_m = condition.diameter_m;
  ball.material.texture.color = color;
  ball.position_m = X_WC * p_CB;
  return ball;
}

void Stage::put(const Shape& shape, const Eigen::Vector3d& p_C, double yaw_rad, const Texture& texture) {
  Obstacle& obstacle = world.obstacles.emplace_back();
  obstacle.shape = shape;
  obstacle.center_m = X_WC * p_C;
  obstacle.yaw_rad = yaw_rad;
  obstacle.material.texture = texture;
}

RenderedFrame Stage::picture(const std::vector<CameraView>& views, RandomEngine& engine,
                             std::uint64_t noise_frame) const {
  const CameraView view{X_WC, 0};
  SensorOptions sensor = condition.sensor;
  RenderedFrame frame;
  if (!world.balls.empty()) frame.truth = ball_truth(condition.camera, world, view).front();
  const bool has_bound = frame.truth.outline && views.size() == 1 && sensor.gamma == 1;
  if (has_bound && condition.occlusion > 0) {
    // Twice as far from the centre as the outline goes: enough of what hides the ball for the bound.
    const OutlineEllipse& ball = *frame.truth.outline;
    const cv::Rect box = square_around(ball.center_px, static_cast<int>(2 * ball.radius_px) + 20);
    frame.unhidden = unhidden_pixels(condition.camera, world, view, 0, box);
  }
  const cv::Mat light = CameraRenderer(condition.camera, world, sensor).radiance(views);
  frame.bgr = expose(light, sensor, engine(), noise_frame);
  if (!has_bound) return frame;
  sensor.read_noise = sensor.shot_noise = 0;
  frame.clean_bgr = expose(light, sensor, 0, 0);
  return frame;
}

Eigen::Vector3d place_off_axis(const ComparisonCondition& condition, double azimuth_rad) {
  const double lateral = condition.depth_m * std::tan(condition.off_axis_rad);
  return {lateral * std::cos(azimuth_rad), lateral * std::sin(azimuth_rad), condition.depth_m};
}

std::vector<double> usable_azimuths(const ComparisonCondition& condition) {
  constexpr int directions = 72;
  constexpr double margin_px = 10;  // the ring around the outline must lie in the picture too
  std::vector<double> usable;
  for (int k = 0; k < directions; ++k) {
    const double azimuth = 2 * M_PI * k / directions;
    if (inside_picture(condition, place_off_axis(condition, azimuth), margin_px + 3))
      usable.push_back(azimuth);
  }
  return usable;
}

std::string why_not_rendered(const ComparisonCondition& condition) {
  if (const std::string name = not_shown(condition); !name.empty())
    return name + ", which pictures of this type do not show";
  if (!(condition.depth_m * (1 - depth_jitter) > 1.05 * condition.radius_m()))
    return "a camera inside the ball or touching it";
  if (!condition.at_border && usable_azimuths(condition).empty())
    return "a ball that is partly or wholly outside the picture";
  return "";
}

RenderedFrame render_comparison_frame(const ComparisonCondition& condition, std::uint64_t seed, int frame) {
  const bool lab = condition.painter == Painter::lab;
  RandomEngine engine = random_stream(seed, (lab ? "comparison/" : "accuracy/") + condition.name,
                                      static_cast<std::uint64_t>(frame));
  if (lab) return lab_frame(condition, engine, frame);
  return condition.painter == Painter::room ? room_frame(condition, engine)
                                            : painted_frame(condition, engine);
}

}  // namespace ballservo
