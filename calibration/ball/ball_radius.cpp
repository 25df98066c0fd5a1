#include "calibration/ball/ball_radius.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "calibration/ball/covariance_root.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/statistics.hpp"
#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

constexpr int outline_points = 24, pose_steps = 20;
constexpr double step_sigmas = 0.05;
constexpr double least_corner_sigma_px = 0.05;  // what any corner finder has
constexpr double most_sigmas = 4, least_tolerance = 0.01, most_outlying = 0.25;

using Pose = Eigen::Matrix<double, 6, 1>;  // rotation vector (rad), translation (m): X_CB

Eigen::Isometry3d isometry(const Pose& pose) {
  Eigen::Isometry3d X_CB = Eigen::Isometry3d::Identity();
  const double angle = pose.head<3>().norm();
  if (angle > 0) X_CB.linear() = Eigen::AngleAxisd(angle, pose.head<3>() / angle).toRotationMatrix();
  X_CB.translation() = pose.tail<3>();
  return X_CB;
}

/// Projected minus found corners (px); nothing where one does not project.
std::optional<Eigen::VectorXd> residuals(const Camera& camera, const BoardView& board, const Pose& pose) {
  const Eigen::Isometry3d X_CB = isometry(pose);
  Eigen::VectorXd result(2 * static_cast<Eigen::Index>(board.points_m.size()));
  for (std::size_t i = 0; i < board.points_m.size(); ++i) {
    const auto pixel = camera.project(X_CB * board.points_m[i]);
    if (!pixel) return std::nullopt;
    result.segment<2>(2 * static_cast<Eigen::Index>(i)) = *pixel - board.corners_px[i];
  }
  return result;
}

/// A first pose from the rays, on the plane Z = 1.
std::optional<Pose> first_pose(const Camera& camera, const BoardView& board) {
  std::vector<cv::Point3d> object;
  std::vector<cv::Point2d> image;
  for (std::size_t i = 0; i < board.points_m.size(); ++i) {
    const auto ray = camera.unproject(board.corners_px[i]);
    if (!ray || !(ray->z() > 0.05)) return std::nullopt;
    object.emplace_back(board.points_m[i].x(), board.points_m[i].y(), 0);
    image.emplace_back(ray->x() / ray->z(), ray->y() / ray->z());
  }
  cv::Vec3d turn, shift;
  try {
    if (object.size() < 4 || !cv::solvePnP(object, image, cv::Matx33d::eye(), cv::noArray(), turn, shift,
                                           false, cv::SOLVEPNP_IPPE))
      return std::nullopt;
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  Pose pose;
  pose << turn[0], turn[1], turn[2], shift[0], shift[1], shift[2];
  return pose;
}

struct BoardPose {
  Pose pose;
  Eigen::Matrix<double, 6, 6> covariance;
};

/// The pose of least squared distances in pixels (Gauss and Newton, numerical derivatives), with its
/// covariance by the corners' own scatter.
std::optional<BoardPose> board_pose(const Camera& camera, const BoardView& board) {
  const auto start = first_pose(camera, board);
  if (!start) return std::nullopt;
  Pose pose = *start;
  Eigen::Matrix<double, 6, 6> information;
  for (int step = 0;; ++step) {
    const auto error = residuals(camera, board, pose);
    if (!error) return std::nullopt;
    Eigen::MatrixXd jacobian(error->size(), 6);
    const double size = std::max(1e-3, pose.tail<3>().norm());
    for (int i = 0; i < 6; ++i) {
      const double h = i < 3 ? 1e-6 : 1e-6 * size;
      const auto high = residuals(camera, board, pose + h * Pose::Unit(i));
      const auto low = residuals(camera, board, pose - h * Pose::Unit(i));
      if (!high || !low) return std::nullopt;
      jacobian.col(i) = (*high - *low) / (2 * h);
    }
    information = jacobian.transpose() * jacobian;
    const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solver(information);
    const Pose move = solver.solve(jacobian.transpose() * *error);
    if (!move.allFinite()) return std::nullopt;
    if (step == pose_steps || (jacobian * move).cwiseAbs().maxCoeff() < 1e-9) {
      const double freedom = std::max<double>(1, static_cast<double>(error->size()) - 6);
      const double variance =
          std::max(error->squaredNorm() / freedom, least_corner_sigma_px * least_corner_sigma_px);
      return BoardPose{pose, variance * solver.solve(Eigen::Matrix<double, 6, 6>::Identity())};
    }
    pose -= move;
  }
}

/// R = e / (1 - n.c); nothing for a ball that is not on the camera's side.
std::optional<double> radius_on_plane(const Eigen::Vector3d& unit_center, const Pose& pose, double depth_m) {
  const Eigen::Isometry3d X_CB = isometry(pose);
  Eigen::Vector3d normal = X_CB.linear().col(2);
  double height_m = -normal.dot(X_CB.translation());
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

RadiusReader::RadiusReader(const Camera& camera, const Eigen::MatrixXd& covariance) : camera_(camera) {
  if (covariance.size() == 0) return;
  auto changed = changed_cameras(camera, covariance, step_sigmas);
  if (!changed)
    throw Refusal(
        "The camera's parameters are so uncertain that what it does to the radius cannot be computed.");
  changed_ = std::move(*changed);
}

/// Derivatives of a radius that `read` makes of a camera and the ball's centre as that camera sees it: the
/// outline in the picture stays.
template <typename Read>
std::optional<Eigen::VectorXd> RadiusReader::by_camera(const UnitBall& ball, const Read& read) const {
  const auto outline = project_outline(camera_, ball.center, 1, outline_points);
  if (outline.empty()) return std::nullopt;
  const auto radius = [&](const Camera& camera) -> std::optional<double> {
    const auto center = sphere_from_outline(camera, outline, 1);
    return center ? read(camera, *center) : std::nullopt;
  };
  Eigen::VectorXd result(static_cast<Eigen::Index>(changed_.size()));
  for (std::size_t i = 0; i < changed_.size(); ++i) {
    const auto high = radius(changed_[i].first), low = radius(changed_[i].second);
    if (!high || !low) return std::nullopt;
    result(static_cast<Eigen::Index>(i)) = (*high - *low) / (2 * step_sigmas);
  }
  return result;
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
  const auto pose = board_pose(camera_, board);
  if (!pose) return std::nullopt;
  const auto radius_m = radius_on_plane(ball.center, pose->pose, depth_m);
  if (!radius_m) return std::nullopt;
  const auto camera_part = by_camera(ball, [&](const Camera& camera, const Eigen::Vector3d& center) {
    const auto changed = board_pose(camera, board);
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
  Pose by_pose;
  for (int i = 0; i < 6; ++i)
    by_pose(i) = derivative(
        [&](double h) { return radius_on_plane(ball.center, pose->pose + h * Pose::Unit(i), depth_m); },
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
