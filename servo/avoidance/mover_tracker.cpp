#include "servo/avoidance/mover_tracker.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace ballservo {

namespace {

// An echo's range, and how often a thing in the beam is heard. Echoes of what rests come at any range.
constexpr double range_sigma_m = 0.01, heard_share = 0.9, others_per_m = 0.1;
constexpr double silent_m = std::numeric_limits<double>::infinity();
// A cloud's weight: when it starts, when it ends, when it counts. Without an echo it fades.
constexpr double new_weight = 0.3, ends_below = 0.02, sure_weight = 0.5, fades_s = 3.0;
constexpr double starts_within_m = 3.5;
constexpr double rests_below_mps = 0.05;  // what rests seems to creep
// Resampling: guesses keep their moments but for the last two, the drift of what keeps no straight course.
constexpr double kernel_share = 0.2, drift_m = 0.003, drift_mps = 0.002;

using MoverState = Eigen::Vector4d;  // of a disc: m, m/s

MoverState state_of(const MovingDisc& disc) {
  return {disc.p_O.x(), disc.p_O.y(), disc.v_O.x(), disc.v_O.y()};
}

}  // namespace

MoverTracker::MoverTracker(const MovingThingOptions& moving, const SonarBeam& beam)
    : moving_(moving),
      beam_(beam),
      beam_side_(std::cos(beam.half_angle_rad), std::sin(beam.half_angle_rad)) {}

void MoverTracker::move(double time_s) {
  const double dt_s = started_ ? std::max(0.0, time_s - time_s_) : 0.0;
  started_ = true;
  time_s_ = time_s;
  const double kept = std::exp(-dt_s / fades_s);
  for (Cloud& cloud : clouds_) {
    if (cloud.weight <= 0.0) continue;
    cloud.weight *= kept;
    for (double& weight : cloud.weights) weight *= kept;
    for (MovingDisc& disc : cloud.discs) disc.p_O += disc.v_O * dt_s;
  }
}

double MoverTracker::heard_from_m(const Eigen::Vector2d& p_T) const {
  const double r_m = moving_.radius_m, away_m = p_T.norm(), aside_m = std::abs(p_T.y());
  if (p_T.x() <= 0.0 || away_m <= r_m) return silent_m;
  const double beside_m = aside_m * beam_side_.x() - p_T.x() * beam_side_.y();  // of the cone's side
  if (beside_m <= 0.0) return away_m - r_m;
  if (!(beside_m < r_m)) return silent_m;
  const double along_m = p_T.x() * beam_side_.x() + aside_m * beam_side_.y();
  return along_m - std::sqrt(r_m * r_m - beside_m * beside_m);
}

void MoverTracker::look(const SonarReading& reading, const Pose2& pose_then) {
  const std::optional<Pose2> transducer = transducer_of(reading, pose_then);
  if (!started_ || !transducer) return;
  const double later_s = std::min(0.0, reading.fired_s - time_s_);
  const Eigen::Vector2d p_OT(transducer->x_m, transducer->y_m);
  const Eigen::Matrix2d R_TO = Eigen::Rotation2Dd(-transducer->yaw_rad).toRotationMatrix();
  const double heard_m = reading.echo ? reading.range_m : beam_.max_range_m;
  constexpr double unheard = -1;  // a guess of which the firing says nothing
  std::array<std::array<double, cloud_size>, max_movers> likelihoods;
  double explained_per_m = 0;
  for (std::size_t c = 0; c < max_movers; ++c) {
    if (clouds_[c].weight <= 0.0) continue;
    for (std::size_t k = 0; k < cloud_size; ++k) {
      const MovingDisc& disc = clouds_[c].discs[k];
      const double from_m = heard_from_m(R_TO * (disc.p_O + later_s * disc.v_O - p_OT));
      const double off = (from_m - heard_m) / range_sigma_m;
      double& likelihood = likelihoods[c][k];
      likelihood = unheard;
      if (off > 3.0) continue;  // missed, or hidden by what echoed
      likelihood = 0.0;         // it would have echoed before
      if (reading.echo && off > -3.0)
        likelihood = heard_share * std::exp(-0.5 * off * off) / (range_sigma_m * std::sqrt(2 * M_PI));
      explained_per_m += clouds_[c].weights[k] * likelihood;
    }
  }
  const double all_per_m = others_per_m + explained_per_m;
  for (std::size_t c = 0; c < max_movers; ++c) {
    Cloud& cloud = clouds_[c];
    if (cloud.weight <= 0.0) continue;
    double sum = 0, squares = 0;
    for (std::size_t k = 0; k < cloud_size; ++k) {
      double& weight = cloud.weights[k];
      if (likelihoods[c][k] != unheard) weight *= 1.0 - heard_share + likelihoods[c][k] / all_per_m;
      sum += weight;
      squares += weight * weight;
    }
    cloud.weight = sum > ends_below ? std::min(1.0, sum) : 0.0;
    for (double& weight : cloud.weights) weight *= cloud.weight / sum;
    if (sum * sum < 0.5 * cloud_size * squares) resample(cloud);
  }
  if (reading.echo && reading.range_m < starts_within_m && reading.range_m > beam_.min_range_m &&
      explained_per_m < others_per_m)
    start(reading, *transducer, new_weight * others_per_m / all_per_m);
}

