#include "calibration/ball/ball_radius.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "calibration/base/fault.hpp"
#include "calibration/base/statistics.hpp"
#include "calibration/boards/board_adjustment.hpp"
#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

constexpr double least_corner_sigma_px = 0.05;  // what any corner finder has
constexpr double most_sigmas = 4, least_tolerance = 0.01, most_outlying = 0.25;

struct PlacedBoard {
  BoardPose pose;
  Eigen::Matrix<double, 6, 6> covariance;
};

/// The pose of least squared distances in pixels, with its covariance by the corners' own scatter.
std::optional<PlacedBoard> placed(const Camera& camera, const BoardView& board) {
  const std::vector<BoardView> views{board};
  const auto start = board_poses(views, camera.parameters());
  const auto fit = start ? adjust_poses(views, camera.parameters(), *start) : std::nullopt;
  if (!fit) return std::nullopt;
  const double corners = static_cast<double>(board.size());
  const double variance = std::max(corners * std::pow(fit->rms_px, 2) / std::max(1.0, 2 * corners - 6),
                                   least_corner_sigma_px * least_corner_sigma_px);
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solver(pose_information(board, *fit, 0));
  return PlacedBoard{fit->poses.front(), variance * solver.solve(Eigen::Matrix<double, 6, 6>::Identity())};
}

/// R = e / (1 - n.c); nothing for a ball that is not on the camera's side.
std::optional<double> radius_on_plane(const Eigen::Vector3d& unit_center, const BoardPose& pose,
                                      double depth_m) {
  Eigen::Vector3d normal = board_normal(pose);
  double height_m = -normal.dot(pose.tail<3>());
  if (height_m < 0) normal = -normal, height_m = -height_m;
  const double radius_m = (height_m + depth_m) / (1 - normal.dot(unit_center));
  return std::isfinite(radius_m) && radius_m > 0 && height_m > 0 ? std::optional(radius_m) : std::nullopt;
}

/// Which readings agree with their median; Refusal where too few do.
std::vector<bool> agreeing(const std::vector<RadiusReading>& readings,
                           const std::vector<std::string>& names) {
  std::vector<double> radii;
  for (const RadiusReading& reading : readings) radii.push_back(reading.radius_m);
  const double middle_m = median(radii);
  std::vector<bool> used;
  std::string figures;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const double tolerance_m = std::max(most_sigmas * readings[i].sigma_m, least_tolerance * middle_m);
    used.push_back(std::abs(radii[i] - middle_m) <= tolerance_m);
    figures += fmt::format("\n  {}: diameter {:.5f} +- {:.5f} m{}", names[i], 2 * radii[i],
                           2 * readings[i].sigma_m, used.back() ? "" : "  <- disagrees");
  }
  const auto outlying = static_cast<double>(std::count(used.begin(), used.end(), false));
  if (outlying > most_outlying * static_cast<double>(readings.size()))
    throw Refusal(fmt::format(
        "The pictures contradict each other about the ball's diameter (median {:.5f} m; allowed "
        "are {:g} standard deviations or {:g} %):{}\nIs it one and the same ball, are the "
        "distances those of its centre from the camera, is the camera this one? Where the distances "
        "are rough, say how rough (sigma_m).",
        2 * middle_m, most_sigmas, 100 * least_tolerance, figures));
  return used;
}

}  // namespace

/// What an outline that is larger all around by the common error makes of the radius.
template <typename Read>
double RadiusReader::by_outline(const UnitBall& ball, const Read& read) const {
  const auto outline = project_sphere(camera_, ball.center, 1);
  if (!outline || !(outline->radius_px > ball.common_sigma_px)) return 0;
  const auto here = read(camera_, ball.center);
  const auto larger = read(camera_, ball.center * (1 - ball.common_sigma_px / outline->radius_px));
  return here && larger ? std::abs(*larger - *here) : 0;
}

RadiusReader::RadiusReader(const Camera& camera, const Eigen::MatrixXd& covariance)
    : camera_(camera), uncertainty_(camera, covariance) {
  if (!uncertainty_.is_valid())
    throw Refusal(
        "The camera's parameters are so uncertain that what it does to the radius cannot be computed.");
}

/// Derivatives of a radius that `read` makes of a camera and the ball's centre as that camera sees it: the
/// outline in the picture stays.
template <typename Read>
std::optional<Eigen::VectorXd> RadiusReader::by_camera(const UnitBall& ball, const Read& read) const {
  const auto outline = project_outline(camera_, ball.center, 1, outline_points);
  if (outline.empty()) return std::nullopt;
  const auto result = uncertainty_.derivatives<double>([&](const Camera& camera) -> std::optional<double> {
    const auto center = sphere_from_outline(camera, outline, 1);
    return center ? read(camera, *center) : std::nullopt;
  });
  if (!result) return std::nullopt;
  return Eigen::Map<const Eigen::VectorXd>(result->data(), static_cast<Eigen::Index>(result->size()));
}

