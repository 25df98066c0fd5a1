#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "servo/simulation/rendering/scene.hpp"

namespace ballservo {

namespace {

constexpr double cell_m = 0.04;
constexpr int most_cells = 400;   // along a side
constexpr int around_cells = 64;  // at least, around a cylinder

/// A surface to be lit.
struct LitSurface {
  Eigen::Vector2d low_m{0, 0}, high_m{0, 0};  // in surface coordinates
  Eigen::Vector2i least_cells{1, 1};
  int solid = -1;
  /// The point and the normal there.
  std::function<std::pair<Eigen::Vector3d, Eigen::Vector3d>(const Eigen::Vector2d& uv_m)> place;
};

LitSurface lit_surface(const Room& room, int surface) {
  const SurfaceAxes& axes = surface_axes[static_cast<std::size_t>(surface / 2)];
  const Eigen::Vector3d low = room.low_m(), high = room.high_m();
  const bool high_end = surface % 2 == 1;
  const Eigen::Vector3d normal = Eigen::Vector3d::Unit(axes.normal) * (high_end ? -1.0 : 1.0);
  const double level_m = (high_end ? high : low)[axes.normal];
  LitSurface lit;
  lit.low_m = {low[axes.u], low[axes.v]};
  lit.high_m = {high[axes.u], high[axes.v]};
  lit.place = [axes, normal, level_m](const Eigen::Vector2d& uv_m) {
    Eigen::Vector3d p;
    p[axes.u] = uv_m.x();
    p[axes.v] = uv_m.y();
    p[axes.normal] = level_m;
    return std::pair(p, normal);
  };
  return lit;
}

LitSurface lit_surface(const SceneSolid& solid, int index, int face) {
  const Eigen::Vector2d half_m = half_extent_of_face(solid, face);
  LitSurface lit;
  lit.low_m = -half_m;
  lit.high_m = half_m;
  lit.solid = index;
  if (solid.kind == SceneSolid::Kind::cylinder && face == 0) lit.least_cells.x() = around_cells;
  lit.place = [&solid, face](const Eigen::Vector2d& uv_m) { return place_on_face(solid, face, uv_m); };
  return lit;
}

bool has_face(const SceneSolid& solid, int face) {
  switch (solid.kind) {
    case SceneSolid::Kind::box:
      return true;
    case SceneSolid::Kind::cylinder:
      return face == 0 || face >= 4;
    case SceneSolid::Kind::disc:
      return face < 2;
  }
  return false;
}

}  // namespace

LightMap::LightMap(const World& world) : lamps_(world.lights.size()) {
  World still = world;
  still.balls.clear();
  const Scene scene(still, 0);
  grids_.resize(8 * (1 + scene.solids().size()));
  if (lamps_ == 0) return;
  const auto light_up = [&](int surface, const LitSurface& lit) {
    if (!is_plainly_lit(scene.material_of(surface))) return;
    Grid& grid = grids_[static_cast<std::size_t>(surface)];
    grid.origin_m = lit.low_m;
    const Eigen::Vector2d extent = lit.high_m - lit.low_m;
    const auto count = [](double length, int least) {
      return std::clamp(static_cast<int>(std::ceil(length / cell_m)), least, most_cells) + 1;
    };
    const int columns = count(extent.x(), lit.least_cells.x()), rows = count(extent.y(), lit.least_cells.y());
    grid.cells_per_m = {(columns - 1) / extent.x(), (rows - 1) / extent.y()};
    grid.shares.assign((lamps_ + 3) / 4, QuadGrid(columns, rows));
    tbb::parallel_for(0, rows, [&](int row) {
      for (int column = 0; column < columns; ++column) {
        const auto [p, normal] =
            lit.place(grid.origin_m + Eigen::Vector2d(column, row).cwiseQuotient(grid.cells_per_m));
        for (std::size_t k = 0; k < lamps_; ++k) {
          grid.shares[k / 4].cell(column, row)[k % 4] =
              static_cast<float>(scene.lamp_share(k, p, normal, lit.solid));
        }
      }
    });
  };
  for (int surface = 0; surface < 6; ++surface) light_up(surface, lit_surface(world.room, surface));
  for (int k = 0; k < static_cast<int>(scene.solids().size()); ++k) {
    const SceneSolid& solid = scene.solids()[static_cast<std::size_t>(k)];
    for (int face = 0; face < 6; ++face)
      if (has_face(solid, face)) light_up(8 * (k + 1) + face, lit_surface(solid, k, face));
  }
}

BALLSERVO_WIDE Triples LightMap::light(int surface, const Pairs& uv_m,
                                       const std::vector<Light>& lights) const {
  const Grid& grid = grids_[static_cast<std::size_t>(surface)];
  Triples sum{spread(0.0f), spread(0.0f), spread(0.0f)};
  if (grid.shares.empty()) return sum;
  // Inside the grid wherever it is asked for, and what is no number too: lanes may hold anything.
  const auto place = [](Floats at_m, double origin_m, double cells_per_m, int count) {
    const Floats cell = (at_m - static_cast<float>(origin_m)) * static_cast<float>(cells_per_m);
    return min(max(cell, spread(0.0f)), spread(count - 1.0001));
  };
  const QuadGrid& first = grid.shares.front();
  const Floats x = place(uv_m.u, grid.origin_m.x(), grid.cells_per_m.x(), first.columns());
  const Floats y = place(uv_m.v, grid.origin_m.y(), grid.cells_per_m.y(), first.rows());
  const Ints column = floor_index(x), row = floor_index(y);
  for (std::size_t k = 0; k < lamps_; k += 4) {
    const Quads shares = grid.shares[k / 4].between(column, row, x - to_float(column), y - to_float(row));
    for (std::size_t i = k; i < std::min(k + 4, lamps_); ++i) {
      sum.x += shares[i - k] * static_cast<float>(lights[i].intensity[0]);
      sum.y += shares[i - k] * static_cast<float>(lights[i].intensity[1]);
      sum.z += shares[i - k] * static_cast<float>(lights[i].intensity[2]);
    }
  }
  return sum;
}

}  // namespace ballservo
