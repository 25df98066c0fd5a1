// Boards as a known camera sees them: as exact points with noise, and painted.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibration/base/random.hpp"
#include "calibration/boards/board.hpp"
#include "calibration/boards/board_calibration.hpp"
#include "calibration/camera/camera.hpp"

namespace ballservo::test {

inline const Board chessboard{BoardPattern::chessboard, 9, 6, 0.025};

inline std::vector<LensModel> only(LensModel model) { return {model}; }

/// Where a board stands.
struct PlacedBoard {
  Eigen::Matrix3d R_CB = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_CB{0, 0, 0};  ///< of the board frame's origin
};

inline std::optional<Eigen::Vector2d> seen(const Camera& camera, const PlacedBoard& placed,
                                           const Eigen::Vector3d& point_m, double margin_px) {
  const auto pixel = camera.project(placed.R_CB * point_m + placed.p_CB);
  const ImageSize size = camera.size();
  if (!pixel || pixel->x() < margin_px || pixel->y() < margin_px ||
      pixel->x() > size.width_px - 1 - margin_px || pixel->y() > size.height_px - 1 - margin_px)
    return std::nullopt;
  return pixel;
}

/// A place for a board wholly in the picture, tilted and turned by the stream's draws, `near_m` to `far_m`
/// away at a focal length of 500 px.
inline PlacedBoard random_place(const Camera& camera, const Board& board, RandomEngine& engine,
                                double tilt_rad, double near_m, double far_m, double margin_px) {
  const Eigen::Vector3d middle(0.5 * board.square_m * (board.columns - 1),
                               0.5 * board.square_m * (board.rows - 1), 0);
  while (true) {
    const double axis = uniform(engine, 0, 6.283185307179586);
    const Eigen::AngleAxisd tilt(uniform(engine, 0.5 * tilt_rad, tilt_rad),
                                 Eigen::Vector3d(std::cos(axis), std::sin(axis), 0));
    const Eigen::AngleAxisd turn(uniform(engine, -3.1, 3.1), Eigen::Vector3d::UnitZ());
    const auto ray = camera.unproject(
        {uniform(engine, 0, camera.size().width_px), uniform(engine, 0, camera.size().height_px)});
    if (!ray) continue;
    const double range_m = uniform(engine, near_m, far_m) * camera.focal_px() / 500;
    PlacedBoard placed;
    placed.R_CB = (tilt * turn).toRotationMatrix();
    placed.p_CB = range_m * *ray - placed.R_CB * middle;
    bool whole = true;
    for (const Eigen::Vector3d& point : board.points())
      whole = whole && seen(camera, placed, point, margin_px);
    if (whole) return placed;
  }
}

/// The corners of a placed board with normal noise.
inline BoardView noisy_view(const Camera& camera, const Board& board, const PlacedBoard& placed,
                            double noise_px, RandomEngine& engine, const std::string& name) {
  BoardView view{name, {}, {}};
  for (const Eigen::Vector3d& point : board.points()) {
    const auto pixel = camera.project(placed.R_CB * point + placed.p_CB);
    view.points_m.push_back(point);
    view.corners_px.push_back(*pixel +
                              noise_px * Eigen::Vector2d(standard_normal(engine), standard_normal(engine)));
  }
  return view;
}

/// Shears each view as a rolling shutter does where the board moves: all its corners err together, by about
/// `sigma_px` at the picture's upper and lower border.
inline void shear_views(std::vector<BoardView>& views, ImageSize size, double sigma_px, std::uint64_t seed) {
  RandomEngine engine = random_stream(seed, "rolling shutter");
  const double middle_px = 0.5 * size.height_px;
  for (BoardView& view : views) {
    const Eigen::Vector2d motion(standard_normal(engine), standard_normal(engine));
    for (Eigen::Vector2d& corner : view.corners_px)
      corner += sigma_px / middle_px * (corner.y() - middle_px) * motion;
  }
}

inline std::vector<BoardView> random_views(const Camera& camera, int count, double noise_px,
                                           std::uint64_t seed, double tilt_rad = 0.6, double near_m = 0.15,
                                           double far_m = 0.6) {
  RandomEngine engine = random_stream(seed, "boards");
  std::vector<BoardView> views;
  for (int i = 0; i < count; ++i) {
    const PlacedBoard placed = random_place(camera, chessboard, engine, tilt_rad, near_m, far_m, 0);
    views.push_back(noisy_view(camera, chessboard, placed, noise_px, engine,
                               "board " + std::to_string(seed) + "." + std::to_string(i)));
  }
  return views;
}

/// A grey picture of a placed chessboard with a white margin of one square, each pixel the mean of
/// `samples` x `samples` rays.
inline cv::Mat painted_chessboard(const Camera& camera, const Board& board, const PlacedBoard& placed,
                                  int samples = 4) {
  const ImageSize size = camera.size();
  cv::Mat picture(size.height_px, size.width_px, CV_32F);
  const Eigen::Matrix3d R_BC = placed.R_CB.transpose();
  const Eigen::Vector3d p_BC = -R_BC * placed.p_CB;
  const auto brightness = [&](const Eigen::Vector2d& pixel) {
    constexpr float room = 90, white = 215, black = 35;
    const auto ray = camera.unproject(pixel);
    if (!ray) return room;
    const Eigen::Vector3d direction = R_BC * *ray;
    const double range = -p_BC.z() / direction.z();
    if (!(range > 0)) return room;
    const double column = (p_BC.x() + range * direction.x()) / board.square_m + 1;
    const double row = (p_BC.y() + range * direction.y()) / board.square_m + 1;
    if (column < -1 || row < -1 || column > board.columns + 2 || row > board.rows + 2) return room;
    if (column < 0 || row < 0 || column > board.columns + 1 || row > board.rows + 1) return white;
    return (static_cast<int>(column) + static_cast<int>(row)) % 2 == 0 ? black : white;
  };
  // Pixels whose four corners agree are taken for even: edges are where the work is.
  const int columns = size.width_px + 1;
  std::vector<float> corners;
  for (int v = 0; v <= size.height_px; ++v)
    for (int u = 0; u < columns; ++u) corners.push_back(brightness({u - 0.5, v - 0.5}));
  for (int v = 0; v < size.height_px; ++v) {
    for (int u = 0; u < size.width_px; ++u) {
      const float* const corner = &corners[static_cast<std::size_t>(v * columns + u)];
      const float even = corner[0];
      picture.at<float>(v, u) = even;
      if (corner[1] == even && corner[columns] == even && corner[columns + 1] == even) continue;
      float sum = 0;
      for (int j = 0; j < samples; ++j)
        for (int i = 0; i < samples; ++i)
          sum += brightness({u - 0.5 + (i + 0.5) / samples, v - 0.5 + (j + 0.5) / samples});
      picture.at<float>(v, u) = sum / static_cast<float>(samples * samples);
    }
  }
  return picture;
}

/// That picture with normal noise, in 8 bits.
inline cv::Mat photographed(const cv::Mat& painted, double noise_levels, RandomEngine& engine) {
  cv::Mat picture(painted.size(), CV_8U);
  for (int v = 0; v < painted.rows; ++v)
    for (int u = 0; u < painted.cols; ++u)
      picture.at<std::uint8_t>(v, u) =
          cv::saturate_cast<std::uint8_t>(painted.at<float>(v, u) + noise_levels * standard_normal(engine));
  return picture;
}

}  // namespace ballservo::test
