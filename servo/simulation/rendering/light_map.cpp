#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "servo/simulation/rendering/scene.hpp"

namespace ballservo {

namespace {

constexpr double cell_m = 0.04;
constexpr int most_cells = 400;   // along a side
constexpr int around_cells = 64;  // at least, around a cylinder

bool has_face(const SceneSolid& solid, int face) {
  if (solid.kind == SceneSolid::Kind::cylinder) return face == 0 || face >= 4;
  return solid.kind == SceneSolid::Kind::box || face < 2;
}

}  // namespace

LightMap::LightMap(const World& world) {
  World still = world;
  still.balls.clear();
  const Scene scene(still, 0);
  grids_.resize(8 * (1 + scene.solids().size()));
  std::vector<std::size_t> course_of_lamp;
  for (const Light& lamp : world.lights) {
    const auto known = std::find(courses_.begin(), courses_.end(), lamp.course);
    course_of_lamp.push_back(static_cast<std::size_t>(known - courses_.begin()));
    if (known == courses_.end()) courses_.push_back(lamp.course);
  }
  if (courses_.empty()) return;
  // `place` gives the point and the normal there, in world axes, of surface coordinates within `extent_m`.
  const auto light_up = [&](int surface, const Eigen::AlignedBox2d& extent_m, int least_columns,
                            const auto& place) {
    if (!is_plainly_lit(scene.material_of(surface))) return;
    Grid& grid = grids_[static_cast<std::size_t>(surface)];
    grid.origin_m = extent_m.min();
    const Eigen::Vector2d sides_m = extent_m.sizes();
    const auto count = [](double length, int least) {
      return std::clamp(static_cast<int>(std::ceil(length / cell_m)), least, most_cells) + 1;
    };
    const int columns = count(sides_m.x(), least_columns), rows = count(sides_m.y(), 1);
    grid.cells_per_m = {(columns - 1) / sides_m.x(), (rows - 1) / sides_m.y()};
    grid.lights.assign(courses_.size(), QuadGrid(columns, rows));
    tbb::parallel_for(0, rows, [&](int row) {
      for (int column = 0; column < columns; ++column) {
        const auto [p, normal] =
            place(grid.origin_m + Eigen::Vector2d(column, row).cwiseQuotient(grid.cells_per_m));
        for (std::size_t k = 0; k < world.lights.size(); ++k) {
          const Light& lamp = world.lights[k];
          const double share = scene.lamp_share(lamp, p, normal, solid_of(surface));
          float* const light = grid.lights[course_of_lamp[k]].cell(column, row);
          for (int c = 0; c < 3; ++c) light[c] += static_cast<float>(share * lamp.intensity[c]);
        }
      }
    });
  };
  const Eigen::Vector3d low_m = world.room.low_m(), high_m = world.room.high_m();
  for (int face = 0; face < 6; ++face) {
    const FacePlane plane = face_plane(face);
    const Eigen::Vector2d low_uv_m(low_m[plane.u], low_m[plane.v]),
        high_uv_m(high_m[plane.u], high_m[plane.v]);
    light_up(face, {low_uv_m, high_uv_m}, 1, [&](const Eigen::Vector2d& uv_m) {
      Eigen::Vector3d p = plane.sign > 0 ? high_m : low_m;
      p[plane.u] = uv_m.x();
      p[plane.v] = uv_m.y();
      return std::pair<Eigen::Vector3d, Eigen::Vector3d>(p, -plane.sign * Eigen::Vector3d::Unit(plane.axis));
    });
  }
  for (std::size_t k = 0; k < scene.solids().size(); ++k) {
    const SceneSolid& solid = scene.solids()[k];
    for (int face = 0; face < 6; ++face) {
      if (!has_face(solid, face)) continue;
      const Eigen::Vector2d half_m = half_extent_of_face(solid, face);
      const bool around = solid.kind == SceneSolid::Kind::cylinder && face == 0;
      light_up(8 * (static_cast<int>(k) + 1) + face, {-half_m, half_m}, around ? around_cells : 1,
               [&](const Eigen::Vector2d& uv_m) { return place_on_face(solid, face, uv_m); });
    }
  }
}

std::vector<Rgb> LightMap::gains(double time_s) const {
  std::vector<Rgb> gains;
  for (const LightCourse& course : courses_) gains.push_back(course.gain(time_s));
  return gains;
}

BALLSERVO_WIDE Triples LightMap::light(int surface, const Pairs& uv_m, const std::vector<Rgb>& gains) const {
  const Grid& grid = grids_[static_cast<std::size_t>(surface)];
  Triples sum{spread(0.0f), spread(0.0f), spread(0.0f)};
  if (grid.lights.empty()) return sum;
  // Inside the grid wherever it is asked for, and what is no number too: lanes may hold anything.
  const auto place = [](Floats at_m, double origin_m, double cells_per_m, int count) {
    const Floats cell = (at_m - static_cast<float>(origin_m)) * static_cast<float>(cells_per_m);
    return min(max(cell, spread(0.0f)), spread(count - 1.0001));
  };
  const QuadGrid& first = grid.lights.front();
  const Floats x = place(uv_m.u, grid.origin_m.x(), grid.cells_per_m.x(), first.columns());
  const Floats y = place(uv_m.v, grid.origin_m.y(), grid.cells_per_m.y(), first.rows());
  const Ints column = floor_index(x), row = floor_index(y);
  for (std::size_t k = 0; k < gains.size(); ++k) {
    const Quads light = grid.lights[k].between(column, row, x - to_float(column), y - to_float(row));
    sum.x += light[0] * static_cast<float>(gains[k][0]);
    sum.y += light[1] * static_cast<float>(gains[k][1]);
    sum.z += light[2] * static_cast<float>(gains[k][2]);
  }
  return sum;
}

}  // namespace ballservo