std::optional<RadiusReading> RadiusReader::at_distance(const UnitBall& ball, double distance_m,
                                                       double sigma_m) const {
  const double range = ball.center.norm();
  const auto read = [&](const Camera&, const Eigen::Vector3d& center) {
    return std::optional(distance_m / center.norm());
  };
  const auto camera_part = by_camera(ball, read);
  if (!camera_part) return std::nullopt;
  const Eigen::Vector3d gradient = -distance_m / (range * range * range) * ball.center;
  const double variance = gradient.dot(ball.covariance * gradient) + std::pow(sigma_m / range, 2);
  return RadiusReading{distance_m / range, std::sqrt(variance), by_outline(ball, read), *camera_part};
}

std::optional<RadiusReading> RadiusReader::on_board(const UnitBall& ball, const BoardView& board,
                                                    double depth_m) const {
  const auto pose = placed(camera_, board);
  if (!pose) return std::nullopt;
  const auto radius_m = radius_on_plane(ball.center, pose->pose, depth_m);
  if (!radius_m) return std::nullopt;
  const auto camera_part = by_camera(ball, [&](const Camera& camera, const Eigen::Vector3d& center) {
    const auto changed = placed(camera, board);
    return changed ? radius_on_plane(center, changed->pose, depth_m) : std::nullopt;
  });
  if (!camera_part) return std::nullopt;
  const auto derivative = [&](const auto& radius_at, double h) {
    const auto high = radius_at(h), low = radius_at(-h);
    return high && low ? (*high - *low) / (2 * h) : 0.0;
  };
  Eigen::Vector3d by_center;
  for (int i = 0; i < 3; ++i)
    by_center(i) = derivative(
        [&](double h) {
          return radius_on_plane(ball.center + h * Eigen::Vector3d::Unit(i), pose->pose, depth_m);
        },
        1e-6 * ball.center.norm());
  BoardPose by_pose;
  for (int i = 0; i < 6; ++i)
    by_pose(i) = derivative(
        [&](double h) { return radius_on_plane(ball.center, pose->pose + h * BoardPose::Unit(i), depth_m); },
        1e-6);
  const double variance =
      by_center.dot(ball.covariance * by_center) + by_pose.dot(pose->covariance * by_pose);
  const double common_m = by_outline(ball, [&](const Camera&, const Eigen::Vector3d& center) {
    return radius_on_plane(center, pose->pose, depth_m);
  });
  return RadiusReading{*radius_m, std::sqrt(variance), common_m, *camera_part};
}

RadiusEstimate combine_radii(const std::vector<RadiusReading>& readings,
                             const std::vector<std::string>& names) {
  RadiusEstimate estimate;
  estimate.used = agreeing(readings, names);
  std::vector<const RadiusReading*> used;
  for (std::size_t i = 0; i < readings.size(); ++i)
    if (estimate.used[i]) used.push_back(&readings[i]);
  const auto count = static_cast<Eigen::Index>(used.size());
  Eigen::VectorXd radii(count), variances(count);
  Eigen::MatrixXd shared(count, used.front()->by_camera_m.size() + 1);
  for (Eigen::Index i = 0; i < count; ++i) {
    const RadiusReading& reading = *used[static_cast<std::size_t>(i)];
    radii(i) = reading.radius_m;
    // Nothing is known to better than a millionth.
    variances(i) = std::max(std::pow(reading.sigma_m, 2) - std::pow(reading.common_m, 2),
                            std::pow(1e-6 * reading.radius_m, 2));
    shared.row(i) << reading.by_camera_m.transpose(), reading.common_m;
  }
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(count);
  const auto covariance = [&](double scale) {
    Eigen::MatrixXd result = shared * shared.transpose();
    result.diagonal() += scale * variances;
    return result;
  };
  const auto best = [&](double scale) {
    const Eigen::VectorXd weights = covariance(scale).ldlt().solve(ones);
    estimate.radius_m = weights.dot(radii) / weights.sum();
    estimate.sigma_m = std::sqrt(1 / weights.sum());
  };
  best(1);
  if (count < 2) return estimate;
  const Eigen::VectorXd off = radii - estimate.radius_m * ones;
  estimate.chi2_per_dof = off.dot(covariance(1).ldlt().solve(off)) / static_cast<double>(count - 1);
  if (estimate.chi2_per_dof > 1) best(estimate.chi2_per_dof);
  return estimate;
}

}  // namespace ballservo
