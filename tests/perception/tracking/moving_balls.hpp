// Two balls of one colour on their way past each other, painted shaded and with noise.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>

#include "calibration/base/random.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo::test {

/// A ball under constant acceleration, seen from the camera.
struct MovingBall {
  Eigen::Vector3d p_C, velocity_mps, acceleration_mps2;

  Eigen::Vector3d at(double time_s) const {
    return p_C + time_s * velocity_mps + 0.5 * time_s * time_s * acceleration_mps2;
  }
};

/// How two balls meet.
enum class Meeting {
  gap,    ///< they pass beside each other, nearly touching at the closest
  hiding  ///< one passes in front of the other and hides it for a while
};

/// Two balls that are nearest to each other in the picture `meet_s` after the start.
inline std::array<MovingBall, 2> meeting_balls(Meeting meeting, double radius_m, double meet_s,
                                               RandomEngine& engine) {
  const double angle = uniform(engine, 0, 6.283185307179586);
  const Eigen::Vector3d middle(uniform(engine, -0.05, 0.05), uniform(engine, -0.05, 0.05), 1.2);
  // In the picture the second moves at another angle and pace than the first.
  const double turn = uniform(engine, 0.7, 5.58);
  const auto heading = [](double rad) { return Eigen::Vector3d(std::cos(rad), std::sin(rad), 0); };
  std::array<Eigen::Vector3d, 2> velocities{uniform(engine, 0.15, 0.4) * heading(angle),
                                            uniform(engine, 0.15, 0.4) * heading(angle + turn)};
  const Eigen::Vector3d relative = velocities[1] - velocities[0];
  const Eigen::Vector3d aside = Eigen::Vector3d(-relative.y(), relative.x(), 0).normalized();
  const double apart = meeting == Meeting::gap ? uniform(engine, 2.1, 2.8) : uniform(engine, 0, 0.8);
  const double behind_m = meeting == Meeting::gap ? uniform(engine, -0.05, 0.05) : uniform(engine, 0.15, 0.4);
  std::array<MovingBall, 2> balls;
  for (std::size_t i = 0; i < 2; ++i) {
    const Eigen::Vector3d acceleration = uniform(engine, 0, 0.3) * heading(uniform(engine, 0, 6.28));
    velocities[i].z() = uniform(engine, -0.1, 0.1);
    Eigen::Vector3d at_meeting = middle;
    if (i == 1) at_meeting += apart * radius_m * aside;
    if (i == 1) at_meeting *= (middle.z() + behind_m) / middle.z();
    // Back from the meeting to the start.
    const Eigen::Vector3d start_velocity = velocities[i] - meet_s * acceleration;
    balls[i] = {at_meeting - meet_s * start_velocity - 0.5 * meet_s * meet_s * acceleration, start_velocity,
                acceleration};
  }
  return balls;
}

/// Paints a ball lit from the upper left, 4x4 samples a pixel, over what is there.
inline void paint_shaded_ball(cv::Mat& bgr, const Camera& camera, const Eigen::Vector3d& p_C, double radius_m,
                              const cv::Vec3b& color) {
  const Eigen::Vector3d to_light = Eigen::Vector3d(-0.4, -0.7, -0.6).normalized();
  const auto center = camera.project(p_C);
  if (!center) return;
  constexpr int n = 4;
  const double reach = 1.3 * camera.focal_px() * radius_m / p_C.z() + 2;
  const int left = std::max(0, static_cast<int>(center->x() - reach)),
            right = std::min(bgr.cols - 1, static_cast<int>(center->x() + reach));
  const int top = std::max(0, static_cast<int>(center->y() - reach)),
            bottom = std::min(bgr.rows - 1, static_cast<int>(center->y() + reach));
  for (int v = top; v <= bottom; ++v) {
    for (int u = left; u <= right; ++u) {
      double covered = 0, light = 0;
      for (int i = 0; i < n * n; ++i) {
        const auto ray = camera.unproject({u - 0.5 + (i % n + 0.5) / n, v - 0.5 + (i / n + 0.5) / n});
        const double along = ray->dot(p_C), root = along * along - p_C.squaredNorm() + radius_m * radius_m;
        if (root < 0) continue;
        const Eigen::Vector3d normal = ((along - std::sqrt(root)) * *ray - p_C) / radius_m;
        covered += 1;
        light += 0.6 + 0.4 * std::max(0.0, normal.dot(to_light));
      }
      cv::Vec3b& at = bgr.at<cv::Vec3b>(v, u);
      for (int c = 0; c < 3; ++c)
        at[c] = cv::saturate_cast<std::uint8_t>(at[c] + (light * color[c] - covered * at[c]) / (n * n));
    }
  }
}

/// The picture of balls at that time, the nearer ones in front.
inline cv::Mat picture_of(const Camera& camera, const std::array<MovingBall, 2>& balls, double time_s,
                          double radius_m, RandomEngine& engine) {
  cv::Mat bgr = grey_picture(camera.size().width_px, camera.size().height_px);
  std::array<Eigen::Vector3d, 2> places{balls[0].at(time_s), balls[1].at(time_s)};
  if (places[0].z() < places[1].z()) std::swap(places[0], places[1]);
  for (const Eigen::Vector3d& p_C : places) paint_shaded_ball(bgr, camera, p_C, radius_m, red);
  add_noise(bgr, 2, engine);
  return bgr;
}

}  // namespace ballservo::test
