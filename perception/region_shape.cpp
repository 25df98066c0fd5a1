#include "perception/region_shape.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

constexpr double half_pi = 1.57079632679489662;
// The outline of a smaller thing may be any; a disc of a few pixels may fill its box.
constexpr std::size_t least_outline_px = 16, least_box_outline_px = 40;
constexpr int turns = 12;
// Pixels scatter by 0.29 px about a smooth outline. A ball smeared by its own motion is longer than broad
// too, but rarely so much.
constexpr double smooth_residual_px = 0.4, least_axis_ratio = 0.8;
// Above what fills a disc, or what a straight edge leaves of it: 0.79 at most.
constexpr double most_box_fill = 0.87;

double box_fill(const std::vector<BoundaryPixel>& outline, int pixels) {
  double least_px2 = std::numeric_limits<double>::infinity();
  for (int k = 0; k < turns; ++k) {
    const double angle = half_pi * k / turns;
    const auto cosine = static_cast<float>(std::cos(angle)), sine = static_cast<float>(std::sin(angle));
    Eigen::Array2f low = Eigen::Array2f::Constant(std::numeric_limits<float>::infinity()), high = -low;
    for (const BoundaryPixel& pixel : outline) {
      const auto u = static_cast<float>(pixel.u_px), v = static_cast<float>(pixel.v_px);
      const Eigen::Array2f turned(cosine * u + sine * v, cosine * v - sine * u);
      low = low.min(turned);
      high = high.max(turned);
    }
    least_px2 = std::min(least_px2, static_cast<double>((high - low + 1).prod()));
  }
  return pixels / least_px2;
}

// Undistorted positions as a camera would see them that looks straight at the middle of the outline.
class FacingView {
 public:
  FacingView(const std::vector<BoundaryPoint>& points, double focal_px) : focal_px_(focal_px) {
    Eigen::Vector2d middle(0, 0);
    for (const BoundaryPoint& point : points) middle += point.position_px.cast<double>();
    middle /= static_cast<double>(points.size());
    axis_ = Eigen::Vector3d(middle.x(), middle.y(), focal_px).normalized();
    basis_ = perpendicular_basis(axis_);
  }
  Eigen::Vector2d operator()(const BoundaryPoint& point) const {
    const Eigen::Vector2d p = point.position_px.cast<double>();
    const Eigen::Vector3d ray(p.x(), p.y(), focal_px_);
    return basis_.transpose() * ray * (focal_px_ / axis_.dot(ray));
  }

 private:
  double focal_px_;
  Eigen::Vector3d axis_;
  Eigen::Matrix<double, 3, 2> basis_;
};

// a x^2 + b xy + c y^2 + d x + e y = 1, by least squares of that equation.
using Conic = Eigen::Matrix<double, 5, 1>;

Conic conic_row(const Eigen::Vector2d& p) {
  return (Conic() << p.x() * p.x(), p.x() * p.y(), p.y() * p.y(), p.x(), p.y()).finished();
}

}  // namespace

RegionShape region_shape(const std::vector<BoundaryPixel>& outline, const std::vector<BoundaryPoint>& points,
                         int pixels, double focal_px) {
  RegionShape shape;
  if (points.size() < least_outline_px) return shape;
  if (outline.size() >= least_box_outline_px) shape.box_fill = box_fill(outline, pixels);

  const FacingView seen(points, focal_px);
  double size_px = 0;  // the equations are of numbers about 1
  for (const BoundaryPoint& point : points) size_px = std::max(size_px, seen(point).norm());
  Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
  Conic right = Conic::Zero();
  for (const BoundaryPoint& point : points) {
    const Conic row = conic_row(seen(point) / size_px);
    normal += row * row.transpose();
    right += row;
  }
  const Conic conic = normal.ldlt().solve(right);
  const Eigen::Matrix2d quadratic =
      (Eigen::Matrix2d() << conic(0), 0.5 * conic(1), 0.5 * conic(1), conic(2)).finished();
  const Eigen::Vector2d values =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(quadratic, Eigen::EigenvaluesOnly).eigenvalues();
  if (!(values(0) > 0) || !conic.allFinite()) return shape;  // no ellipse
  double squares = 0;
  for (const BoundaryPoint& point : points) {
    const Eigen::Vector2d p = seen(point) / size_px;
    const Eigen::Vector2d slope = 2 * quadratic * p + conic.tail<2>();
    const double distance = (conic_row(p).dot(conic) - 1) / slope.norm();  // to first order (Sampson)
    squares += distance * distance;
  }
  shape.axis_ratio = std::sqrt(values(0) / values(1));
  shape.ellipse_residual_px = size_px * std::sqrt(squares / static_cast<double>(points.size()));
  return shape;
}

bool is_no_balls(const RegionShape& shape) {
  return shape.box_fill > most_box_fill ||
         (shape.axis_ratio < least_axis_ratio && shape.ellipse_residual_px < smooth_residual_px);
}

}  // namespace ballservo
