#include "perception/judgement/outline_steps.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

constexpr double two_pi = 6.283185307179586;
constexpr int least_step = 12;  // grey levels, summed over the channels: above the noise of most pictures
constexpr int most_reach = 5;   // px, to either side of the outline

// Whether two pixels before and two behind some place along the line differ by a step.
bool has_step(const cv::Mat& bgr, const Eigen::Vector2d& from, const Eigen::Vector2d& to, int places) {
  std::array<cv::Vec3i, 2 * most_reach + 4> colors;
  for (int i = 0; i < places + 3; ++i) {
    const Eigen::Vector2d at = from + (to - from) * (static_cast<double>(i) / (places + 2));
    if (!(at.minCoeff() >= 0 && at.x() <= bgr.cols - 1 && at.y() <= bgr.rows - 1)) return false;
    colors[static_cast<std::size_t>(i)] =
        bgr.at<cv::Vec3b>(static_cast<int>(at.y() + 0.5), static_cast<int>(at.x() + 0.5));
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(places); ++i) {
    const cv::Vec3i twice = colors[i] + colors[i + 1] - colors[i + 2] - colors[i + 3];
    if (std::abs(twice[0]) + std::abs(twice[1]) + std::abs(twice[2]) >= 2 * least_step) return true;
  }
  return false;
}

}  // namespace

void see_steps_in_own_color(const cv::Mat& bgr, const ColoredPixels& colored, const Camera& camera,
                            const TangentCone& cone, OutlineSectors& sectors) {
  const auto middle = camera.project(cone.axis);
  if (!middle) return;
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(cone.axis);
  for (int i = 0; i < sectors.count; ++i) {
    bool& seen = sectors.seen[static_cast<std::size_t>(i)];
    if (seen) continue;
    const double angle = two_pi * (i + 0.5) / sectors.count;
    const Eigen::Vector3d outward = basis * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const auto edge =
        camera.project(cone.axis * std::cos(cone.alpha_rad) + outward * std::sin(cone.alpha_rad));
    if (!edge) continue;
    const double radius_px = (*edge - *middle).norm();
    if (!(radius_px > 0) || !(edge->cwiseAbs().maxCoeff() < 1e6)) continue;
    const Eigen::Vector2d out = (*edge - *middle) / radius_px;
    const int reach = std::min(most_reach, 2 + static_cast<int>(0.1 * radius_px));
    const Eigen::Vector2d beyond = *edge + (reach + 1) * out;
    const int u = static_cast<int>(std::lround(beyond.x())), v = static_cast<int>(std::lround(beyond.y()));
    if (!colored.knows(u, v) || !colored.at(u, v)) continue;
    // From 1.5 px further in than the first place to 1.5 px further out than the last.
    seen = has_step(bgr, *edge - (reach + 1.5) * out, *edge + (reach + 1.5) * out, 2 * reach + 1);
  }
}

}  // namespace ballservo
