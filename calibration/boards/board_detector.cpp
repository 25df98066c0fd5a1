#include "calibration/boards/board_detector.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "calibration/boards/corner_refinement.hpp"

namespace ballservo {
namespace {

constexpr double least_part = 1.0 / 3;  // of a chessboard's corners
constexpr int least_side_px = 16;       // OpenCV's finders want some pixels to work on

using Grid = PointGrid<cv::Point2f>;

bool is_whole(const Grid& grid) {
  return grid.columns > 0 && grid.points.size() == static_cast<std::size_t>(grid.columns * grid.rows) &&
         std::all_of(grid.points.begin(), grid.points.end(),
                     [](const cv::Point2f& p) { return std::isfinite(p.x) && std::isfinite(p.y); });
}

/// Points of the longer and of the shorter side.
template <class GridOrBoard>
std::pair<int, int> size_of(const GridOrBoard& grid) {
  return {std::max(grid.columns, grid.rows), std::min(grid.columns, grid.rows)};
}

/// Whether a grid lies inside another, in one direction or the other.
bool fits(const Grid& part, const Board& board) {
  return size_of(part).first <= size_of(board).first && size_of(part).second <= size_of(board).second;
}

std::optional<Grid> whole_chessboard(const cv::Mat& gray, const Board& board) {
  Grid grid{board.columns, board.rows, {}};
  if (!cv::findChessboardCorners(
          gray, cv::Size(board.columns, board.rows), grid.points,
          cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK) ||
      !is_whole(grid))
    return std::nullopt;
  return grid;
}

/// The largest chessboard that grows from a seed of half the board's size (Duda and Frese, BMVC 2018).
std::optional<Grid> grown_chessboard(const cv::Mat& gray, const Board& board) {
  Grid grid;
  cv::Mat meta;
  const cv::Size seed(std::max(3, board.columns / 2), std::max(3, board.rows / 2));
  if (!cv::findChessboardCornersSB(
          gray, seed, grid.points,
          cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_LARGER, meta))
    return std::nullopt;
  grid.columns = meta.cols, grid.rows = meta.rows;
  if (!is_whole(grid)) return std::nullopt;
  return grid;
}

/// The smallest distance between neighbours in a row or column (px).
float smallest_spacing(const Grid& grid) {
  float smallest = std::numeric_limits<float>::infinity();
  const auto consider = [&](cv::Point2f a, cv::Point2f b) {
    smallest = std::min(smallest, std::hypot(a.x - b.x, a.y - b.y));
  };
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      if (column > 0) consider(grid.at(row, column), grid.at(row, column - 1));
      if (row > 0) consider(grid.at(row, column), grid.at(row - 1, column));
    }
  }
  return smallest;
}

/// Refines the corners, and leaves out those whose window the picture's border cuts off and those about which
/// the picture shows no crossing.
BoardView refined_corners(const cv::Mat& gray, Grid grid, const Board& board) {
  constexpr double window_share = 0.33;
  const int half = std::max(2, static_cast<int>(std::lround(window_share * smallest_spacing(grid))));
  for (cv::Point2f& p : grid.points) {
    p.x = std::clamp(p.x, 0.0f, static_cast<float>(gray.cols - 1));
    p.y = std::clamp(p.y, 0.0f, static_cast<float>(gray.rows - 1));
  }
  cv::cornerSubPix(gray, grid.points, cv::Size(half, half), cv::Size(-1, -1),
                   cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 1e-2));
  CornerGrid found{grid.columns, grid.rows, {}};
  for (const cv::Point2f& p : grid.points) found.points.emplace_back(p.x, p.y);
  const auto corners = refine_corners(gray, found);
  BoardView view;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const auto& corner = corners[static_cast<std::size_t>(row * grid.columns + column)];
      if (!corner) continue;
      view.points_m.emplace_back(board.square_m * column, board.square_m * row, 0);
      view.corners_px.push_back(*corner);
    }
  }
  return view;
}

