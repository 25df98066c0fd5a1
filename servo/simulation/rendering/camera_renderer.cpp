#include "servo/simulation/rendering/camera_renderer.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "calibration/base/options.hpp"

namespace ballservo {

namespace {

constexpr int tile_width = 32, tile_height = 8;
constexpr int cells = 4;                   // samples of an edge pixel, per side
constexpr int squares = 2;                 // squares of a cell, per side, for ball outlines
constexpr double outline_reach_px = 0.75;  // a little more than half a pixel's diagonal

/// A ball as the camera sees it: its tangent cone.
struct BallCone {
  Eigen::Vector3d axis{0, 0, 1};  // world
  double cos_alpha = 1, sin_alpha = 0;
  double tangent_distance = 0;  // from the camera to the outline's points on the ball
  int ball = 0;

  /// The sine of the angle by which a unit ray lies inside: accurate for small balls too.
  double inside(double cosine, double sine) const { return sin_alpha * cosine - cos_alpha * sine; }
};

/// One frame's view of the scene.
struct Viewpoint {
  const Scene& scene;
  Eigen::Vector3d origin;
  Eigen::Matrix3d R_WC;
  std::vector<BallCone> cones;  // nearest first
};

/// What a pixel shows at its centre, besides the surfaces of SurfaceHit.
constexpr int no_ray = -1;
constexpr int outline_here = -2;  // a ball's outline may cross the pixel
constexpr int first_ball = -3;    // ball k: first_ball - k

/// The corner rays of a pixel in world axes, interpolated in between. Between neighbouring corners a lens is
/// straight to a few 1e-4 px, and the corners themselves are exact.
struct PixelRays {
  Eigen::Vector3d base, along_x, along_y, twist;

  PixelRays(const Eigen::Vector3d& r00, const Eigen::Vector3d& r10, const Eigen::Vector3d& r01,
            const Eigen::Vector3d& r11)
      : base(r00), along_x(r10 - r00), along_y(r01 - r00), twist(r11 - r10 - r01 + r00) {}
  /// x and y from 0 to 1 over the pixel; not of unit length.
  Eigen::Vector3d at(double x, double y) const { return base + x * along_x + y * along_y + (x * y) * twist; }
  Eigen::Vector3d slope_x(double y) const { return along_x + y * twist; }
  Eigen::Vector3d slope_y(double x) const { return along_y + x * twist; }
};

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

/// Where in each cell its surface sample lies: 16 points of which no two share a row or column of sixteenths.
constexpr std::array<std::array<double, 2>, cells* cells> cell_offsets = [] {
  std::array<std::array<double, 2>, cells * cells> offsets{};
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      offsets[static_cast<std::size_t>(j * cells + i)] = {(j + 0.5) / cells, (i + 0.5) / cells};
    }
  }
  return offsets;
}();

/// A ball whose cone reaches into a pixel, and whether the pixel lies all inside it.
struct NearBall {
  const BallCone* cone;
  bool whole;
};

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

/// The colour of a pixel that edges cross.
Rgb edge_pixel(const Viewpoint& view, const PixelRays& rays, const std::vector<NearBall>& balls,
               const std::vector<int>& solids, double pixel_rad) {
  struct Shaded {
    int surface;
    Rgb color;
  };
  std::array<Shaded, cells * cells>
      shaded;  // each surface is shaded once: its texture is filtered over the pixel
  int shaded_count = 0;
  Rgb sum = Rgb::Zero();
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      const auto& offset = cell_offsets[static_cast<std::size_t>(j * cells + i)];
      const double x = (i + offset[0]) / cells, y = (j + offset[1]) / cells;
      const Eigen::Vector3d direction = rays.at(x, y).normalized();
      const SurfaceHit hit = view.scene.hit_surface(view.origin, direction, solids);
      double rest = 1.0;
      for (const auto& [near_cone, whole] : balls) {
        const BallCone& cone = *near_cone;
        if (cone.tangent_distance >= hit.t) continue;
        double share = whole ? squares * squares : 0;
        for (int sj = 0; sj < squares && !whole; ++sj) {
          for (int si = 0; si < squares; ++si) {
            share += ball_share(cone, rays, (i + (si + 0.5) / squares) / cells,
                                (j + (sj + 0.5) / squares) / cells, 1.0 / (cells * squares));
          }
        }
        share /= squares * squares;
        if (share <= 0.0) continue;
        sum += (rest * share) * view.scene.shade_ball(cone.ball, view.origin, direction);
        rest *= 1.0 - share;
        if (rest <= 1e-12) break;
      }
      if (rest <= 1e-12) continue;
      const auto end = shaded.begin() + shaded_count;
      auto known =
          std::find_if(shaded.begin(), end, [&](const Shaded& s) { return s.surface == hit.surface; });
      if (known == end) {
        *known = {hit.surface, view.scene.shade_surface(hit, view.origin, direction, pixel_rad)};
        ++shaded_count;
      }
      sum += rest * known->color;
    }
  }
  return sum / (cells * cells);
}

