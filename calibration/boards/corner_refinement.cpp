#include "calibration/boards/corner_refinement.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace ballservo {
namespace {

constexpr double window_squares = 0.4;  // to each side: the next edges are 1 away, and blurred too
constexpr int rounds = 2;               // better corners give better curvatures
// A pixel's area blurs by itself; less, and an edge between two columns of pixels has no place.
constexpr double least_blur_px = 0.15;

/// A row or column of the board through one corner: derivatives per square, to second order.
struct BoardLine {
  Eigen::Vector2d slope_px, bend_px;
};

/// From up to five neighbours, the polynomial through them (Lagrange): a wide lens bends so much near its rim
/// that a parabola does not do. `point(i)` for i in [0, count).
template <class Point>
BoardLine line_at(int at, int count, const Point& point) {
  const int used = std::min(count, 5), from = std::clamp(at - 2, 0, count - used);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 5, 5> powers(used, used);
  Eigen::Matrix<double, Eigen::Dynamic, 2, 0, 5, 2> places(used, 2);
  for (int k = 0; k < used; ++k) {
    powers(k, 0) = 1;
    for (int order = 1; order < used; ++order) powers(k, order) = powers(k, order - 1) * (from + k - at);
    places.row(k) = point(from + k);
  }
  const auto solution = powers.partialPivLu().solve(places).eval();
  return {solution.row(1), 2 * solution.row(2)};
}

/// One of the two edges that cross. Its blur's sigma is that beyond the least.
struct Edge {
  double direction_rad, curvature_per_px, more_blur_px;
};

Edge edge_along(const BoardLine& line) {
  const double direction_rad = std::atan2(line.slope_px.y(), line.slope_px.x());
  const Eigen::Vector2d normal(-std::sin(direction_rad), std::cos(direction_rad));
  return {direction_rad, normal.dot(line.bend_px) / line.slope_px.squaredNorm(), 0.7};
}

/// erf(d / (sqrt(2) sigma)) at a point and its derivatives.
struct EdgeStep {
  double value = 0, by_direction = 0, by_more_blur = 0;
  Eigen::Vector2d by_crossing{0, 0};
};

/// The edge as a parabola through the crossing; the point given from there (px).
class EdgeModel {
 public:
  explicit EdgeModel(const Edge& edge)
      : tangent_(std::cos(edge.direction_rad), std::sin(edge.direction_rad)),
        normal_(-tangent_.y(), tangent_.x()),
        curvature_per_px_(edge.curvature_per_px),
        blur_px_(std::hypot(least_blur_px, edge.more_blur_px)),
        more_blur_px_(edge.more_blur_px) {}

  EdgeStep at(const Eigen::Vector2d& point_px) const {
    constexpr double flat = 4, two_over_root_pi = 1.1283791670955126;  // erf(4) = 1 - 1.5e-8
    const double width_px = std::sqrt(2.0) * blur_px_;
    const double along = tangent_.dot(point_px), across = normal_.dot(point_px);
    const double slope = curvature_per_px_ * along;
    const double t = (across - 0.5 * slope * along) / width_px;
    EdgeStep step;
    if (std::abs(t) > flat) {
      step.value = t > 0 ? 1 : -1;
      return step;
    }
    const double rise_per_px = two_over_root_pi * std::exp(-t * t) / width_px;
    step.value = std::erf(t);
    step.by_direction = -rise_per_px * (along + slope * across);
    step.by_more_blur = -rise_per_px * t * width_px * more_blur_px_ / (blur_px_ * blur_px_);
    step.by_crossing = rise_per_px * (slope * tangent_ - normal_);
    return step;
  }

