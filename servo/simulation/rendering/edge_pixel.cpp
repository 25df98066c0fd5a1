#include "servo/simulation/rendering/edge_pixel.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ballservo {

namespace {

constexpr int pixel_cells = 4;  // samples of an edge pixel, per side
constexpr int squares = 2;      // squares of a cell, per side, for ball outlines

/// The share of a square (centre x, y and side in pixels) inside a ball's outline.
double ball_share(const BallCone& cone, const PixelRays& rays, double x, double y, double side) {
  const Eigen::Vector3d q = rays.at(x, y);
  const double inverse = 1.0 / q.norm();
  const Eigen::Vector3d u = q * inverse;
  const double cosine = u.dot(cone.axis);
  const double sine = (u - cosine * cone.axis).norm();
  const double inside_rad = std::asin(std::clamp(cone.inside(cosine, sine), -1.0, 1.0));
  if (sine < 1e-9) return inside_rad > 0 ? 1.0 : 0.0;
  // d(angle from the axis)/d(pixel) = -(axis . du/d(pixel)) / sine.
  const Eigen::Vector3d qx = rays.slope_x(y), qy = rays.slope_y(x);
  const double slope_x = (cone.axis.dot(qx) - cosine * u.dot(qx)) * inverse / sine;
  const double slope_y = (cone.axis.dot(qy) - cosine * u.dot(qy)) * inverse / sine;
  const double slope = std::sqrt(slope_x * slope_x + slope_y * slope_y);
  return half_plane_share(inside_rad / slope, slope_x / slope, slope_y / slope, side);
}

void find_near_balls(const std::vector<BallCone>& cones, const PixelRays& rays, double reach_rad,
                     std::vector<NearBall>& found) {
  found.clear();
  const Eigen::Vector3d u = rays.at(0.5, 0.5).normalized();
  for (const BallCone& cone : cones) {
    const double cosine = u.dot(cone.axis);
    const double sine = (u - cosine * cone.axis).norm();
    const double inside = cone.inside(cosine, sine);
    if (cosine <= 0 || inside < -reach_rad) continue;
    found.push_back({&cone, inside > reach_rad});
  }
}

/// What the surfaces seen in a pixel look like: each is shaded once, since its texture is filtered over the
/// pixel.
class PixelSurfaces {
 public:
  PixelSurfaces(const Viewpoint& view, double pixel_rad) : view_(view), pixel_rad_(pixel_rad) {}

  const Rgb& color(int surface, float t, const Eigen::Vector3d& direction) {
    const auto end = shaded_.begin() + count_;
    const auto known =
        std::find_if(shaded_.begin(), end, [&](const Shaded& s) { return s.surface == surface; });
    if (known == end) {
      *known = {surface, view_.scene.shade_surface(surface, t, view_.origin, direction, pixel_rad_)};
      ++count_;
    }
    return known->color;
  }

 private:
  struct Shaded {
    int surface = 0;
    Rgb color{0, 0, 0};
  };

  const Viewpoint& view_;
  double pixel_rad_;
  std::array<Shaded, pixel_cells * pixel_cells> shaded_;
  std::ptrdiff_t count_ = 0;
};

/// The unit rays of the samples from `first` on, one in each cell: no two share a row or a column of
/// sixteenths.
Triples sample_rays(const PixelRays& rays, int first) {
  Floats x{}, y{};
  for (int k = 0; k < lanes; ++k) {
    const int i = (first + k) % pixel_cells, j = (first + k) / pixel_cells;
    x[k] = static_cast<float>((i + (j + 0.5) / pixel_cells) / pixel_cells);
    y[k] = static_cast<float>((j + (i + 0.5) / pixel_cells) / pixel_cells);
  }
  const auto along = [&](int axis) {
    return static_cast<float>(rays.base[axis]) + x * static_cast<float>(rays.along_x[axis]) +
           y * static_cast<float>(rays.along_y[axis]) + x * y * static_cast<float>(rays.twist[axis]);
  };
  const Triples ray{along(0), along(1), along(2)};
  const Floats inverse = 1.0f / square_root(ray.x * ray.x + ray.y * ray.y + ray.z * ray.z);
  return {ray.x * inverse, ray.y * inverse, ray.z * inverse};
}

}  // namespace

