#include "calibration/ball/camera_difference.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "calibration/ball/ball_uncertainty.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/random.hpp"
#include "calibration/base/statistics.hpp"
#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

constexpr int rotation_rounds = 20, draws = 20000;

/// A place of the picture with what both cameras read the same there: the pixel, and a ball's outline.
struct Sight {
  Eigen::Vector2d pixel_px;
  std::vector<Eigen::Vector2d> outline_px;  // empty: no whole ball there
};

std::vector<Sight> sights(const Camera& a, const CameraDifferenceOptions& options, int rows) {
  std::vector<Sight> result;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < options.columns; ++i) {
      Sight& sight = result.emplace_back();
      sight.pixel_px = {(a.size().width_px - 1.0) * i / (options.columns - 1),
                        (a.size().height_px - 1.0) * j / (rows - 1)};
      const auto ray = a.unproject(sight.pixel_px);
      if (!ray) continue;
      sight.outline_px = project_outline(a, options.range_m * *ray, 0.5 * options.diameter_m, outline_points);
      if (!is_inside_picture(sight.outline_px, a.size())) sight.outline_px.clear();
    }
  }
  return result;
}

/// What one camera makes of the sights.
struct Reading {
  std::vector<std::optional<Eigen::Vector3d>> rays, balls;
};

Reading read_sights(const Camera& camera, const std::vector<Sight>& seen, double radius_m) {
  Reading reading;
  for (const Sight& sight : seen) {
    reading.rays.push_back(camera.unproject(sight.pixel_px));
    reading.balls.push_back(
        sight.outline_px.empty() ? std::nullopt : sphere_from_outline(camera, sight.outline_px, radius_m));
  }
  return reading;
}

/// The rotation R that makes the sum of w |b - R a|^2 least.
Eigen::Matrix3d weighted_rotation(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b,
                                  const Eigen::VectorXd& weights) {
  const Eigen::Matrix3d sum = b * weights.asDiagonal() * a.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

/// The rotation of the rays that both have, by reweighted least squares with Cauchy's weights at the scale of
/// the median: corners that no board has reached, where the two drift apart without bound, have no say.
/// Nothing for fewer than three rays.
std::optional<Eigen::Matrix3d> best_rotation(const Reading& reading_a, const Reading& reading_b) {
  std::vector<std::size_t> common;
  for (std::size_t i = 0; i < reading_a.rays.size(); ++i)
    if (reading_a.rays[i] && reading_b.rays[i]) common.push_back(i);
  if (common.size() < 3) return std::nullopt;
  const auto count = static_cast<Eigen::Index>(common.size());
  Eigen::Matrix3Xd a(3, count), b(3, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    a.col(i) = *reading_a.rays[common[static_cast<std::size_t>(i)]];
    b.col(i) = *reading_b.rays[common[static_cast<std::size_t>(i)]];
  }
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(count);
  Eigen::Matrix3d R_BA = weighted_rotation(a, b, weights);
  for (int round = 0; round < rotation_rounds; ++round) {
    const Eigen::VectorXd off = (b - R_BA * a).colwise().norm();
    const double scale = std::max(1e-12, upper_median(std::vector<double>(off.data(), off.data() + count)));
    weights = (1 + (off / scale).array().square()).inverse();
    R_BA = weighted_rotation(a, b, weights);
  }
  return R_BA;
}

/// The balls' differences, one column a place; NaN where one of the two reads none.
Eigen::Matrix3Xd ball_differences(const Reading& a, const Reading& b, const Eigen::Matrix3d& R_BA) {
  Eigen::Matrix3Xd result(3, static_cast<Eigen::Index>(a.balls.size()));
  result.setConstant(std::nan(""));
  for (std::size_t i = 0; i < a.balls.size(); ++i)
    if (a.balls[i] && b.balls[i]) result.col(static_cast<Eigen::Index>(i)) = *b.balls[i] - R_BA * *a.balls[i];
  return result;
}

/// How often sum lambda_k z_k^2 with standard normal z reaches `sum`.
double chance_of(double sum, const Eigen::VectorXd& lambdas, std::uint64_t seed) {
  RandomEngine engine = random_stream(seed, "camera difference");
  int reached = 0;
  for (int draw = 0; draw < draws; ++draw) {
    double value = 0;
    for (Eigen::Index k = 0; k < lambdas.size(); ++k) {
      const double z = standard_normal(engine);
      value += lambdas(k) * z * z;
    }
    if (value >= sum) ++reached;
  }
  return static_cast<double>(reached) / draws;
}

/// Fills in what the uncertainties say: each place's sigma, and the chance where both are known.
void add_uncertainty(CameraDifference& difference, const std::vector<Eigen::Matrix3Xd>& axes, bool both,
                     std::uint64_t seed) {
  Eigen::MatrixXd products =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(axes.size()), static_cast<Eigen::Index>(axes.size()));
  double squares = 0, variance_sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < difference.places.size(); ++i) {
    DifferencePlace& place = difference.places[i];
    if (!place.ball_m) continue;
    Eigen::Matrix3Xd here(3, static_cast<Eigen::Index>(axes.size()));
    for (std::size_t k = 0; k < axes.size(); ++k)
      here.col(static_cast<Eigen::Index>(k)) = axes[k].col(static_cast<Eigen::Index>(i));
    if (!here.allFinite()) continue;
    const double variance = here.squaredNorm();
    if (!(variance > 0)) continue;
    place.ball_sigma_m = std::sqrt(variance);
    // Each place counts in units of its own sigma: else the worst known corners would decide alone.
    products += here.transpose() * here / variance;
    squares += place.ball_m->squaredNorm() / variance;
    variance_sum += variance;
    ++count;
  }
  if (count == 0) return;
  difference.ball_sigma_rms_m = std::sqrt(variance_sum / count);
  difference.sigmas_rms = std::sqrt(squares / count);
  if (!both) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(products);
  difference.chance = chance_of(squares, solver.eigenvalues().cwiseMax(0), seed);
}