 private:
  Eigen::Vector2d tangent_, normal_;
  double curvature_per_px_, blur_px_, more_blur_px_;
};

struct Crossing {
  Eigen::Vector2d at_px;
  Edge first, second;
  double mean, contrast;
  Eigen::Vector2d gradient_per_px{0, 0};
};

constexpr int unknowns = 10;  // in the order of Crossing
using Unknowns = Eigen::Matrix<double, unknowns, 1>;

struct Pixel {
  Eigen::Vector2d at_px;
  double level;
};

struct NormalEquations {
  Eigen::Matrix<double, unknowns, unknowns> matrix = Eigen::Matrix<double, unknowns, unknowns>::Zero();
  Unknowns right = Unknowns::Zero();
  double squares = 0;  ///< sum of the squared errors (levels^2)
};

NormalEquations linearised(const std::vector<Pixel>& pixels, const Crossing& crossing) {
  // Gauss and Legendre's three points a side average over a pixel's area.
  constexpr std::array<double, 3> places_px{-0.3872983346207417, 0, 0.3872983346207417};
  constexpr std::array<double, 3> weights{5 / 18.0, 8 / 18.0, 5 / 18.0};
  const EdgeModel first(crossing.first), second(crossing.second);
  NormalEquations result;
  for (const Pixel& pixel : pixels) {
    const Eigen::Vector2d from_crossing = pixel.at_px - crossing.at_px;
    double sign = 0;
    Unknowns row = Unknowns::Zero();
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t i = 0; i < 3; ++i) {
        const Eigen::Vector2d point = from_crossing + Eigen::Vector2d(places_px[i], places_px[j]);
        const EdgeStep a = first.at(point), b = second.at(point);
        const double weight = weights[i] * weights[j], scale = weight * crossing.contrast;
        row.head<2>() += scale * (b.value * a.by_crossing + a.value * b.by_crossing);
        row(2) += scale * a.by_direction * b.value;
        row(3) += scale * a.by_more_blur * b.value;
        row(4) += scale * a.value * b.by_direction;
        row(5) += scale * a.value * b.by_more_blur;
        sign += weight * a.value * b.value;
      }
    }
    row.head<2>() -= crossing.gradient_per_px;
    row(6) = 1, row(7) = sign;
    row.tail<2>() = from_crossing;
    const double error =
        pixel.level - crossing.mean - crossing.contrast * sign - crossing.gradient_per_px.dot(from_crossing);
    result.matrix.noalias() += row * row.transpose();
    result.right += error * row;
    result.squares += error * error;
  }
  return result;
}

Crossing moved(Crossing crossing, const Unknowns& step) {
  crossing.at_px += step.head<2>();
  crossing.first.direction_rad += step(2);
  crossing.first.more_blur_px += step(3);
  crossing.second.direction_rad += step(4);
  crossing.second.more_blur_px += step(5);
  crossing.mean += step(6), crossing.contrast += step(7);
  crossing.gradient_per_px += step.tail<2>();
  return crossing;
}

/// The least-squares crossing; nothing where the iteration does not end, or what is found is none: what
/// differs from the model by a third of its contrast is another thing.
std::optional<Crossing> fitted(const std::vector<Pixel>& pixels, Crossing crossing) {
  constexpr int max_steps = 40;
  constexpr double small_step_px = 2e-4, most_damping = 1e4, least_contrast = 2, most_misfit = 0.35;
  NormalEquations equations = linearised(pixels, crossing);
  bool done = false;
  double damping = 1e-3;
  for (int i = 0; i < max_steps && !done; ++i) {
    auto damped = equations.matrix;
    damped.diagonal() = (1 + damping) * damped.diagonal().array() + 1e-9;
    const Unknowns step = damped.ldlt().solve(equations.right);
    if (!step.allFinite()) return std::nullopt;
    const Crossing next = moved(crossing, step);
    const NormalEquations there = linearised(pixels, next);
    if (there.squares <= equations.squares) {
      crossing = next, equations = there;
      damping *= 0.1;
      done = step.head<2>().norm() < small_step_px;
    } else {
      damping *= 10;
      done = damping > most_damping;  // nowhere is it better
    }
  }
  const double rms = std::sqrt(equations.squares / static_cast<double>(pixels.size()));
  const double contrast = std::abs(crossing.contrast);
  if (!done || contrast < least_contrast || rms > most_misfit * contrast) return std::nullopt;
  return crossing;
}