Viewpoint::Viewpoint(const Scene& seen, const Eigen::Isometry3d& X_WC)
    : scene(seen), origin(X_WC.translation()), R_WC(X_WC.linear()) {
  for (std::size_t k = 0; k < scene.balls().size(); ++k) {
    const SceneBall& ball = scene.balls()[k];
    const Eigen::Vector3d away = ball.center - origin;
    const double distance = away.norm();
    if (distance <= ball.radius * (1 + 1e-9)) continue;  // the camera is inside: nothing to be seen of it
    BallCone cone;
    cone.axis = away / distance;
    cone.sin_alpha = ball.radius / distance;
    cone.cos_alpha = std::sqrt(1.0 - cone.sin_alpha * cone.sin_alpha);
    cone.tangent_distance = distance * cone.cos_alpha;
    cone.ball = static_cast<int>(k);
    cones.push_back(cone);
  }
  std::sort(cones.begin(), cones.end(),
            [](const BallCone& a, const BallCone& b) { return a.tangent_distance < b.tangent_distance; });
}

double half_plane_share(double inside, double slope_x, double slope_y, double side) {
  const double x = std::abs(slope_x) * side / 2, y = std::abs(slope_y) * side / 2;
  const double longer = std::max(x, y), shorter = std::min(x, y);
  const double distance = std::abs(inside);
  double share = 1.0;  // of the side on which the centre lies
  if (distance < longer - shorter) {
    share = 0.5 + distance / (2 * longer);
  } else if (distance < longer + shorter) {
    const double corner = longer + shorter - distance;  // a triangle is cut off
    share = 1.0 - corner * corner / (8 * longer * shorter);
  }
  return inside >= 0 ? share : 1.0 - share;
}

Rgb edge_pixel(const Viewpoint& view, const PixelRays& rays, const std::vector<int>& solids, double reach_rad,
               double pixel_rad, std::vector<NearBall>& near_balls) {
  static_assert(pixel_cells * pixel_cells % lanes == 0);
  find_near_balls(view.cones, rays, reach_rad, near_balls);
  PixelSurfaces surfaces(view, pixel_rad);
  Rgb sum = Rgb::Zero();
  for (int first = 0; first < pixel_cells * pixel_cells; first += lanes) {
    const Triples directions = sample_rays(rays, first);
    const SurfaceHits hits = view.scene.hit_surfaces(view.origin, directions, solids);
    for (int k = 0; k < lanes; ++k) {
      const int i = (first + k) % pixel_cells, j = (first + k) / pixel_cells;
      const Eigen::Vector3d direction(directions.x[k], directions.y[k], directions.z[k]);
      double rest = 1.0;
      for (const auto& [near_cone, whole] : near_balls) {
        const BallCone& cone = *near_cone;
        if (cone.tangent_distance >= static_cast<double>(hits.t[k])) continue;
        double share = whole ? squares * squares : 0;
        for (int sj = 0; sj < squares && !whole; ++sj) {
          for (int si = 0; si < squares; ++si) {
            share += ball_share(cone, rays, (i + (si + 0.5) / squares) / pixel_cells,
                                (j + (sj + 0.5) / squares) / pixel_cells, 1.0 / (pixel_cells * squares));
          }
        }
        share /= squares * squares;
        if (share <= 0.0) continue;
        sum += (rest * share) * view.scene.shade_ball(cone.ball, view.origin, direction);
        rest *= 1.0 - share;
        if (rest <= 1e-12) break;
      }
      if (rest > 1e-12) sum += rest * surfaces.color(hits.surface[k], hits.t[k], direction);
    }
  }
  return sum / (pixel_cells * pixel_cells);
}

}  // namespace ballservo