int fours_of(int width) { return (width + 3) / 4; }

std::vector<BallCone> ball_cones(const Scene& scene, const Eigen::Vector3d& origin) {
  std::vector<BallCone> cones;
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
  return cones;
}

/// Bounding cones of the solids: which of them can a ray meet?
struct SolidCone {
  Eigen::Vector3d axis{0, 0, 1};
  double min_cosine = -1;
};

std::vector<SolidCone> solid_cones(const Scene& scene, const Eigen::Vector3d& origin, double margin_rad) {
  std::vector<SolidCone> cones;
  for (const SceneSolid& solid : scene.solids()) {
    const Eigen::Vector3d away = solid.center - origin;
    const double distance = away.norm();
    SolidCone cone;
    if (distance > solid.bounding_radius) {
      cone.axis = away / distance;
      cone.min_cosine = std::cos(std::min(std::asin(solid.bounding_radius / distance) + margin_rad, 3.14));
    }
    cones.push_back(cone);
  }
  return cones;
}

}  // namespace

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

void CameraRenderer::set_world(World world) {
  world_ = std::move(world);
  light_map_ = LightMap(world_);
}

CameraRenderer::CameraRenderer(const Camera& camera, World world, const SensorOptions& sensor)
    : camera_(camera), world_(std::move(world)), light_map_(world_), sensor_(sensor) {
  check_options("sensor", sensor_);
  const int width = camera_.size().width_px + 1, height = camera_.size().height_px + 1;
  const Eigen::Vector3f dark = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  corner_rays_.resize(static_cast<std::size_t>(width * height));
  const auto corner = [&](int row, int column) -> Eigen::Vector3f& {
    return corner_rays_[static_cast<std::size_t>(row * width + column)];
  };
  tbb::parallel_for(0, height, [&](int row) {
    for (int column = 0; column < width; ++column) {
      const auto ray = camera_.unproject({column - 0.5, row - 0.5});
      corner(row, column) = ray ? ray->cast<float>().eval() : dark;
    }
  });
  const int fours = fours_of(width - 1);
  center_rays_.resize(static_cast<std::size_t>(fours * (height - 1)));
  for (int row = 0; row + 1 < height; ++row) {
    for (int column = 0; column < 4 * fours; ++column) {
      Eigen::Vector3f ray = dark;
      if (column + 1 < width) {
        ray = ((corner(row, column) + corner(row, column + 1)) +
               (corner(row + 1, column) + corner(row + 1, column + 1)))
                  .normalized();
      }
      Triple4& rays = center_rays_[static_cast<std::size_t>(row * fours + column / 4)];
      rays.x[column % 4] = ray.x();
      rays.y[column % 4] = ray.y();
      rays.z[column % 4] = ray.z();
    }
  }
  for (int row = 1; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const Eigen::Vector3f& here = corner(row, column);
      const float along = column == 0 ? 0.0f : (here - corner(row, column - 1)).norm();
      for (const float step : {along, (here - corner(row - 1, column)).norm()}) {
        if (step > widest_pixel_rad_) widest_pixel_rad_ = step;  // never for NaN
      }
    }
  }
}

