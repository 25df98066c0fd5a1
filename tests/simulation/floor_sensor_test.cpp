// What the geometric reading of the floor says, against rays cast through the scene.
#include <gtest/gtest.h>

#include "calibration/base/random.hpp"
#include "calibration/camera/files/camera_file.hpp"
#include "servo/motion/camera_mount.hpp"
#include "servo/simulation/rendering/scene.hpp"
#include "servo/simulation/robot/geometric_sensors.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

const CameraMount camera_mount{0.10, 0.28, 0.21};
constexpr double reach_m = 1.8;

Camera wide_camera() { return read_camera((test::project_data_dir() / "cameras" / "wide.yaml").string()); }

World random_world(RandomEngine& engine) {
  World world;
  world.room = {-2, 2.2, -2, 2, 2.5, {}, {}, {}};
  for (int k = 0; k < 6; ++k) {
    Obstacle thing;
    const double height = uniform(engine, 0.03, 0.5);
    if (k % 2 == 0) {
      thing.shape = BoxShape{{uniform(engine, 0.05, 0.4), uniform(engine, 0.05, 0.4), height}};
      thing.yaw_rad = uniform(engine, -3, 3);
    } else {
      thing.shape = CylinderShape{uniform(engine, 0.03, 0.2), height};
    }
    thing.center_m = {uniform(engine, 0.9, 2.0), uniform(engine, -1.2, 1.2), height / 2};
    world.obstacles.push_back(thing);
  }
  Ball ball;
  ball.name = "other";
  ball.diameter_m = 0.12;
  ball.position_m = {uniform(engine, 0.8, 1.8), uniform(engine, -0.6, 0.6), 0.06};
  world.balls.push_back(ball);
  return world;
}

/// Whether nothing stands between the camera and that point of the floor.
bool sees(const Scene& scene, const Eigen::Vector3d& eye, const Eigen::Vector3d& floor) {
  const Eigen::Vector3d away = floor - eye;
  const double distance = away.norm();
  if (scene.hit_solids(eye, away / distance, distance) < distance) return false;
  for (const SceneBall& ball : scene.balls()) {
    const Eigen::Vector3d to = ball.center - eye;
    const double along = to.dot(away) / distance;
    if (along > 0 && along < distance && to.squaredNorm() - along * along < ball.radius * ball.radius)
      return false;
  }
  return true;
}

TEST(FloorSensor, FloorIsClearExactlyAsFarAsLinesOfSightReachIt) {
  const Camera camera = wide_camera();
  RandomEngine engine = random_stream(0, "floor sensor test");
  int hits = 0;
  for (int round = 0; round < 40; ++round) {
    const World world = random_world(engine);
    const Pose2 robot{uniform(engine, -0.3, 0.2), uniform(engine, -0.3, 0.3), uniform(engine, -0.4, 0.4)};
    const FloorScan scan = FloorSensor(world, camera, camera_mount, reach_m, 0, "none").scan(robot, 0, 0, 0);
    ASSERT_GT(scan.count, 50u);
    const Scene scene(world, 0);
    const Eigen::Vector2d foot = in_world_frame(robot, {camera_mount.forward_m, 0});
    const Eigen::Vector3d eye(foot.x(), foot.y(), camera_mount.up_m);
    for (std::size_t k = 0; k < scan.count; ++k) {
      const FloorRay& ray = scan.rays[k];
      const double heading = robot.yaw_rad + ray.bearing_rad;
      const auto seen = [&](double range_m) {
        return sees(scene, eye,
                    {foot.x() + range_m * std::cos(heading), foot.y() + range_m * std::sin(heading), 0});
      };
      for (double range_m = ray.from_m; range_m < ray.clear_m - 1e-6; range_m += 0.02)
        EXPECT_TRUE(seen(range_m)) << round << ' ' << ray.bearing_rad << ' ' << range_m;
      if (ray.clear_m >= reach_m) continue;
      ++hits;
      if (ray.clear_m == ray.from_m) continue;
      for (const double share : {0.02, 0.5, 0.98}) {
        const double range_m = ray.clear_m + share * (ray.until_m - ray.clear_m);
        const Eigen::Vector2d p = foot + range_m * Eigen::Vector2d(std::cos(heading), std::sin(heading));
        const bool in_room = p.x() < world.room.x_max_m && std::abs(p.y()) < world.room.y_max_m;
        EXPECT_FALSE(in_room && seen(range_m)) << round << ' ' << ray.bearing_rad << ' ' << range_m;
      }
    }
  }
  EXPECT_GT(hits, 300) << "empty worlds show nothing";
}

TEST(FloorSensor, FloorIsSeenAgainRightBehindWhatALowThingHides) {
  const Camera camera = wide_camera();
  RandomEngine engine = random_stream(1, "floor sensor test");
  int again = 0;
  for (int round = 0; round < 30; ++round) {
    World world = random_world(engine);
    world.room.x_max_m = 9;
    if (round % 3 != 0) world.balls.clear();
    world.obstacles.resize(round % 3 == 0 ? 0 : 1);
    for (Obstacle& thing : world.obstacles) {  // no higher than 12 cm
      if (auto* box = std::get_if<BoxShape>(&thing.shape)) box->size_m.z() = 0.08;
      if (round % 3 == 2) thing.shape = CylinderShape{0.1, 0.12};
      thing.center_m.z() = round % 3 == 2 ? 0.06 : 0.04;
    }
    const FloorScan scan = FloorSensor(world, camera, camera_mount, 3.0, 0, "none").scan({}, 0, 0, 0);
    const Scene scene(world, 0);
    const Eigen::Vector3d eye(camera_mount.forward_m, 0, camera_mount.up_m);
    for (std::size_t k = 0; k < scan.count; ++k) {
      const FloorRay& ray = scan.rays[k];
      if (ray.clear_m == ray.from_m || ray.until_m >= 3.0) continue;
      const auto seen = [&](double range_m) {
        return sees(scene, eye,
                    {camera_mount.forward_m + range_m * std::cos(ray.bearing_rad),
                     range_m * std::sin(ray.bearing_rad), 0});
      };
      ++again;
      EXPECT_FALSE(seen(ray.until_m - 0.002)) << round << ' ' << ray.bearing_rad;
      EXPECT_TRUE(seen(ray.until_m + 0.002)) << round << ' ' << ray.bearing_rad;
    }
  }
  EXPECT_GT(again, 50);
}