/// Any disc that would be heard so: its middle lies before the arc, or around one of the arc's ends.
MovingDisc MoverTracker::guess(const SonarReading& reading, const Pose2& transducer) {
  const double r_m = moving_.radius_m;
  const double range_m = reading.range_m + 0.5 * range_sigma_m * standard_normal(random_);
  const double before_m = (range_m + r_m) * beam_.half_angle_rad, around_m = r_m * M_PI / 2;
  const double at_m = uniform(random_, -1.0, 1.0) * (before_m + around_m);
  const double bearing = std::copysign(std::min(std::abs(at_m), before_m) / (range_m + r_m), at_m);
  const double around = bearing + std::copysign(std::max(0.0, std::abs(at_m) - before_m) / r_m, at_m);
  const double heading = uniform(random_, -M_PI, M_PI);
  const double speed_mps = moving_.speed_mps * std::sqrt(uniform01(random_));
  MovingDisc disc;
  disc.p_O = in_world_frame(transducer, {range_m * std::cos(bearing) + r_m * std::cos(around),
                                         range_m * std::sin(bearing) + r_m * std::sin(around)});
  disc.v_O = speed_mps * Eigen::Vector2d(std::cos(heading), std::sin(heading));
  disc.p_O += disc.v_O * (time_s_ - reading.fired_s);
  return disc;
}

void MoverTracker::start(const SonarReading& reading, const Pose2& transducer, double weight) {
  Cloud& cloud = *std::min_element(clouds_.begin(), clouds_.end(),
                                   [](const Cloud& a, const Cloud& b) { return a.weight < b.weight; });
  if (cloud.weight > weight) return;
  cloud.weight = weight;
  cloud.weights.fill(weight / cloud_size);
  for (MovingDisc& disc : cloud.discs) disc = guess(reading, transducer);
}

/// Systematic (Douc, Cappe and Moulines, "Comparison of resampling schemes for particle filtering", 2005),
/// with guesses moved apart by a kernel that keeps mean and covariance (Liu and West, "Combined parameter and
/// state estimation in simulation-based filtering", 2001).
void MoverTracker::resample(Cloud& cloud) {
  MoverState mean = MoverState::Zero();
  Eigen::Matrix4d covariance = 1e-8 * Eigen::Matrix4d::Identity();
  for (std::size_t k = 0; k < cloud_size; ++k)
    mean += cloud.weights[k] / cloud.weight * state_of(cloud.discs[k]);
  for (std::size_t k = 0; k < cloud_size; ++k) {
    const MoverState off = state_of(cloud.discs[k]) - mean;
    covariance += cloud.weights[k] / cloud.weight * off * off.transpose();
  }
  const Eigen::Matrix4d root = covariance.llt().matrixL();
  const std::array<MovingDisc, cloud_size> discs = cloud.discs;
  const double step = cloud.weight / cloud_size;
  double at = step * uniform01(random_), sum = cloud.weights[0];
  std::size_t from = 0;
  for (MovingDisc& disc : cloud.discs) {
    while (sum < at && from + 1 < cloud_size) sum += cloud.weights[++from];
    at += step;
    MoverState kernel, drift;
    for (double& value : kernel) value = standard_normal(random_);
    for (double& value : drift) value = standard_normal(random_);
    const MoverState state = std::sqrt(1.0 - kernel_share * kernel_share) * (state_of(discs[from]) - mean) +
                             mean + kernel_share * (root * kernel);
    disc.p_O = state.head<2>() + drift_m * drift.head<2>();
    disc.v_O = state.tail<2>() + drift_mps * drift.tail<2>();
    const double speed_mps = disc.v_O.norm();
    if (speed_mps > moving_.speed_mps) disc.v_O *= moving_.speed_mps / speed_mps;
  }
  cloud.weights.fill(step);
}

MoverTracker::Movers MoverTracker::movers() const {
  Movers found;
  for (const Cloud& cloud : clouds_) {
    if (cloud.weight < sure_weight) continue;
    Eigen::Vector2d mean(0, 0);
    double square = 0;
    for (std::size_t k = 0; k < cloud_size; ++k) {
      mean += cloud.weights[k] / cloud.weight * cloud.discs[k].v_O;
      square += cloud.weights[k] / cloud.weight * cloud.discs[k].v_O.squaredNorm();
    }
    const double variance = square - mean.squaredNorm();
    if (mean.norm() < rests_below_mps || mean.squaredNorm() < variance) continue;
    Mover& mover = found.movers[found.count++];
    mover.speed_sigma_mps = std::sqrt(std::max(0.0, variance));
    double at = 0.5 * cloud.weight / Mover::guesses, sum = cloud.weights[0];
    std::size_t from = 0;
    for (MovingDisc& disc : mover.discs) {
      while (sum < at && from + 1 < cloud_size) sum += cloud.weights[++from];
      at += cloud.weight / Mover::guesses;
      disc = cloud.discs[from];
    }
  }
  return found;
}

}  // namespace ballservo
