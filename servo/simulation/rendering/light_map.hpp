// What share of every lamp's light the room's surfaces get, worked out once: lamps and solids stand still.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "servo/simulation/world/texture.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

/// What floor, ceiling and walls get of each lamp, in the shade of the solids but not of the balls, on a grid
/// of 4 cm (coarser where a surface is longer than 16 m), interpolated in between.
class LightMap {
 public:
  explicit LightMap(const World& world);

  /// The light of all lamps on four points, each lamp as bright as `lights` says (the world's, in its order).
  /// `surface` from 0 to 5 and `uv_m` as in SurfaceHit.
  Triple4 light(int surface, const Pair4& uv_m, const std::vector<Light>& lights) const;

 private:
  struct Grid {
    Eigen::Vector2d origin_m{0, 0};
    Eigen::Vector2d cells_per_m{1, 1};
    int columns = 0, rows = 0;  // 0: nothing to be lit
    std::vector<float> values;  // lamps fastest, then columns
  };
  std::size_t lamps_ = 0;
  std::array<Grid, 6> grids_;
};

}  // namespace ballservo
