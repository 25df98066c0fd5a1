#include "perception/outline/paper_refinement.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

constexpr double half_width_px = 2.5;  // of the ring

// Grey level as OpenCV weighs the channels (ITU-R BT.601).
double grey(const cv::Vec3b& bgr) { return 0.114 * bgr[0] + 0.587 * bgr[1] + 0.299 * bgr[2]; }

}  // namespace

void select_ring_pixels(const cv::Mat& bgr, const RayTable& rays, const UndistortedCircle& circle,
                        std::vector<RingPixel>& ring) {
  CV_Assert(bgr.type() == CV_8UC3 && bgr.cols == rays.size().width_px && bgr.rows == rays.size().height_px);
  ring.clear();
  // The circle's box in the picture as given, from its outline seen through the lens.
  const double focal = rays.camera().focal_px();
  Eigen::Array2d low(1e9, 1e9), high(-1e9, -1e9);
  for (int i = 0; i < 32; ++i) {
    const double angle = 2 * M_PI * i / 32, radius = circle.radius_px + half_width_px;
    const Eigen::Vector2d p = circle.center_px + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const auto pixel = rays.camera().project({p.x(), p.y(), focal});
    if (!pixel) continue;
    low = low.min(pixel->array());
    high = high.max(pixel->array());
  }
  const auto clamped = [](double value, int most) {
    return static_cast<int>(std::clamp(value, 1.0, static_cast<double>(most)));
  };
  if (!(low.x() <= high.x())) return;
  for (int v = clamped(low.y() - 2, bgr.rows - 1); v <= clamped(high.y() + 2, bgr.rows - 2); ++v) {
    const cv::Vec3b* above = bgr.ptr<cv::Vec3b>(v - 1);
    const cv::Vec3b* row = bgr.ptr<cv::Vec3b>(v);
    const cv::Vec3b* below = bgr.ptr<cv::Vec3b>(v + 1);
    for (int u = clamped(low.x() - 2, bgr.cols - 1); u <= clamped(high.x() + 2, bgr.cols - 2); ++u) {
      const auto position = rays.undistorted_px(u, v);
      if (!position) continue;
      const double distance = (position->cast<double>() - circle.center_px).norm();
      if (std::abs(distance - circle.radius_px) > half_width_px) continue;
      const double gu = 0.5 * (grey(row[u + 1]) - grey(row[u - 1])),
                   gv = 0.5 * (grey(below[u]) - grey(above[u]));
      ring.push_back({position->cast<double>(), gu * gu + gv * gv, u, v});
    }
  }
  const auto kept = static_cast<std::size_t>(2 * M_PI * circle.radius_px);
  if (ring.size() > kept) {
    // Ties by place, so that the choice does not depend on the algorithm.
    const auto stronger = [](const RingPixel& a, const RingPixel& b) {
      if (a.weight != b.weight) return a.weight > b.weight;
      return a.v_px != b.v_px ? a.v_px < b.v_px : a.u_px < b.u_px;
    };
    std::nth_element(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(kept), ring.end(), stronger);
    ring.resize(kept);
    std::sort(ring.begin(), ring.end(), stronger);
  }
}

std::optional<CircleFit> one_gauss_newton_step(const UndistortedCircle& start,
                                               const std::vector<RingPixel>& ring) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  CircleFit fit;
  for (const RingPixel& pixel : ring) {
    const Eigen::Vector2d offset = start.center_px - pixel.position_px;
    const double distance = offset.norm();
    if (!(distance > 0) || !(pixel.weight > 0)) continue;
    const Eigen::Vector3d row(offset.x() / distance, offset.y() / distance, -1);
    normal += pixel.weight * row * row.transpose();
    right -= pixel.weight * row * (distance - start.radius_px);
    ++fit.used;
  }
  if (fit.used < 3) return std::nullopt;
  const Eigen::LDLT<Eigen::Matrix3d> ldlt(normal);
  if (!(ldlt.vectorD().minCoeff() > 1e-9 * ldlt.vectorD().maxCoeff())) return std::nullopt;
  const Eigen::Vector3d step = ldlt.solve(right);
  if (!step.allFinite() || !(start.radius_px + step.z() > 0)) return std::nullopt;
  fit.circle = {start.center_px + step.head<2>(), start.radius_px + step.z()};
  fit.step_px = step.head<2>().norm() + std::abs(step.z());
  double squares = 0, weights = 0;
  for (const RingPixel& pixel : ring) {
    const double residual = (fit.circle.center_px - pixel.position_px).norm() - fit.circle.radius_px;
    squares += pixel.weight * residual * residual;
    weights += pixel.weight;
  }
  fit.residual_px = std::sqrt(squares / weights);
  // Pixels repeat each other across the ring's width: count one measurement per pixel of circumference.
  const double mean_weight = weights / fit.used;
  const double repeats = std::max(1.0, fit.used / (2 * M_PI * fit.circle.radius_px));
  fit.covariance_px2 = normal.inverse() * (mean_weight * fit.residual_px * fit.residual_px * repeats);
  return fit;
}

Eigen::Vector3d paper_position(const UndistortedCircle& circle, double focal_px, double radius_m) {
  const double z = radius_m * std::sqrt(1 + std::pow(focal_px / circle.radius_px, 2));
  return {circle.center_px.x() * z / focal_px, circle.center_px.y() * z / focal_px, z};
}

Eigen::Matrix3d paper_position_jacobian(const UndistortedCircle& circle, double focal_px, double radius_m) {
  const Eigen::Vector3d p = paper_position(circle, focal_px, radius_m);
  const double z_by_radius =
      -radius_m * radius_m * focal_px * focal_px / (std::pow(circle.radius_px, 3) * p.z());
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();
  jacobian(0, 0) = jacobian(1, 1) = p.z() / focal_px;
  jacobian.col(2) =
      Eigen::Vector3d(circle.center_px.x() / focal_px, circle.center_px.y() / focal_px, 1) * z_by_radius;
  return jacobian;
}

std::optional<TangentCone> cone_near_circle(const UndistortedCircle& circle, double focal_px) {
  constexpr int count = 16;
  Eigen::Matrix<double, 3, count> rays;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count;
    const Eigen::Vector2d p =
        circle.center_px + circle.radius_px * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    rays.col(i) = Eigen::Vector3d(p.x(), p.y(), focal_px).normalized();
  }
  const auto center = sphere_from_rays(rays, 1);
  return center ? TangentCone::of_sphere(*center, 1) : std::nullopt;
}

}  // namespace ballservo
