#include "perception/candidates/straight_sides.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {
namespace {

// How far (px) the flattest arc rises over its chord on the length of a side, and what still passes for none.
constexpr double arc_rise_px = 1.3, straight_rise_px = 0.6;
// Pixels of a straight side scatter by 0.29 px about it, and noise and texture roughen it.
constexpr double max_scatter_px = 0.6;
constexpr std::size_t least_points = 6;
// Along a line that is neither level nor diagonal pixels take a longer way than its length: by 8 % at most.
constexpr double way_of_pixels = 1.08;

}  // namespace

// The middle third of an arc stands out from the two outer ones by 0.444 of its rise.
bool StraightSides::is_straight(std::size_t begin, std::size_t end) const {
  const std::size_t third = (end - begin) / 3;
  const auto mean = [&](std::size_t from, std::size_t to) -> Eigen::Vector2d {
    return Eigen::Vector2d(sums_[to].x - sums_[from].x, sums_[to].y - sums_[from].y) /
           static_cast<double>(to - from);
  };
  const Eigen::Vector2d first = mean(begin, begin + third), middle = mean(begin + third, end - third),
                        last = mean(end - third, end);
  const Eigen::Vector2d chord = last - first;
  const double length = chord.norm();
  if (!(length > 0)) return false;
  const Eigen::Vector2d normal = Eigen::Vector2d(chord.y(), -chord.x()) / length;
  const double rise_px = normal.dot(middle - 0.5 * (first + last)) / 0.444;
  if (!(std::abs(rise_px) < straight_rise_px)) return false;
  // The scatter across the chord.
  const Sums &a = sums_[begin], &b = sums_[end];
  const double count = static_cast<double>(end - begin);
  const double x = (b.x - a.x) / count, y = (b.y - a.y) / count;
  const double xx = (b.xx - a.xx) / count - x * x, xy = (b.xy - a.xy) / count - x * y,
               yy = (b.yy - a.yy) / count - y * y;
  const double variance =
      normal.x() * normal.x() * xx + 2 * normal.x() * normal.y() * xy + normal.y() * normal.y() * yy;
  return variance < max_scatter_px * max_scatter_px;
}

const std::vector<char>& StraightSides::find(const std::vector<BoundaryPoint>& points) {
  straight_.assign(points.size(), 0);
  sums_.assign(points.size() + 1, {});
  path_px_.assign(points.size(), 0);
  if (points.empty()) return straight_;
  Eigen::Vector2f low = points[0].position_px, high = low;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2f& p = points[i].position_px;
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
    // About the first point, so that the squares stay small.
    const Eigen::Vector2d d = (p - points[0].position_px).cast<double>();
    const Sums& s = sums_[i];
    sums_[i + 1] = {s.x + d.x(), s.y + d.y(), s.xx + d.x() * d.x(), s.xy + d.x() * d.y(),
                    s.yy + d.y() * d.y()};
    if (i > 0) path_px_[i] = path_px_[i - 1] + static_cast<double>((p - points[i - 1].position_px).norm());
  }
  const double size_px = static_cast<double>((high - low).maxCoeff());
  const double way_px = way_of_pixels * std::sqrt(8 * arc_rise_px * size_px);
  std::size_t marked = 0;  // all points before it that lie on a side are
  for (std::size_t begin = 0, end = 0; begin < points.size(); ++begin) {
    end = std::max(end, begin);
    while (end < points.size() && path_px_[end] - path_px_[begin] < way_px) ++end;
    if (end == points.size()) break;
    if (end + 1 - begin < least_points || !is_straight(begin, end + 1)) continue;
    for (marked = std::max(marked, begin); marked <= end; ++marked) straight_[marked] = 1;
  }
  return straight_;
}

}  // namespace ballservo
