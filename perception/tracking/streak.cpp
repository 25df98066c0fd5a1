#include "perception/tracking/streak.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "perception/outline/cone_fit.hpp"

namespace ballservo {
namespace {

// A streak is sampled on lines across it, the outermost samples of which show the background.
constexpr int lines = 61, samples = 25, background_samples = 3;
// Half the width of what is sampled, at first and when the place is known, and how far beyond the ends it
// reaches, in ball radii.
constexpr double first_half_width = 2.4, half_width = 1.7, beyond_ends = 2;
constexpr int rounds = 5;
// What covers less, of the most that the streak covers, is noise.
constexpr double least_share = 0.1;
// A ball that moved less, in radii, has an outline that can be fitted.
constexpr double least_way = 0.7;
// Tolerances of a known ball's streak.
constexpr double least_explained = 0.8, most_log_size = 0.25, least_turn_cos = 0.85, most_way_ratio = 1.3;
// Sigmas of a streak's place and width, as shares of its own extents (root mean square).
constexpr double sigma_share = 0.1;

Eigen::Vector2d unit_or_x(const Eigen::Vector2d& way) {
  return way.squaredNorm() > 1e-12 ? way.normalized() : Eigen::Vector2d::UnitX();
}

Eigen::Vector2d across(const Eigen::Vector2d& along) { return {-along.y(), along.x()}; }

Eigen::Vector3d light_of(const CameraResponse& response, const cv::Vec3b& bgr) {
  return Eigen::Vector3f(response.light[bgr[0]], response.light[bgr[1]], response.light[bgr[2]])
      .cast<double>();
}

// Calls `visit(along_px, across_px, difference, contrast)` for each sample: how its light differs from the
// background's, and how the ball's does. False where a sample lies outside the picture.
template <class Visit>
bool sample(const cv::Mat& bgr, const CameraResponse& response, const Eigen::Vector3d& ball,
            const Streak& streak, double half_width_radii, const Visit& visit) {
  const Eigen::Vector2d along = unit_or_x(streak.way_px);
  const double half_along = streak.way_px.norm() / 2 + beyond_ends * streak.half_width_px;
  const double half_across = half_width_radii * streak.half_width_px;
  Eigen::Vector3d light[samples];
  for (int line = 0; line < lines; ++line) {
    const double u = half_along * (2.0 * line / (lines - 1) - 1);
    const auto across_px = [&](int i) { return half_across * (2.0 * i / (samples - 1) - 1); };
    Eigen::Vector3d sides[2] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
    for (int i = 0; i < samples; ++i) {
      const Eigen::Vector2d at = streak.center_px + u * along + across_px(i) * across(along);
      const int column = static_cast<int>(std::lround(at.x())), row = static_cast<int>(std::lround(at.y()));
      if (column < 0 || row < 0 || column >= bgr.cols || row >= bgr.rows) return false;
      light[i] = light_of(response, bgr.at<cv::Vec3b>(row, column));
      if (i < background_samples) sides[0] += light[i] / background_samples;
      if (i >= samples - background_samples) sides[1] += light[i] / background_samples;
    }
    for (int i = 0; i < samples; ++i) {
      const double share = static_cast<double>(i) / (samples - 1);
      const Eigen::Vector3d background = (1 - share) * sides[0] + share * sides[1];
      visit(u, across_px(i), light[i] - background, ball - background);
    }
  }
  return true;
}

// For what part of the exposure a disc covers a place beside the middle of its way.
double covered(double along_px, double across_px, double way_px, double radius_px) {
  if (std::abs(across_px) >= radius_px) return 0;
  const double half_chord = std::sqrt(radius_px * radius_px - across_px * across_px);
  const double from = std::max(along_px - half_chord, -way_px / 2),
               to = std::min(along_px + half_chord, way_px / 2);
  return std::clamp((to - from) / std::max(way_px, 1e-9), 0.0, 1.0);
}

}  // namespace

std::optional<Streak> measure_streak(const cv::Mat& bgr, const CameraResponse& response,
                                     const Eigen::Vector3d& ball_bgr, const Streak& expected) {
  const Eigen::Vector3d ball = light_of(
      response, {cv::saturate_cast<std::uint8_t>(ball_bgr.x()), cv::saturate_cast<std::uint8_t>(ball_bgr.y()),
                 cv::saturate_cast<std::uint8_t>(ball_bgr.z())});
  Streak streak = expected;
  for (int round = 0; round < rounds; ++round) {
    const double most = std::min(1.0, 2 * streak.half_width_px / std::max(streak.way_px.norm(), 1e-9));
    double sum = 0;
    Eigen::Vector2d first = Eigen::Vector2d::Zero();
    Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
    const bool is_inside =
        sample(bgr, response, ball, streak, round == 0 ? first_half_width : half_width,
               [&](double u, double v, const Eigen::Vector3d& difference, const Eigen::Vector3d& contrast) {
                 const double part = std::min(difference.dot(contrast) / contrast.squaredNorm(), 1.0);
                 if (!(part > least_share * most)) return;
                 const Eigen::Vector2d at(u, v);
                 sum += part;
                 first += part * at;
                 second += part * at * at.transpose();
               });
    if (!is_inside || !(sum > 0)) return std::nullopt;
    first /= sum;
    second = second / sum - first * first.transpose();
    const Eigen::Vector2d along = unit_or_x(streak.way_px);
    Eigen::Matrix2d axes;
    axes << along, across(along);
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> extents;
    extents.computeDirect(second);
    // A disc's variance is r^2/4 in every direction, a line's L^2/12 along it.
    const Eigen::Vector2d variances = extents.eigenvalues().cwiseMax(1e-6);
    streak.center_px += axes * first;
    streak.way_px = axes * extents.eigenvectors().col(1) * std::sqrt(12 * (variances.y() - variances.x()));
    streak.half_width_px = 2 * std::sqrt(variances.x());
    if (!(std::abs(std::log(streak.half_width_px / expected.half_width_px)) < 1)) return std::nullopt;
  }
  double all = 0, left = 0;
  const bool is_inside =
      sample(bgr, response, ball, streak, half_width,
             [&](double u, double v, const Eigen::Vector3d& difference, const Eigen::Vector3d& contrast) {
               const double part = covered(u, v, streak.way_px.norm(), streak.half_width_px);
               all += difference.squaredNorm();
               left += (difference - part * contrast).squaredNorm();
             });
  if (!is_inside) return std::nullopt;
  streak.explained = all > 0 ? 1 - left / all : 0;
  return streak;
}

std::optional<BallObservation> find_streak(const cv::Mat& bgr, const Camera& camera,
                                           const CameraResponse& response, const Eigen::Vector3d& ball_bgr,
                                           const Streak& expected, const BallRadius& radius) {
  const auto streak = measure_streak(bgr, response, ball_bgr, expected);
  if (!streak || streak->explained < least_explained) return std::nullopt;
  const double way_px = streak->way_px.norm(), radius_px = streak->half_width_px;
  const Eigen::Vector2d along = unit_or_x(streak->way_px);
  const bool is_the_ball = std::abs(std::log(radius_px / expected.half_width_px)) < most_log_size &&
                           way_px > least_way * radius_px &&
                           way_px < most_way_ratio * expected.way_px.norm() + expected.half_width_px &&
                           std::abs(along.dot(unit_or_x(expected.way_px))) > least_turn_cos;
  const auto axis = camera.unproject(streak->center_px);
  const auto end = camera.unproject(streak->center_px + radius_px * along),
             side = camera.unproject(streak->center_px + radius_px * across(along));
  if (!is_the_ball || !axis || !end || !side) return std::nullopt;
  const double along_rad = std::asin((*end - *axis).norm()), alpha_rad = std::asin((*side - *axis).norm());
  // Of the turns along and across, and of the angular radius.
  const double stretched = std::sqrt(1 + way_px * way_px / (3 * radius_px * radius_px));
  const Eigen::Vector3d sigma(sigma_share / 2 * stretched * along_rad, sigma_share / 2 * alpha_rad,
                              sigma_share * alpha_rad);
  Eigen::Matrix3d turns = Eigen::Matrix3d::Identity();
  turns.topLeftCorner<2, 1>() = (perpendicular_basis(*axis).transpose() * (*end - *axis)).normalized();
  turns.topLeftCorner<2, 2>().col(1) = across(turns.topLeftCorner<2, 1>());
  ConeFit fit;
  fit.cone = {*axis, alpha_rad};
  fit.covariance_rad2 = turns * sigma.cwiseAbs2().asDiagonal() * turns.transpose();
  BallObservation ball;
  ball.outline = {streak->center_px, radius_px};
  ball.cone = fit.cone;
  ball.cone_covariance_rad2 = fit.covariance_rad2;
  if (radius.radius_m > 0)
    ball.position = {fit.cone.center(radius.radius_m),
                     center_covariance(fit, radius.radius_m, radius.sigma_m)};
  ball.quality = streak->explained;
  return ball;
}

}  // namespace ballservo
