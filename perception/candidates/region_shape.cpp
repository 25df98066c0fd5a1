#include "perception/candidates/region_shape.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

constexpr double half_pi = 1.57079632679489662;
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
  const Turns angle = Turns::LinSpaced(0, static_cast<float>(half_pi * (turns - 1) / turns));
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

// Undistorted positions as a camera would see them that looks straight at the middle of the outline.
class FacingView {
 public:
  FacingView(const Eigen::Vector2d& middle, double focal_px) : focal_px_(focal_px) {
    axis_ = Eigen::Vector3d(middle.x(), middle.y(), focal_px).normalized();
    basis_ = perpendicular_basis(axis_);
  }
  Eigen::Vector2d operator()(const Eigen::Vector2d& p) const {
    const Eigen::Vector3d ray(p.x(), p.y(), focal_px_);
    return basis_.transpose() * ray * (focal_px_ / axis_.dot(ray));
  }

 private:
  double focal_px_;
  Eigen::Vector3d axis_;
  Eigen::Matrix<double, 3, 2> basis_;
};

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
  const FacingView facing(middle, focal_px);
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

}  // namespace

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

}  // namespace ballservo
