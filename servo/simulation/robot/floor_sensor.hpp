// What a camera can say of the floor ahead, by geometry: where the things that stand on it begin, and how
// much of it they hide.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "servo/avoidance/floor_fan.hpp"
#include "servo/motion/unicycle.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

class FloorSensor {
 public:
  /// `world` must outlive it.
  ///   edge_sigma_px   of the place in the picture where floor ends, each ray and frame anew
  ///   ignored         a ball that is known as such, and is floor here
  FloorSensor(const World& world, const Camera& camera, const CameraMount& mount, double reach_m,
              double edge_sigma_px, const std::string& ignored);

  /// The scan of a frame exposed at that time by a robot that is there.
  FloorScan scan(const Pose2& robot, double time_s, std::uint64_t seed, std::uint64_t frame) const;

 private:
  struct Span {
    double from_m, until_m;
  };
  /// A thing on the floor: its outline there, from which height to which.
  struct Thing {
    FloorOutline outline;
    double bottom_m, top_m;
  };
  std::optional<Span> hidden_by(const Thing& thing, const Eigen::Vector2d& apex,
                                const Eigen::Vector2d& ahead) const;
  std::optional<Span> hidden_by(const Ball& ball, double time_s, const Eigen::Vector2d& apex,
                                const Eigen::Vector2d& ahead) const;
  double to_wall_m(const Eigen::Vector2d& apex, const Eigen::Vector2d& ahead) const;

  const World& world_;
  CameraMount mount_;
  FloorFan fan_;
  double edge_sigma_px_;
  std::string ignored_;
  std::vector<Thing> things_;
};

}  // namespace ballservo
