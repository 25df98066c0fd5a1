#include "perception/candidates/region_outline.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

struct Move {
  int du, dv;
};

// A pixel that shares an edge comes before one that shares a corner: else it would be left behind.
constexpr std::array<Move, 8> moves{Move{1, 0}, Move{0, 1},  Move{-1, 0},  Move{0, -1},
                                    Move{1, 1}, Move{-1, 1}, Move{-1, -1}, Move{1, -1}};

// How far (px) the flattest arc rises over its chord on the length of a side, and what still passes for none.
constexpr double arc_rise_px = 1.3, straight_rise_px = 0.6;
// Pixels of a straight side scatter by 0.29 px about it, and noise and texture roughen it.
constexpr double max_scatter_px = 0.6;
constexpr std::size_t least_points = 6;
// Along a line that is neither level nor diagonal pixels take a longer way than its length: by 8 % at most.
constexpr double way_of_pixels = 1.08;

// The outline of a smaller thing may be any; one of under 5 px radius may fill its box.
constexpr std::size_t least_outline_px = 16, least_box_outline_px = 28;
constexpr int turns = 12;
constexpr std::size_t most_points = 64;  // for the ellipse: enough
// Pixels scatter by 0.29 px about a smooth outline. A ball smeared by its own motion is longer than broad
// too, but rarely so much.
constexpr double smooth_residual_px = 0.4, least_axis_ratio = 0.82;
// Above what fills a disc, or what a straight edge leaves of it: 0.79 at most.
constexpr double most_box_fill = 0.87;

// All turns of the rectangle at once.
double box_fill(const std::vector<BoundaryPixel>& outline, int pixels) {
  using Turns = Eigen::Array<float, turns, 1>;
  const Turns angle = Turns::LinSpaced(0, static_cast<float>(M_PI / 2 * (turns - 1) / turns));
  const Turns cosine = angle.cos(), sine = angle.sin();
  constexpr float far = 1e6f;
  Turns left = Turns::Constant(far), right = -left, top = left, bottom = -left;
  for (const BoundaryPixel& pixel : outline) {
    const auto u = static_cast<float>(pixel.u_px), v = static_cast<float>(pixel.v_px);
    const Turns along = u * cosine + v * sine, across = v * cosine - u * sine;
    left = left.min(along);
    right = right.max(along);
    top = top.min(across);
    bottom = bottom.max(across);
  }
  return pixels / static_cast<double>(((right - left + 1) * (bottom - top + 1)).minCoeff());
}

// a x^2 + b xy + c y^2 + d x + e y = 1.
using Conic = Eigen::Matrix<double, 5, 1>;

Conic conic_row(const Eigen::Vector2d& p) {
  return (Conic() << p.x() * p.x(), p.x() * p.y(), p.y() * p.y(), p.x(), p.y()).finished();
}

// By least squares of the conic's equation.
void fit_ellipse(const std::vector<BoundaryPoint>& points, double focal_px, RegionShape& shape) {
  const std::size_t stride = (points.size() + most_points - 1) / most_points;
  std::array<Eigen::Vector2d, most_points> seen;
  std::size_t count = 0;
  for (std::size_t i = 0; i < points.size(); i += stride)
    seen[count++] = points[i].position_px.cast<double>();
  const auto begin = seen.begin(), end = begin + static_cast<std::ptrdiff_t>(count);
  const Eigen::Vector2d middle =
      std::accumulate(begin, end, Eigen::Vector2d(0, 0)) / static_cast<double>(count);
  // As a camera would see them that looks straight at the middle of the outline.
  const Eigen::Vector3d axis = Eigen::Vector3d(middle.x(), middle.y(), focal_px).normalized();
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(axis);
  const auto facing = [&](const Eigen::Vector2d& p) -> Eigen::Vector2d {
    const Eigen::Vector3d ray(p.x(), p.y(), focal_px);
    return basis.transpose() * ray * (focal_px / axis.dot(ray));
  };
  double size_px = 0;  // the equations are of numbers about 1
  std::for_each(begin, end, [&](Eigen::Vector2d& p) { size_px = std::max(size_px, (p = facing(p)).norm()); });

  Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
  Conic right = Conic::Zero();
  std::for_each(begin, end, [&](Eigen::Vector2d& p) {
    const Conic row = conic_row(p /= size_px);
    normal += row * row.transpose();
    right += row;
  });
  const Conic conic = normal.ldlt().solve(right);
  const Eigen::Matrix2d quadratic =
      (Eigen::Matrix2d() << conic(0), 0.5 * conic(1), 0.5 * conic(1), conic(2)).finished();
  const Eigen::Vector2d values =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(quadratic, Eigen::EigenvaluesOnly).eigenvalues();
  if (!(values(0) > 0) || !conic.allFinite()) return;  // no ellipse
  double squares = 0;
  std::for_each(begin, end, [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d slope = 2 * quadratic * p + conic.tail<2>();
    const double distance = (conic_row(p).dot(conic) - 1) / slope.norm();  // to first order (Sampson)
    squares += distance * distance;
  });
  shape.axis_ratio = std::sqrt(values(0) / values(1));
  shape.ellipse_residual_px = size_px * std::sqrt(squares / static_cast<double>(count));
}