TEST(FloorSensor, TheKnownBallIsFloorAndWallsEndIt) {
  World world;
  world.room = {-2, 1.2, -2, 2, 2.5, {}, {}, {}};
  Ball ball;
  ball.name = "target";
  ball.diameter_m = 0.12;
  ball.position_m = {0.9, 0, 0.06};
  world.balls = {ball};
  const Camera camera = wide_camera();
  const auto middle = [&](const std::string& known) {
    const FloorScan scan = FloorSensor(world, camera, camera_mount, reach_m, 0, known).scan({}, 0, 0, 0);
    return scan.rays[scan.count / 2];
  };
  EXPECT_NEAR(middle("target").clear_m * std::cos(middle("target").bearing_rad), 1.1, 1e-9) << "the wall";
  EXPECT_LT(middle("").clear_m, 0.8);
}

TEST(FloorSensor, EdgesErrByThePixelsThatAreStated) {
  World world;
  world.room = {-2, 1.2, -3, 3, 2.5, {}, {}, {}};
  const Camera camera = wide_camera();
  const FloorFan fan(camera, camera_mount, reach_m);
  const FloorSensor exact(world, camera, camera_mount, reach_m, 0, ""),
      rough(world, camera, camera_mount, reach_m, 1.5, "");
  double sum2 = 0;
  int count = 0;
  for (std::uint64_t frame = 0; frame < 50; ++frame) {
    const FloorScan a = exact.scan({}, 0, 7, frame), b = rough.scan({}, 0, 7, frame);
    for (std::size_t k = 0; k < a.count; ++k) {
      const double error_px =
          (b.rays[k].clear_m - a.rays[k].clear_m) / fan.metres_per_pixel(a.rays[k].clear_m);
      sum2 += error_px * error_px;
      ++count;
    }
  }
  EXPECT_NEAR(std::sqrt(sum2 / count), 1.5, 0.1);
  EXPECT_EQ(rough.scan({}, 0, 7, 3).rays[9].clear_m, rough.scan({}, 0, 7, 3).rays[9].clear_m);
  EXPECT_NE(rough.scan({}, 0, 7, 3).rays[9].clear_m, rough.scan({}, 0, 8, 3).rays[9].clear_m);
}

TEST(FloorSensor, ATurnedCameraSeesWhatARobotTurnedSoFarWouldSee) {
  RandomEngine engine = random_stream(2, "floor sensor test");
  const World world = random_world(engine);
  const CameraMount over_axle{0, 0.28, 0.21};
  const FloorSensor sensor(world, wide_camera(), over_axle, reach_m, 0, "");
  const FloorScan by_pan = sensor.scan({0.1, 0.2, -0.3}, 0, 7, 0, 0.5),
                  by_robot = sensor.scan({0.1, 0.2, 0.2}, 0, 7, 0);
  ASSERT_GT(by_pan.count, 0u);
  bool something_stands = false;
  for (std::size_t k = 0; k < by_pan.count; ++k) {
    EXPECT_EQ(by_pan.rays[k].bearing_rad, by_robot.rays[k].bearing_rad) << "as if it were not turned";
    EXPECT_NEAR(by_pan.rays[k].clear_m, by_robot.rays[k].clear_m, 1e-9);
    something_stands |= by_pan.rays[k].clear_m < reach_m;
  }
  EXPECT_TRUE(something_stands);
}

TEST(FloorFan, ItsPixelsSeeTheFloorWhereItSays) {
  const Camera camera = wide_camera();
  const FloorFan fan(camera, camera_mount, reach_m);
  ASSERT_GE(fan.rays().size(), 60u);
  for (const FloorFan::Ray& ray : fan.rays()) {
    EXPECT_FALSE(fan.pixel(ray.bearing_rad, ray.from_m - 0.02)) << "nearer than it begins";
    for (double range_m = ray.from_m; range_m < reach_m; range_m += 0.1) {
      const auto pixel = fan.pixel(ray.bearing_rad, range_m);
      ASSERT_TRUE(pixel);
      const Eigen::Vector3d ray_R = camera_mount.X_RC().linear() * *camera.unproject(*pixel);
      const Eigen::Vector3d p_R = camera_mount.X_RC().translation() - ray_R * (camera_mount.up_m / ray_R.z());
      EXPECT_NEAR(std::hypot(p_R.x() - camera_mount.forward_m, p_R.y()), range_m, 1e-6);
      EXPECT_NEAR(std::atan2(p_R.y(), p_R.x() - camera_mount.forward_m), ray.bearing_rad, 1e-6);
    }
  }
  EXPECT_TRUE(FloorFan(camera, {0.1, 0.28, -1.2}, reach_m).rays().empty()) << "it looks at the ceiling";
}

}  // namespace
}  // namespace ballservo