cv::Mat CameraRenderer::view_radiance(const CameraView& camera_view) const {
  const Scene scene(world_, camera_view.time_s, &light_map_);
  const Viewpoint view{scene, camera_view.X_WC.translation(), camera_view.X_WC.linear(),
                       ball_cones(scene, camera_view.X_WC.translation())};
  const int width = camera_.size().width_px, height = camera_.size().height_px;
  const double pixel_rad = 1.0 / camera_.focal_px();
  const std::vector<SolidCone> solids = solid_cones(scene, view.origin, 2 * pixel_rad);
  const auto corner = [&](int row, int column) -> Eigen::Vector3d {
    return view.R_WC * corner_rays_[static_cast<std::size_t>(row * (width + 1) + column)].cast<double>();
  };
  const auto pixel_rays = [&](int row, int column) {
    return PixelRays(corner(row, column), corner(row, column + 1), corner(row + 1, column),
                     corner(row + 1, column + 1));
  };
  const int fours = fours_of(width);
  const auto center_ray = [&](int row, int column) -> Eigen::Vector3d {
    const Triple4& rays = center_rays_[static_cast<std::size_t>(row * fours + column / 4)];
    const int k = column % 4;
    return (view.R_WC * Eigen::Vector3f(rays.x[k], rays.y[k], rays.z[k]).cast<double>()).normalized();
  };
  const auto center_rays = [&, R = Eigen::Matrix3f(view.R_WC.cast<float>())](int row, int column) {
    const Triple4& rays = center_rays_[static_cast<std::size_t>(row * fours + column / 4)];
    const auto along = [&](int axis) {
      return R(axis, 0) * rays.x + R(axis, 1) * rays.y + R(axis, 2) * rays.z;
    };
    return Triple4{along(0), along(1), along(2)};
  };
  const double widest_rad = outline_reach_px * widest_pixel_rad_;
  const auto candidates = [&](const Eigen::Vector3d& direction, std::vector<int>& found) {
    found.clear();
    for (std::size_t k = 0; k < solids.size(); ++k) {
      if (direction.dot(solids[k].axis) >= solids[k].min_cosine) found.push_back(static_cast<int>(k));
    }
  };

  // The solids that some ray of a tile could meet, and whether one could meet a ball; all of them where the
  // lens leaves a corner dark.
  const auto look_into_tile = [&](int row, int column, int rows, int columns, std::vector<int>& found) {
    const Eigen::Vector3d middle = center_ray(row + rows / 2, column + columns / 2);
    double min_cosine = 1.0;
    for (const int r : {row, row + rows}) {
      for (const int c : {column, column + columns}) {
        const Eigen::Vector3d ray = corner(r, c);
        min_cosine = std::min(min_cosine, ray.allFinite() ? ray.dot(middle) : -1.0);
      }
    }
    const double reach = 1.2 * std::acos(std::clamp(min_cosine, -1.0, 1.0)) + 2 * widest_rad;
    const auto meets = [&](const Eigen::Vector3d& axis, double cosine) {
      return !(std::acos(std::clamp(middle.dot(axis), -1.0, 1.0)) > std::acos(cosine) + reach);
    };
    found.clear();
    for (std::size_t k = 0; k < solids.size(); ++k) {
      if (meets(solids[k].axis, solids[k].min_cosine)) found.push_back(static_cast<int>(k));
    }
    return std::any_of(view.cones.begin(), view.cones.end(),
                       [&](const BallCone& cone) { return meets(cone.axis, cone.cos_alpha); });
  };

  // Four neighbours that see one surface of the room, and no shade of a ball, at once: the surface, or
  // nothing.
  const auto show_four = [&](int row, int column, const std::vector<int>& near_solids,
                             Triple4& four_colors) -> std::optional<int> {
    const Triple4 directions = center_rays(row, column);
    for (const int k : near_solids) {
      const SolidCone& solid = solids[static_cast<std::size_t>(k)];
      const Float4 cosine = directions.x * static_cast<float>(solid.axis.x()) +
                            directions.y * static_cast<float>(solid.axis.y()) +
                            directions.z * static_cast<float>(solid.axis.z());
      if (any(cosine >= static_cast<float>(solid.min_cosine))) return std::nullopt;
    }
    const RoomHits hits = scene.hit_room(view.origin, directions);
    const int surface = hits.surface[0];
    const bool alike = all(hits.t < std::numeric_limits<float>::max()) && all(hits.surface == surface) &&
                       scene.light_is_mapped(surface) &&
                       scene.shade_room(surface, hits.t, view.origin, directions, pixel_rad, four_colors);
    return alike ? std::make_optional(surface) : std::nullopt;
  };

  // What a pixel shows at its centre; its colour, unless an outline crosses it.
  const auto show_center = [&](int row, int column, const std::vector<int>& near_solids, Rgb& color) {
    const Eigen::Vector3d direction = center_ray(row, column);
    color = Rgb::Zero();
    if (!direction.allFinite()) return no_ray;
    const SurfaceHit hit = scene.hit_surface(view.origin, direction, near_solids);
    int ball = -1;
    for (const BallCone& cone : view.cones) {
      const double cosine = direction.dot(cone.axis);
      if (cosine < cone.cos_alpha - 2 * widest_rad * (cone.sin_alpha + widest_rad)) continue;
      if (cone.tangent_distance >= hit.t) continue;
      const double sine = (direction - cosine * cone.axis).norm();
      const double inside = cone.inside(cosine, sine);
      if (std::abs(inside) < widest_rad) return outline_here;
      if (inside > 0) {
        ball = cone.ball;
        break;
      }
    }
    color = ball >= 0 ? scene.shade_ball(ball, view.origin, direction)
                      : scene.shade_surface(hit, view.origin, direction, pixel_rad);
    return ball >= 0 ? first_ball - ball : hit.surface;
  };

  // First every pixel by its centre, then those that an edge crosses again, cut into squares.
  std::vector<int> surfaces(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const auto surface_row = [&](int row) {
    return surfaces.data() + static_cast<std::ptrdiff_t>(row) * width;
  };
  cv::Mat colors(height, width, CV_32FC3);
  const auto paint = [&colors](int row, int column, const Rgb& color) {
    float* out = colors.ptr<float>(row) + 3 * column;
    for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(color[2 - c]);
  };
  const int tile_columns = (width + tile_width - 1) / tile_width,
            tile_rows = (height + tile_height - 1) / tile_height;
  tbb::parallel_for(0, tile_rows, [&](int tile_row) {
    std::vector<int> near_solids;
    const int top = tile_row * tile_height, bottom = std::min(top + tile_height, height);
    for (int tile_column = 0; tile_column < tile_columns; ++tile_column) {
      const int left = tile_column * tile_width, right = std::min(left + tile_width, width);
      const bool near_ball = look_into_tile(top, left, bottom - top, right - left, near_solids);
      for (int row = top; row < bottom; ++row) {
        for (int column = left; column < right; column += 4) {
          Triple4 four_colors{};
          const auto surface = near_ball ? std::nullopt : show_four(row, column, near_solids, four_colors);
          for (int k = 0; k < std::min(4, right - column); ++k) {
            Rgb color(four_colors.x[k], four_colors.y[k], four_colors.z[k]);
            surface_row(row)[column + k] =
                surface ? *surface : show_center(row, column + k, near_solids, color);
            paint(row, column + k, color);
          }
        }
      }
    }
  });

  tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const tbb::blocked_range<int>& rows) {
    std::vector<NearBall> near_balls;
    std::vector<int> near_solids;
    for (int row = rows.begin(); row < rows.end(); ++row) {
      const int* here = surface_row(row);
      const int* above = surface_row(std::max(row - 1, 0));
      const int* below = surface_row(std::min(row + 1, height - 1));
      for (int column = 0; column < width; ++column) {
        const int surface = here[column];
        const auto differs = [&](int other) { return other != surface && other != outline_here; };
        const bool edge = surface == outline_here || differs(above[column]) || differs(below[column]) ||
                          differs(here[std::max(column - 1, 0)]) ||
                          differs(here[std::min(column + 1, width - 1)]);
        if (!edge || surface == no_ray) continue;
        const PixelRays rays = pixel_rays(row, column);
        candidates(rays.at(0.5, 0.5).normalized(), near_solids);
        find_near_balls(view.cones, rays, widest_rad, near_balls);
        const Rgb color = edge_pixel(view, rays, near_balls, near_solids, pixel_rad);
        paint(row, column, color);
      }
    }
  });
  return colors;
}

cv::Mat CameraRenderer::radiance(const std::vector<CameraView>& exposure) const {
  if (exposure.size() == 1) return view_radiance(exposure.front());
  cv::Mat sum(camera_.size().height_px, camera_.size().width_px, CV_32FC3, cv::Scalar::all(0));
  for (const CameraView& view : exposure) sum += view_radiance(view);
  return exposure.empty() ? sum : cv::Mat(sum / static_cast<double>(exposure.size()));
}

cv::Mat CameraRenderer::render(const std::vector<CameraView>& exposure, std::uint64_t seed,
                               std::uint64_t frame_index) const {
  return expose(radiance(exposure), sensor_, seed, frame_index);
}

}  // namespace ballservo
