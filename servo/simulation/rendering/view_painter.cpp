#include "servo/simulation/rendering/view_painter.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace ballservo {

namespace {

constexpr double outline_reach_px = 0.75;  // a little more than half a pixel's diagonal

/// What a pixel shows at its centre, besides the surfaces of SurfaceHits.
constexpr int no_ray = -1;
constexpr int outline_here = -2;  // a ball's outline may cross the pixel
constexpr int first_ball = -3;    // ball k: first_ball - k

}  // namespace

/// Some pixels next to each other, and what is found out of all of them before one is painted.
struct ViewPainter::Tile {
  static constexpr int width = 32, height = 8;

  int top = 0, left = 0, bottom = 0, right = 0;
  std::vector<int> near_solids;  // that some ray could meet
  bool near_ball = false;        // whether some ray could meet a ball
  Triples directions[height][width / lanes];
  SurfaceHits hits[height][width / lanes];
  bool beside_ball = false;  // whether a ball may keep light off what is seen
};

ViewPainter::ViewPainter(const LensRays& rays, const Scene& scene, const Eigen::Isometry3d& X_WC)
    : rays_(rays),
      scene_(scene),
      view_(scene, X_WC),
      R_WC_(X_WC.linear().cast<float>()),
      reach_rad_(outline_reach_px * rays.widest_pixel_rad()),
      surfaces_(rays.height_px(), rays.width_px(), CV_32SC1),
      colors_(rays.height_px(), rays.width_px(), CV_32FC3) {
  for (const SceneSolid& solid : scene.solids()) {
    const Eigen::Vector3d away = solid.center - view_.origin;
    const double distance = away.norm();
    SolidCone cone;
    if (distance > solid.bounding_radius) {
      cone.axis = away / distance;
      cone.angle_rad = std::min(std::asin(solid.bounding_radius / distance) + 2 * rays.pixel_rad(), 3.14);
      cone.min_cosine = std::cos(cone.angle_rad);
    }
    solids_.push_back(cone);
  }
}

cv::Mat ViewPainter::paint() {
  const int height = rays_.height_px();
  tbb::parallel_for(0, (height + Tile::height - 1) / Tile::height, [&](int tile_row) {
    Tile tile;
    paint_centers(tile_row * Tile::height, tile);
  });
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const tbb::blocked_range<int>& rows) {
    std::vector<int> near_solids;
    std::vector<NearBall> near_balls;
    for (int row = rows.begin(); row < rows.end(); ++row) paint_edges(row, near_solids, near_balls);
  });
  return colors_;
}

void ViewPainter::paint_centers(int top, Tile& tile) {
  tile.top = top;
  tile.bottom = std::min(top + Tile::height, rays_.height_px());
  for (tile.left = 0; tile.left < rays_.width_px(); tile.left = tile.right) {
    tile.right = std::min(tile.left + Tile::width, rays_.width_px());
    look_into(tile);
    cast_rays(tile);
    paint_centers(tile);
  }
}

BALLSERVO_WIDE void ViewPainter::cast_rays(Tile& tile) const {
  const Triples o = spread(view_.origin);
  const Floats far = spread(std::numeric_limits<float>::max());
  Triples low{far, far, far}, high{-far, -far, -far};
  for (int row = tile.top; row < tile.bottom; ++row) {
    for (int column = tile.left; column < tile.right; column += lanes) {
      Triples& directions = tile.directions[row - tile.top][(column - tile.left) / lanes];
      directions = center_rays(row, column);
      SurfaceHits& hits = tile.hits[row - tile.top][(column - tile.left) / lanes];
      hits = scene_.hit_surfaces(view_.origin, directions, tile.near_solids);
      const auto widen = [&](Floats p, Floats& lowest, Floats& highest) {  // by all but NaN
        lowest = min(p, lowest);
        highest = max(p, highest);
      };
      widen(o.x + hits.t * directions.x, low.x, high.x);
      widen(o.y + hits.t * directions.y, low.y, high.y);
      widen(o.z + hits.t * directions.z, low.z, high.z);
    }
  }
  Eigen::AlignedBox3f box;
  for (int k = 0; k < lanes; ++k) {
    box.extend(Eigen::Vector3f(low.x[k], low.y[k], low.z[k]));
    box.extend(Eigen::Vector3f(high.x[k], high.y[k], high.z[k]));
  }
  tile.beside_ball = scene_.ball_may_shade(box);
}