DifferenceSpread spread_of(const std::vector<double>& values) {
  if (values.empty()) return {};
  return {upper_median(std::vector<double>(values)), root_mean_square(values),
          *std::max_element(values.begin(), values.end())};
}

void add_places(CameraDifference& difference, const std::vector<Sight>& seen, const Reading& reading_a,
                const Reading& reading_b, const Camera& b) {
  const Eigen::Matrix3Xd balls = ball_differences(reading_a, reading_b, difference.R_BA);
  std::vector<double> shifts, ball_distances;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    DifferencePlace& place = difference.places.emplace_back();
    place.pixel_px = seen[i].pixel_px;
    if (reading_a.rays[i] && reading_b.rays[i]) {
      if (const auto pixel = b.project(difference.R_BA * *reading_a.rays[i])) {
        place.shift_px = *pixel - place.pixel_px;
        shifts.push_back(place.shift_px->norm());
      }
    }
    const Eigen::Vector3d ball = balls.col(static_cast<Eigen::Index>(i));
    if (!ball.allFinite()) continue;
    place.ball_m = ball;
    ball_distances.push_back(ball.norm());
  }
  if (ball_distances.empty())
    throw InputError("the ball", "one that is nowhere wholly in the picture, or read by one camera alone",
                     "a smaller --diameter or a larger --range (m)");
  difference.shift_px = spread_of(shifts);
  difference.ball_m = spread_of(ball_distances);
}

}  // namespace

void CameraDifferenceOptions::validate() const {
  FaultList faults;
  if (!(std::isfinite(diameter_m) && diameter_m > 0))
    faults.add("diameter", fmt::format("{}", diameter_m), "a finite number above 0 (m)");
  if (!(std::isfinite(range_m) && range_m > 0.5 * diameter_m))
    faults.add("range", fmt::format("{} m with a ball of {} m", range_m, diameter_m),
               "a finite number above the ball's radius (m)");
  check_range(faults, "columns", columns, 3, 200);
  faults.throw_if_any();
}

CameraDifference compare_cameras(const Camera& a, const Eigen::MatrixXd& covariance_a, const Camera& b,
                                 const Eigen::MatrixXd& covariance_b,
                                 const CameraDifferenceOptions& options) {
  options.validate();
  const ImageSize size = a.size();
  if (size != b.size())
    throw InputError("the second camera",
                     fmt::format("pictures of {} x {} pixels", b.size().width_px, b.size().height_px),
                     fmt::format("{} x {}, as the first camera's: two calibrations of one camera",
                                 size.width_px, size.height_px));
  CameraDifference difference;
  difference.columns = options.columns;
  difference.rows = std::clamp(
      static_cast<int>(std::lround((options.columns - 1.0) * size.height_px / size.width_px)) + 1, 3, 200);
  const double radius_m = 0.5 * options.diameter_m;
  const std::vector<Sight> seen = sights(a, options, difference.rows);
  const Reading reading_a = read_sights(a, seen, radius_m), reading_b = read_sights(b, seen, radius_m);
  const auto R_BA = best_rotation(reading_a, reading_b);
  if (!R_BA) throw Refusal("The two cameras have rays for fewer than three places of the picture in common.");
  difference.R_BA = *R_BA;
  const Eigen::AngleAxisd turn(*R_BA);
  difference.rotation_rad = turn.angle() * turn.axis();
  add_places(difference, seen, reading_a, reading_b, b);

  const bool known_a = covariance_a.size() > 0, known_b = covariance_b.size() > 0;
  if (!known_a && !known_b) return difference;
  // The rotation follows, as it does when the cameras are compared.
  using Differences = Eigen::Matrix3Xd;
  const auto turned_differences = [](const Reading& by_a, const Reading& by_b) -> std::optional<Differences> {
    const auto turned = best_rotation(by_a, by_b);
    if (!turned) return std::nullopt;
    return ball_differences(by_a, by_b, *turned);
  };
  const auto along_a = CameraUncertainty(a, covariance_a).derivatives<Differences>([&](const Camera& camera) {
    return turned_differences(read_sights(camera, seen, radius_m), reading_b);
  });
  const auto along_b = CameraUncertainty(b, covariance_b).derivatives<Differences>([&](const Camera& camera) {
    return turned_differences(reading_a, read_sights(camera, seen, radius_m));
  });
  if (!along_a || !along_b) return difference;
  std::vector<Eigen::Matrix3Xd> axes = *along_a;
  axes.insert(axes.end(), along_b->begin(), along_b->end());
  add_uncertainty(difference, axes, known_a && known_b, options.seed);
  return difference;
}

}  // namespace ballservo
