#include "servo/simulation/rendering/view_painter.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace ballservo {

namespace {

constexpr int tile_width = 32, tile_height = 8;
constexpr double outline_reach_px = 0.75;  // a little more than half a pixel's diagonal

/// What a pixel shows at its centre, besides the surfaces of SurfaceHit.
constexpr int no_ray = -1;
constexpr int outline_here = -2;  // a ball's outline may cross the pixel
constexpr int first_ball = -3;    // ball k: first_ball - k

}  // namespace

ViewPainter::ViewPainter(const LensRays& rays, const Scene& scene, const Eigen::Isometry3d& X_WC)
    : rays_(rays),
      scene_(scene),
      view_(scene, X_WC),
      R_WC_(X_WC.linear().cast<float>()),
      reach_rad_(outline_reach_px * rays.widest_pixel_rad()),
      surfaces_(static_cast<std::size_t>(rays.width_px()) * static_cast<std::size_t>(rays.height_px())),
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
  tbb::parallel_for(0, (height + tile_height - 1) / tile_height, [&](int tile_row) {
    std::vector<int> near_solids;
    paint_centers(tile_row * tile_height, near_solids);
  });
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const tbb::blocked_range<int>& rows) {
    std::vector<int> near_solids;
    std::vector<NearBall> near_balls;
    for (int row = rows.begin(); row < rows.end(); ++row) paint_edges(row, near_solids, near_balls);
  });
  return colors_;
}

void ViewPainter::paint_centers(int top, std::vector<int>& near_solids) {
  const int bottom = std::min(top + tile_height, rays_.height_px());
  for (int left = 0; left < rays_.width_px(); left += tile_width) {
    const int right = std::min(left + tile_width, rays_.width_px());
    const bool near_ball = look_into_tile(top, left, bottom - top, right - left, near_solids);
    for (int row = top; row < bottom; ++row) {
      for (int column = left; column < right; column += lanes) {
        const Triples directions = center_rays(row, column);
        const SurfaceHits hits = scene_.hit_surfaces(view_.origin, directions, near_solids);
        Triples shown{};
        Ints known;
        scene_.shade_surfaces(hits, view_.origin, directions, rays_.pixel_rad(), shown, known);
        if (near_ball) known &= ~beside_balls(directions);
        for (int k = 0; k < std::min(lanes, right - column); ++k) {
          Rgb color(shown.x[k], shown.y[k], shown.z[k]);
          surfaces(row)[column + k] =
              known[k] != 0 ? hits.surface[k] : show_center(row, column + k, near_solids, color);
          set_color(row, column + k, color);
        }
      }
    }
  }
}

void ViewPainter::paint_edges(int row, std::vector<int>& near_solids, std::vector<NearBall>& near_balls) {
  const int width = rays_.width_px();
  const int* const here = surfaces(row);
  const int* const above = surfaces(std::max(row - 1, 0));
  const int* const below = surfaces(std::min(row + 1, rays_.height_px() - 1));
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

/// The solids that some ray of a tile could meet, and whether one could meet a ball; all of them where the
/// lens leaves a corner dark.
bool ViewPainter::look_into_tile(int row, int column, int rows, int columns, std::vector<int>& found) const {
  const Eigen::Vector3d middle = center_ray(row + rows / 2, column + columns / 2);
  double min_cosine = 1.0;
  for (const int r : {row, row + rows}) {
    for (const int c : {column, column + columns}) {
      const Eigen::Vector3d ray = corner(r, c);
      min_cosine = std::min(min_cosine, ray.allFinite() ? ray.dot(middle) : -1.0);
    }
  }
  const double reach_rad = 1.2 * std::acos(std::clamp(min_cosine, -1.0, 1.0)) + 2 * reach_rad_;
  const auto meets = [&](const Eigen::Vector3d& axis, double angle_rad) {
    const double sum_rad = angle_rad + reach_rad;
    return !(sum_rad < M_PI && middle.dot(axis) < std::cos(sum_rad));
  };
  found.clear();
  for (std::size_t k = 0; k < solids_.size(); ++k) {
    if (meets(solids_[k].axis, solids_[k].angle_rad)) found.push_back(static_cast<int>(k));
  }
  return std::any_of(view_.cones.begin(), view_.cones.end(),
                     [&](const BallCone& cone) { return meets(cone.axis, std::asin(cone.sin_alpha)); });
}

/// What a pixel shows at its centre; its colour, unless an outline crosses it.
int ViewPainter::show_center(int row, int column, const std::vector<int>& near_solids, Rgb& color) const {
  const Eigen::Vector3d direction = center_ray(row, column);
  color = Rgb::Zero();
  if (!direction.allFinite()) return no_ray;
  const SurfaceHit hit = scene_.hit_surface(view_.origin, direction, near_solids);
  int ball = -1;
  for (const BallCone& cone : view_.cones) {
    const double cosine = direction.dot(cone.axis);
    if (cosine < near_cosine(cone)) continue;
    if (cone.tangent_distance >= hit.t) continue;
    const double sine = (direction - cosine * cone.axis).norm();
    const double inside = cone.inside(cosine, sine);
    if (std::abs(inside) < reach_rad_) return outline_here;
    if (inside > 0) {
      ball = cone.ball;
      break;
    }
  }
  color = ball >= 0 ? scene_.shade_ball(ball, view_.origin, direction)
                    : scene_.shade_surface(hit, view_.origin, direction, rays_.pixel_rad());
  return ball >= 0 ? first_ball - ball : hit.surface;
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
