#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "servo/simulation/rendering/scene.hpp"

namespace ballservo {

namespace {

constexpr double cell_m = 0.04;
constexpr int most_cells = 400;  // along a side

}  // namespace

LightMap::LightMap(const World& world) : lamps_(world.lights.size()) {
  World still = world;
  still.balls.clear();
  const Scene scene(still, 0);
  const Eigen::Vector3d room_low = world.room.low_m(), room_high = world.room.high_m();
  for (std::size_t surface = 0; surface < grids_.size(); ++surface) {
    const Material& material = surface == 0   ? world.room.floor
                               : surface == 1 ? world.room.ceiling
                                              : world.room.wall;
    if (material.luminous || lamps_ == 0) continue;
    const SurfaceAxes& axes = surface_axes[surface / 2];
    const bool high_end = surface % 2 == 1;
    const Eigen::Vector3d normal = Eigen::Vector3d::Unit(axes.normal) * (high_end ? -1.0 : 1.0);
    Grid& grid = grids_[surface];
    grid.origin_m = {room_low[axes.u], room_low[axes.v]};
    const Eigen::Vector2d extent = Eigen::Vector2d(room_high[axes.u], room_high[axes.v]) - grid.origin_m;
    const auto count = [](double length) {
      return std::clamp(static_cast<int>(std::ceil(length / cell_m)), 1, most_cells) + 1;
    };
    grid.columns = count(extent.x());
    grid.rows = count(extent.y());
    grid.cells_per_m = {(grid.columns - 1) / extent.x(), (grid.rows - 1) / extent.y()};
    grid.values.resize(static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows) * lamps_);
    tbb::parallel_for(0, grid.rows, [&](int row) {
      for (int column = 0; column < grid.columns; ++column) {
        Eigen::Vector3d p;
        p[axes.u] = grid.origin_m.x() + column / grid.cells_per_m.x();
        p[axes.v] = grid.origin_m.y() + row / grid.cells_per_m.y();
        p[axes.normal] = (high_end ? room_high : room_low)[axes.normal];
        float* const shares =
            &grid.values[(static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns) +
                          static_cast<std::size_t>(column)) *
                         lamps_];
        for (std::size_t k = 0; k < lamps_; ++k)
          shares[k] = static_cast<float>(scene.lamp_share(k, p, normal));
      }
    });
  }
}

Triple4 LightMap::light(int surface, const Pair4& uv_m, const std::vector<Light>& lights) const {
  const Grid& grid = grids_[static_cast<std::size_t>(surface)];
  Triple4 sum{};
  if (grid.columns == 0 || lamps_ == 0) return sum;
  const auto place = [](Float4 at_m, double origin_m, double cells_per_m, int count) {
    return max(four(0.0f), min(four(count - 1.0001),
                               (at_m - static_cast<float>(origin_m)) * static_cast<float>(cells_per_m)));
  };
  const Float4 x = place(uv_m.u, grid.origin_m.x(), grid.cells_per_m.x(), grid.columns);
  const Float4 y = place(uv_m.v, grid.origin_m.y(), grid.cells_per_m.y(), grid.rows);
  const Int4 column = floor_index(x), row = floor_index(y);
  const Float4 fx = x - to_float(column), fy = y - to_float(row);
  const std::size_t stride = static_cast<std::size_t>(grid.columns) * lamps_;
  std::array<const float*, 4> low{};
  for (int i = 0; i < 4; ++i) {
    low[static_cast<std::size_t>(i)] = grid.values.data() + static_cast<std::size_t>(row[i]) * stride +
                                       static_cast<std::size_t>(column[i]) * lamps_;
  }
  for (std::size_t k = 0; k < lamps_; ++k) {
    const auto corner = [&](std::size_t at) {
      return Float4{low[0][at], low[1][at], low[2][at], low[3][at]};
    };
    const Float4 share = (1 - fy) * ((1 - fx) * corner(k) + fx * corner(k + lamps_)) +
                         fy * ((1 - fx) * corner(k + stride) + fx * corner(k + stride + lamps_));
    sum.x += share * static_cast<float>(lights[k].intensity[0]);
    sum.y += share * static_cast<float>(lights[k].intensity[1]);
    sum.z += share * static_cast<float>(lights[k].intensity[2]);
  }
  return sum;
}

}  // namespace ballservo