/// The pixels within the window's part of the squares around a corner, as far as the picture goes.
std::vector<Pixel> window(const cv::Mat& gray, const Eigen::Vector2d& corner_px,
                          const Eigen::Matrix2d& px_per_square, const Eigen::Matrix2d& squares_per_px) {
  const Eigen::Vector2d reach = window_squares * px_per_square.cwiseAbs().rowwise().sum();
  const Eigen::Vector2d low = (corner_px - reach).cwiseMax(0);
  const Eigen::Vector2d high = (corner_px + reach).cwiseMin(Eigen::Vector2d(gray.cols - 1, gray.rows - 1));
  std::vector<Pixel> pixels;
  for (int v = static_cast<int>(std::ceil(low.y())); v <= high.y(); ++v) {
    for (int u = static_cast<int>(std::ceil(low.x())); u <= high.x(); ++u) {
      const Eigen::Vector2d at_px(u, v);
      if ((squares_per_px * (at_px - corner_px)).cwiseAbs().maxCoeff() <= window_squares)
        pixels.push_back({at_px, static_cast<double>(gray.at<std::uint8_t>(v, u))});
    }
  }
  return pixels;
}

/// A start for the levels: their middle, and as much contrast as agrees with the edges.
Crossing start_of(const std::vector<Pixel>& pixels, const Eigen::Vector2d& corner_px, const BoardLine& row,
                  const BoardLine& column) {
  Crossing crossing{corner_px, edge_along(row), edge_along(column), 0, 0};
  for (const Pixel& pixel : pixels) crossing.mean += pixel.level / static_cast<double>(pixels.size());
  const EdgeModel first(crossing.first), second(crossing.second);
  double product = 0, squares = 0;
  for (const Pixel& pixel : pixels) {
    const Eigen::Vector2d point = pixel.at_px - corner_px;
    const double sign = first.at(point).value * second.at(point).value;
    product += sign * (pixel.level - crossing.mean), squares += sign * sign;
  }
  crossing.contrast = product / std::max(squares, 1e-9);
  return crossing;
}

std::optional<Eigen::Vector2d> refined(const cv::Mat& gray, const Eigen::Vector2d& corner_px,
                                       const BoardLine& row, const BoardLine& column) {
  constexpr double most_motion_squares = 0.25, least_window_part = 0.55;
  Eigen::Matrix2d px_per_square;
  px_per_square << row.slope_px, column.slope_px;
  const double window_px2 = std::pow(2 * window_squares, 2) * std::abs(px_per_square.determinant());
  if (!(window_px2 > 2 * unknowns)) return std::nullopt;
  const Eigen::Matrix2d squares_per_px = px_per_square.inverse();
  const std::vector<Pixel> pixels = window(gray, corner_px, px_per_square, squares_per_px);
  if (static_cast<double>(pixels.size()) < least_window_part * window_px2) return std::nullopt;
  const auto crossing = fitted(pixels, start_of(pixels, corner_px, row, column));
  if (!crossing || !((squares_per_px * (crossing->at_px - corner_px)).norm() < most_motion_squares))
    return std::nullopt;
  return crossing->at_px;
}

}  // namespace

std::vector<std::optional<Eigen::Vector2d>> refine_corners(const cv::Mat& gray, const CornerGrid& grid) {
  std::vector<std::optional<Eigen::Vector2d>> result(grid.points.size());
  CornerGrid current = grid;
  for (int round = 0; round < rounds; ++round) {
    for (int row = 0; row < grid.rows; ++row) {
      for (int column = 0; column < grid.columns; ++column) {
        const BoardLine along_row =
            line_at(column, grid.columns, [&](int i) { return current.at(row, i).transpose(); });
        const BoardLine along_column =
            line_at(row, grid.rows, [&](int i) { return current.at(i, column).transpose(); });
        result[static_cast<std::size_t>(row * grid.columns + column)] =
            refined(gray, current.at(row, column), along_row, along_column);
      }
    }
    for (std::size_t i = 0; i < result.size(); ++i)
      if (result[i]) current.points[i] = *result[i];
  }
  return result;
}

}  // namespace ballservo