/// Scales at which a picture is searched, the most promising first: the finders' own windows suit boards of
/// some hundred pixels.
std::vector<double> search_scales(const cv::Mat& gray) {
  constexpr int large_px = 1000, small_px = 400;
  const int side = std::max(gray.cols, gray.rows);
  std::vector<double> scales{1.0};
  if (side > large_px) scales.push_back(0.5);
  if (side > 2 * large_px) scales.push_back(0.25);
  if (side < small_px) scales.push_back(2.0);
  return scales;
}

cv::Mat scaled(const cv::Mat& gray, double scale) {
  if (scale == 1) return gray;
  cv::Mat result;
  cv::resize(gray, result, {}, scale, scale, scale < 1 ? cv::INTER_AREA : cv::INTER_CUBIC);
  return result;
}

/// Back to the pixels of the unscaled picture; pixel centres lie at whole numbers in both.
void unscale(Grid& grid, double scale) {
  const auto shift = static_cast<float>(0.5 / scale - 0.5), factor = static_cast<float>(1 / scale);
  for (cv::Point2f& p : grid.points) p = p * factor + cv::Point2f(shift, shift);
}

cv::Mat gray_of(const cv::Mat& picture) {
  if (picture.channels() == 1) return picture;
  cv::Mat gray;
  cv::cvtColor(picture, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

/// Whether the cells between the points are in turn dark and light, as a chessboard's are: a grid that skips
/// squares, or runs on into the background, is not.
bool alternates(const cv::Mat& gray, const Grid& grid) {
  constexpr double least_share = 0.95, least_contrast = 8;
  std::vector<double> levels;
  std::vector<bool> odd;
  for (int row = 0; row + 1 < grid.rows; ++row) {
    for (int column = 0; column + 1 < grid.columns; ++column) {
      const cv::Point2f middle = 0.25f * (grid.at(row, column) + grid.at(row + 1, column) +
                                          grid.at(row, column + 1) + grid.at(row + 1, column + 1));
      const int u = std::clamp(static_cast<int>(std::lround(middle.x)), 0, gray.cols - 1);
      const int v = std::clamp(static_cast<int>(std::lround(middle.y)), 0, gray.rows - 1);
      levels.push_back(gray.at<std::uint8_t>(v, u));
      odd.push_back((row + column) % 2 == 1);
    }
  }
  double sums[2] = {0, 0}, counts[2] = {0, 0};
  for (std::size_t i = 0; i < levels.size(); ++i) sums[odd[i]] += levels[i], counts[odd[i]] += 1;
  if (counts[0] == 0 || counts[1] == 0) return false;
  const double even_mean = sums[0] / counts[0], odd_mean = sums[1] / counts[1];
  if (std::abs(even_mean - odd_mean) < least_contrast) return false;
  const double threshold = 0.5 * (even_mean + odd_mean);
  std::size_t right = 0;
  for (std::size_t i = 0; i < levels.size(); ++i)
    if ((levels[i] > threshold) == ((odd[i] ? odd_mean : even_mean) > threshold)) ++right;
  return static_cast<double>(right) >= least_share * static_cast<double>(levels.size());
}

/// Whether there is enough for a pose: points that do not lie on one line.
bool gives_a_pose(const BoardView& view, const Board& board) {
  constexpr std::size_t least_points = 6;
  if (view.size() < least_points ||
      static_cast<double>(view.size()) < least_part * board.columns * board.rows)
    return false;
  double width_m = 0, height_m = 0;
  for (const Eigen::Vector3d& point : view.points_m) {
    width_m = std::max(width_m, std::abs(point.x() - view.points_m.front().x()));
    height_m = std::max(height_m, std::abs(point.y() - view.points_m.front().y()));
  }
  return width_m > 0 && height_m > 0;
}

BoardFinding find_chessboard(const cv::Mat& gray, const Board& board) {
  BoardFinding finding;
  for (const double scale : search_scales(gray)) {
    const cv::Mat searched = scaled(gray, scale);
    auto grid = grown_chessboard(searched, board);
    if (grid && !alternates(searched, *grid)) grid.reset();
    if (grid) finding.seen = size_of(*grid);
    if (!grid || size_of(*grid) != size_of(board)) {
      const auto whole = whole_chessboard(searched, board);
      if (whole && alternates(searched, *whole)) grid = whole;
    }
    if (!grid || !fits(*grid, board)) continue;
    if (!finding.seen) finding.seen = size_of(*grid);
    unscale(*grid, scale);
    BoardView view = refined_corners(gray, std::move(*grid), board);
    if (gives_a_pose(view, board)) return {std::move(view), "", finding.seen};
    finding.reason = fmt::format(
        "the board is seen, but only {} of its corners are sharp and clear of the border: it is too "
        "small, out of focus or cut off",
        view.size());
  }
  if (finding.reason.empty())
    finding.reason = "the board was not found in it, or less than a third of it is seen";
  return finding;
}

BoardFinding find_circles(const cv::Mat& gray, const Board& board) {
  const int layout =
      board.pattern == BoardPattern::circles ? cv::CALIB_CB_SYMMETRIC_GRID : cv::CALIB_CB_ASYMMETRIC_GRID;
  for (const bool light_on_dark : {false, true}) {
    for (const double scale : search_scales(gray)) {
      const cv::Mat searched = scaled(light_on_dark ? cv::Mat(255 - gray) : gray, scale);
      for (const int how : {0, static_cast<int>(cv::CALIB_CB_CLUSTERING)}) {
        Grid grid{board.columns, board.rows, {}};
        if (!cv::findCirclesGrid(searched, cv::Size(board.columns, board.rows), grid.points, layout | how) ||
            !is_whole(grid))
          continue;
        unscale(grid, scale);
        BoardView view{"", board.points(), {}};
        for (const cv::Point2f& p : grid.points) view.corners_px.emplace_back(p.x, p.y);
        return {std::move(view), "", std::nullopt};
      }
    }
  }
  return {std::nullopt, "not all circles of the board were found in it", std::nullopt};
}

/// The grey level below which 99 % of the pixels are.
int bright_level(const cv::Mat& gray) {
  std::array<long, 256> counts{};
  for (int v = 0; v < gray.rows; ++v)
    for (int u = 0; u < gray.cols; ++u) ++counts[gray.at<std::uint8_t>(v, u)];
  int level = 255;
  for (long brighter = 0; level > 0; --level) {
    brighter += counts[static_cast<std::size_t>(level)];
    if (100 * brighter > static_cast<long>(gray.total())) break;
  }
  return level;
}

BoardFinding find_pattern(const cv::Mat& gray, const Board& board) {
  try {
    return board.pattern == BoardPattern::chessboard ? find_chessboard(gray, board)
                                                     : find_circles(gray, board);
  } catch (const cv::Exception&) {
    // OpenCV's finders assert on some pictures that hold no board.
    return {std::nullopt, "the board was not found in it", std::nullopt};
  }
}

}  // namespace

BoardFinding find_board(const cv::Mat& picture, const Board& board) {
  const cv::Mat gray = gray_of(picture);
  if (gray.cols < least_side_px || gray.rows < least_side_px)
    return {std::nullopt, fmt::format("it is smaller than {} pixels", least_side_px), std::nullopt};
  // OpenCV's finders draw from the thread's own random numbers (trees of neighbours, clustering): whatever
  // came before, a picture gives the same corners.
  cv::setRNGSeed(0);
  BoardFinding finding = find_pattern(gray, board);
  constexpr int dark_level = 50;
  if (!finding.view && bright_level(gray) < dark_level)
    finding.reason +=
        fmt::format("; it is dark: hardly a pixel is above grey level {} of 255", bright_level(gray));
  return finding;
}

}  // namespace ballservo
