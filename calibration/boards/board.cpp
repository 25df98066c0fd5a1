#include "calibration/boards/board.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {

std::vector<Eigen::Vector3d> Board::points() const {
  std::vector<Eigen::Vector3d> result;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      result.emplace_back(square_m * (pattern == BoardPattern::acircles ? 2 * column + row % 2 : column),
                          square_m * row, 0);
  return result;
}

double mean_motion_px(const BoardView& a, const BoardView& b) {
  std::map<std::pair<double, double>, Eigen::Vector2d> places_px;
  for (std::size_t i = 0; i < a.size(); ++i)
    places_px[{a.points_m[i].x(), a.points_m[i].y()}] = a.corners_px[i];
  double sum_px = 0, turned_sum_px = 0;
  int common = 0;
  for (std::size_t i = 0; i < b.size(); ++i) {
    const auto place = places_px.find({b.points_m[i].x(), b.points_m[i].y()});
    if (place == places_px.end()) continue;
    sum_px += (place->second - b.corners_px[i]).norm();
    ++common;
  }
  if (common == 0) return std::numeric_limits<double>::infinity();
  if (a.points_m != b.points_m) return sum_px / common;
  for (std::size_t i = 0; i < b.size(); ++i)
    turned_sum_px += (a.corners_px[b.size() - 1 - i] - b.corners_px[i]).norm();
  return std::min(sum_px, turned_sum_px) / common;
}

Board parse_board(const std::string& text, double square_m) {
  FaultList faults;
  Board board;
  board.square_m = square_m;
  const auto colon = text.find(':');
  const auto cross = text.find('x', colon == std::string::npos ? 0 : colon);
  static const std::map<std::string, BoardPattern> patterns{{"chessboard", BoardPattern::chessboard},
                                                            {"circles", BoardPattern::circles},
                                                            {"acircles", BoardPattern::acircles}};
  const auto pattern = patterns.find(text.substr(0, colon));
  if (colon == std::string::npos || cross == std::string::npos || pattern == patterns.end()) {
    faults.add("--board", "\"" + text + "\"",
               "chessboard:9x6 (inner corners), circles:6x6 or acircles:4x11 (centres)");
  } else {
    board.pattern = pattern->second;
    const auto columns = parse_integer(text.substr(colon + 1, cross - colon - 1));
    const auto rows = parse_integer(text.substr(cross + 1));
    constexpr long long max_points_a_side = 100;
    const long long least = board.pattern == BoardPattern::chessboard ? 3 : 2;
    for (const auto& side : {columns, rows})
      if (!side || *side < least || *side > max_points_a_side)
        faults.add("--board", "\"" + text.substr(colon + 1) + "\"",
                   fmt::format("two whole numbers from {} to {}, as in 9x6", least, max_points_a_side));
    constexpr long long least_points = 6;
    if (columns && rows && *columns > 0 && *rows > 0 && *columns * *rows < least_points)
      faults.add("--board", "\"" + text + "\"", fmt::format("at least {} points in all", least_points));
    if (faults.empty()) board.columns = static_cast<int>(*columns), board.rows = static_cast<int>(*rows);
  }
  if (!std::isfinite(square_m) || square_m <= 0)
    faults.add("--square", std::isnan(square_m) ? "nothing" : fmt::format("{}", square_m),
               "a finite number above 0 (m)");
  faults.throw_if_any();
  return board;
}

}  // namespace ballservo
