#include "tests/bench/bench_frames.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/base/random.hpp"
#include "servo/simulation/rendering/camera_renderer.hpp"

namespace ballservo::bench {
namespace {

World cluttered_room(RandomEngine& engine) {
  World world;
  world.room.floor.texture = {Pattern::wood, {0.45, 0.36, 0.28}, {0.38, 0.3, 0.23}, 0.12};
  world.room.wall.texture = {Pattern::noise, {0.6, 0.62, 0.6}, {0.5, 0.52, 0.52}, 0.2};
  Light light;
  light.position_m = {uniform(engine, -0.5, 0.8), uniform(engine, -1.5, 1.5), 2.4};
  light.intensity = Rgb::Constant(uniform(engine, 3, 5));
  world.lights.push_back(light);
  for (int i = 0; i < 12; ++i) {
    Obstacle box;
    box.shape = BoxShape{{uniform(engine, 0.1, 0.4), uniform(engine, 0.1, 0.4), uniform(engine, 0.1, 1.0)}};
    box.center_m = {uniform(engine, 1.8, 4), uniform(engine, -1.5, 1.5), uniform(engine, 0.1, 0.8)};
    box.yaw_rad = uniform(engine, 0, 3);
    box.material.texture.color =
        Rgb(uniform(engine, 0.1, 0.7), uniform(engine, 0.3, 0.7), uniform(engine, 0.1, 0.7));
    // Every fourth thing has nearly the ball's colour.
    if (i % 4 == 0) box.material.texture.color = Rgb(0.7, 0.1, 0.08);
    world.obstacles.push_back(box);
  }
  return world;
}

Ball red_ball(const Eigen::Vector3d& position_m) {
  Ball ball;
  ball.diameter_m = 2 * ball_radius_m;
  ball.material.texture.color = Rgb(0.8, 0.08, 0.05);
  ball.position_m = position_m;
  return ball;
}

// At about 1 m, as far as there is room.
void add_crowd(World& world, const Eigen::Isometry3d& X_WC, const BenchCrowd& crowd, RandomEngine& engine) {
  for (int k = 0; k < crowd.more_boxes; ++k) {
    Obstacle box;
    box.shape = BoxShape{{0.05, uniform(engine, 0.02, 0.12), uniform(engine, 0.02, 0.12)}};
    box.center_m = X_WC * Eigen::Vector3d(uniform(engine, -0.45, 0.45), uniform(engine, -0.3, 0.3),
                                          uniform(engine, 1.25, 1.6));
    box.material.texture.color = Rgb(0.7, 0.1, 0.08);
    world.obstacles.push_back(box);
  }
  for (int attempt = 0; attempt < 2000 && static_cast<int>(world.balls.size()) < crowd.balls; ++attempt) {
    const Eigen::Vector3d place =
        X_WC * Eigen::Vector3d(uniform(engine, -0.32, 0.32), uniform(engine, -0.22, 0.22), 1);
    const bool free = std::all_of(world.balls.begin(), world.balls.end(), [&](const Ball& other) {
      return (other.position_m - place).norm() > 2.4 * ball_radius_m;
    });
    if (free) world.balls.push_back(red_ball(place));
  }
}

}  // namespace

BenchSet make_frames(ImageSize size, double focal_px, int count, const BenchCrowd& crowd) {
  CameraParameters parameters;
  parameters.size = size;
  parameters.fx_px = parameters.fy_px = focal_px;
  parameters.cx_px = 0.5 * (size.width_px - 1);
  parameters.cy_px = 0.5 * (size.height_px - 1);
  const Camera camera(parameters);
  BenchSet set;
  set.rays = std::make_shared<const RayTable>(camera);
  auto colors = std::make_shared<ColorTable>();
  colors->classes.push_back({});
  colors->classes.back().name = "red";
  for (int r = 0; r < 64; ++r) {
    for (int g = 0; g < 64; ++g) {
      for (int b = 0; b < 64; ++b) {
        if (r > 7 && 10 * r > 19 * g && 10 * r > 19 * b)
          colors->table[static_cast<std::size_t>((r << 12) | (g << 6) | b)] = 1;
      }
    }
  }
  set.colors = colors;

  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  X_WC.translation() = Eigen::Vector3d(0, 0, 0.6);
  SensorOptions sensor;
  sensor.blur_px = 0.7;
  sensor.read_noise = 2;
  for (int k = 0; k < count; ++k) {
    auto engine = random_stream(11, "bench_frames", static_cast<std::uint64_t>(k));
    World world = cluttered_room(engine);
    BenchFrame frame;
    frame.p_CB = {uniform(engine, -0.2, 0.2), uniform(engine, -0.12, 0.12), uniform(engine, 0.98, 1.02)};
    if (crowd.balls > 0) world.balls.push_back(red_ball(X_WC * frame.p_CB));
    add_crowd(world, X_WC, crowd, engine);
    frame.truth = *project_sphere(camera, frame.p_CB, ball_radius_m);
    frame.bgr = CameraRenderer(camera, world, sensor).render({{X_WC, 0}}, 11, static_cast<std::uint64_t>(k));
    set.frames.push_back(frame);
  }
  return set;
}

}  // namespace ballservo::bench