constexpr std::size_t max_points = 256;

}  // namespace

void BoundaryChain::order(std::vector<BoundaryPixel>& boundary, cv::Size size) {
  waiting_.resize(size);
  for (const BoundaryPixel& p : boundary) waiting_.fill(p.v_px, p.u_px, p.u_px + 1, true);
  ordered_.clear();
  ordered_.reserve(boundary.capacity());  // they are swapped: neither shall grow again
  for (const BoundaryPixel& first : boundary) {
    if (!waiting_.at(first.u_px, first.v_px)) continue;
    int u = first.u_px, v = first.v_px;
    while (true) {
      waiting_.fill(v, u, u + 1, false);
      ordered_.push_back({u, v, {0, 0}});
      const auto move = std::find_if(moves.begin(), moves.end(),
                                     [&](const Move& to) { return waiting_.at(u + to.du, v + to.dv); });
      if (move == moves.end()) break;
      u += move->du;
      v += move->dv;
    }
  }
  boundary.swap(ordered_);
}

// The middle third of an arc stands out from the two outer ones by 0.444 of its rise.
bool StraightSides::is_straight(std::size_t begin, std::size_t end) const {
  const std::size_t third = (end - begin) / 3;
  const auto mean = [&](std::size_t from, std::size_t to) -> Eigen::Vector2d {
    return (sums_[to].place - sums_[from].place) / static_cast<double>(to - from);
  };
  const Eigen::Vector2d first = mean(begin, begin + third), middle = mean(begin + third, end - third),
                        last = mean(end - third, end);
  const Eigen::Vector2d chord = last - first;
  const double length = chord.norm();
  if (!(length > 0)) return false;
  const Eigen::Vector2d normal = Eigen::Vector2d(chord.y(), -chord.x()) / length;
  const double rise_px = normal.dot(middle - 0.5 * (first + last)) / 0.444;
  if (!(std::abs(rise_px) < straight_rise_px)) return false;
  const Eigen::Vector2d center = mean(begin, end);
  const Eigen::Matrix2d scatter =
      (sums_[end].square - sums_[begin].square) / static_cast<double>(end - begin) -
      center * center.transpose();
  return normal.dot(scatter * normal) < max_scatter_px * max_scatter_px;  // across the chord
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
    sums_[i + 1] = {sums_[i].place + d, sums_[i].square + d * d.transpose()};
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

RegionShape region_shape(const std::vector<BoundaryPixel>& outline, const std::vector<BoundaryPoint>& points,
                         int pixels, double focal_px) {
  RegionShape shape;
  if (points.size() >= least_outline_px) fit_ellipse(points, focal_px, shape);
  if (outline.size() >= least_box_outline_px) shape.box_fill = box_fill(outline, pixels);
  return shape;
}

bool is_no_balls(const RegionShape& shape) {
  if (shape.ellipse_residual_px < smooth_residual_px) return shape.axis_ratio < least_axis_ratio;
  return shape.box_fill > most_box_fill;
}

const RegionOutline& OutlineTracer::trace(const RegionMap& regions, int region_index, const cv::Point& window,
                                          const RayTable& rays) {
  auto& [points, pixels] = outline_;
  const Region& region = regions.regions()[static_cast<std::size_t>(region_index)];
  const BitPicture& colored = regions.pixels_of(region.color_class);
  regions.boundary(region_index, boundary_);
  chain_.order(boundary_, colored.size());
  const std::size_t stride = (boundary_.size() + max_points - 1) / max_points;
  outline_.clear();
  for (std::size_t i = 0; i < boundary_.size(); i += stride) {
    const BoundaryPixel& pixel = boundary_[i];
    const auto position = rays.undistorted_px(pixel.u_px + window.x, pixel.v_px + window.y);
    if (!position) continue;
    points.push_back({*position, {0, 0}});
    pixels.push_back(pixel);
  }
  // The picture's border cuts every shape.
  if (!region.touches_border &&
      is_no_balls(region_shape(pixels, points, region.pixels, rays.camera().focal_px()))) {
    outline_.clear();
    return outline_;
  }
  const std::vector<char>& straight = sides_.find(points);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (straight[i]) continue;
    const BoundaryPixel pixel = pixels[i];
    const Eigen::Vector2f outward = outward_normal(colored, pixel);
    points[kept] = {points[i].position_px + 0.5f * outward, outward};
    pixels[kept++] = {pixel.u_px + window.x, pixel.v_px + window.y, outward};
  }
  outline_.resize(kept);
  return outline_;
}

}  // namespace ballservo