BALLSERVO_WIDE void ViewPainter::paint_centers(const Tile& tile) {
  for (int row = tile.top; row < tile.bottom; ++row) {
    int* const surfaces = surfaces_.ptr<int>(row);
    for (int column = tile.left; column < tile.right; column += lanes) {
      const Triples& directions = tile.directions[row - tile.top][(column - tile.left) / lanes];
      const SurfaceHits& hits = tile.hits[row - tile.top][(column - tile.left) / lanes];
      Triples shown{spread(0.0f), spread(0.0f), spread(0.0f)};
      Ints known;
      scene_.shade_surfaces(hits, view_.origin, directions, rays_.pixel_rad(), tile.beside_ball, shown,
                            known);
      if (tile.near_ball) known &= ~beside_balls(directions);
      if (all(known) && column + lanes <= tile.right) {
        std::memcpy(surfaces + column, &hits.surface, sizeof hits.surface);
        float rgb[3][lanes];
        std::memcpy(rgb, &shown, sizeof rgb);
        float* const bgr = colors_.ptr<float>(row) + 3 * column;
        for (int k = 0; k < lanes; ++k) {
          bgr[3 * k] = rgb[2][k];
          bgr[3 * k + 1] = rgb[1][k];
          bgr[3 * k + 2] = rgb[0][k];
        }
        continue;
      }
      for (int k = 0; k < std::min(lanes, tile.right - column); ++k) {
        Rgb color(shown.x[k], shown.y[k], shown.z[k]);
        surfaces[column + k] =
            known[k] != 0 ? hits.surface[k] : show_center(row, column + k, hits.surface[k], hits.t[k], color);
        set_color(row, column + k, color);
      }
    }
  }
}

BALLSERVO_WIDE void ViewPainter::paint_edges(int row, std::vector<int>& near_solids,
                                             std::vector<NearBall>& near_balls) {
  const int width = rays_.width_px();
  const int* const here = surfaces_.ptr<int>(row);
  const int* const above = surfaces_.ptr<int>(std::max(row - 1, 0));
  const int* const below = surfaces_.ptr<int>(std::min(row + 1, rays_.height_px() - 1));
  const auto lanes_at = [](const int* from) {
    Ints read;
    std::memcpy(&read, from, sizeof read);
    return read;
  };
  for (int column = 0; column < width; ++column) {
    const int surface = here[column];
    if (surface != outline_here && column > 0 && column + lanes < width) {  // alike all around?
      const Ints middle = lanes_at(here + column);
      if (all((middle == surface) & (lanes_at(above + column) == surface) &
              (lanes_at(below + column) == surface) & (lanes_at(here + column - 1) == surface) &
              (lanes_at(here + column + 1) == surface))) {
        column += lanes - 1;
        continue;
      }
    }
    const auto differs = [&](int other) { return other != surface && other != outline_here; };
    const bool edge = surface == outline_here || differs(above[column]) || differs(below[column]) ||
                      differs(here[std::max(column - 1, 0)]) ||
                      differs(here[std::min(column + 1, width - 1)]);
    if (!edge || surface == no_ray) continue;
    const PixelRays rays(corner(row, column), corner(row, column + 1), corner(row + 1, column),
                         corner(row + 1, column + 1));
    const Eigen::Vector3d middle = rays.at(0.5, 0.5).normalized();
    near_solids.clear();
    for (std::size_t k = 0; k < solids_.size(); ++k) {
      if (middle.dot(solids_[k].axis) >= solids_[k].min_cosine) near_solids.push_back(static_cast<int>(k));
    }
    set_color(row, column, edge_pixel(view_, rays, near_solids, reach_rad_, rays_.pixel_rad(), near_balls));
  }
}

