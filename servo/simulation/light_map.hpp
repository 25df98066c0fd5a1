// How much light the lamps throw on the room's surfaces, worked out once: lamps and solids stand still.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "servo/simulation/texture.hpp"
#include "servo/simulation/world.hpp"

namespace ballservo {

/// Light of all lamps on floor, ceiling and walls, in the shade of the solids but not of the balls, on a grid
/// of 4 cm (coarser where a surface is longer than 16 m), interpolated in between.
class LightMap {
 public:
  explicit LightMap(const World& world);

  /// `surface` from 0 to 5 and `uv_m` as in SurfaceHit.
  Rgb light(int surface, const Eigen::Vector2d& uv_m) const;

 private:
  struct Grid {
    Eigen::Vector2d origin_m{0, 0};
    Eigen::Vector2d cells_per_m{1, 1};
    int columns = 0, rows = 0;  // 0: nothing to be lit
    std::vector<Eigen::Vector3f> values;
  };
  std::array<Grid, 6> grids_;
};

}  // namespace ballservo