/// The solids that some ray of the tile could meet, and whether one could meet a ball; all of them where the
/// lens leaves a corner dark.
void ViewPainter::look_into(Tile& tile) const {
  const Eigen::Vector3d middle = center_ray((tile.top + tile.bottom) / 2, (tile.left + tile.right) / 2);
  double min_cosine = 1.0;
  for (const int row : {tile.top, tile.bottom}) {
    for (const int column : {tile.left, tile.right}) {
      const Eigen::Vector3d ray = corner(row, column);
      min_cosine = std::min(min_cosine, ray.allFinite() ? ray.dot(middle) : -1.0);
    }
  }
  const double reach_rad = 1.2 * std::acos(std::clamp(min_cosine, -1.0, 1.0)) + 2 * reach_rad_;
  const auto meets = [&](const Eigen::Vector3d& axis, double angle_rad) {
    const double sum_rad = angle_rad + reach_rad;
    return !(sum_rad < M_PI && middle.dot(axis) < std::cos(sum_rad));
  };
  tile.near_solids.clear();
  for (std::size_t k = 0; k < solids_.size(); ++k) {
    if (meets(solids_[k].axis, solids_[k].angle_rad)) tile.near_solids.push_back(static_cast<int>(k));
  }
  tile.near_ball = std::any_of(view_.cones.begin(), view_.cones.end(), [&](const BallCone& cone) {
    return meets(cone.axis, std::asin(cone.sin_alpha));
  });
}

/// What a pixel shows at its centre, balls or else the surface at t; its colour, unless an outline crosses
/// it.
int ViewPainter::show_center(int row, int column, int surface, float t, Rgb& color) const {
  const Eigen::Vector3d direction = center_ray(row, column);
  color = Rgb::Zero();
  if (!direction.allFinite()) return no_ray;
  int ball = -1;
  for (const BallCone& cone : view_.cones) {
    const double cosine = direction.dot(cone.axis);
    if (cosine < near_cosine(cone)) continue;
    if (cone.tangent_distance >= static_cast<double>(t)) continue;
    const double sine = (direction - cosine * cone.axis).norm();
    const double inside = cone.inside(cosine, sine);
    if (std::abs(inside) < reach_rad_) return outline_here;
    if (inside > 0) {
      ball = cone.ball;
      break;
    }
  }
  color = ball >= 0 ? scene_.shade_ball(ball, view_.origin, direction)
                    : scene_.shade_surface(surface, t, view_.origin, direction, rays_.pixel_rad());
  return ball >= 0 ? first_ball - ball : surface;
}

double ViewPainter::near_cosine(const BallCone& cone) const {
  return cone.cos_alpha - 2 * reach_rad_ * (cone.sin_alpha + reach_rad_);
}

Ints ViewPainter::beside_balls(const Triples& directions) const {
  constexpr double rounding = 1e-6;
  Ints near{};
  for (const BallCone& cone : view_.cones) {
    const Floats cosine = directions.x * static_cast<float>(cone.axis.x()) +
                          directions.y * static_cast<float>(cone.axis.y()) +
                          directions.z * static_cast<float>(cone.axis.z());
    near |= cosine >= static_cast<float>(near_cosine(cone) - rounding);
  }
  return near;
}

Eigen::Vector3d ViewPainter::corner(int row, int column) const {
  return view_.R_WC * rays_.corner(row, column).cast<double>();
}

Eigen::Vector3d ViewPainter::center_ray(int row, int column) const {
  const Triples& rays = rays_.centers(row, column);
  const int k = column % lanes;
  return (view_.R_WC * Eigen::Vector3f(rays.x[k], rays.y[k], rays.z[k]).cast<double>()).normalized();
}

Triples ViewPainter::center_rays(int row, int column) const {
  const Triples& rays = rays_.centers(row, column);
  const auto along = [&](int axis) {
    return R_WC_(axis, 0) * rays.x + R_WC_(axis, 1) * rays.y + R_WC_(axis, 2) * rays.z;
  };
  return {along(0), along(1), along(2)};
}

void ViewPainter::set_color(int row, int column, const Rgb& color) {
  float* const bgr = colors_.ptr<float>(row) + 3 * column;
  for (int c = 0; c < 3; ++c) bgr[c] = static_cast<float>(color[2 - c]);
}

}  // namespace ballservo
