#include "servo/control/target_filter.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "servo/motion/option_check.hpp"

namespace ballservo {

void TargetFilterOptions::check(FaultList& faults, const std::string& place) const {
  check_not_negative(faults, place + ".acceleration_psd_m2ps3", acceleration_psd_m2ps3, "m^2/s^3");
  check_not_negative(faults, place + ".drift_psd_m2ps", drift_psd_m2ps, "m^2/s");
  check_not_negative(faults, place + ".speed_sigma_mps", speed_sigma_mps, "m/s");
  check_not_negative(faults, place + ".model_share", model_share, "m per m");
  check_positive(faults, place + ".sigma_floor_m", sigma_floor_m, "m");
  check_positive(faults, place + ".gate_sigmas", gate_sigmas, "sigmas");
  check_not_negative(faults, place + ".min_speed_mps", min_speed_mps, "m/s");
  check_positive(faults, place + ".forget_s", forget_s, "s");
  if (doubts_to_restart < 1)
    faults.add(place + ".doubts_to_restart", std::to_string(doubts_to_restart), "1 or more");
}

namespace {
constexpr double never = -std::numeric_limits<double>::infinity();
constexpr double max_distance_m = 1e3;  // balls further off are no sightings
constexpr double max_variance_m2 = 1e4;
}  // namespace

TargetFilter::TargetFilter(const TargetFilterOptions& options, const CameraMount& mount)
    : options_(options), X_RC_(mount.X_RC()), time_s_(never), stamp_s_(never) {}

void TargetFilter::propagate(double dt_s, State& state, Covariance& covariance) const {
  Covariance F = Covariance::Identity();
  F(0, 3) = F(1, 4) = dt_s;
  state = F * state;
  const double q = options_.acceleration_psd_m2ps3;
  Covariance Q = Covariance::Zero();
  for (int axis = 0; axis < 2; ++axis) {
    Q(axis, axis) = q * dt_s * dt_s * dt_s / 3.0;
    Q(axis, axis + 3) = Q(axis + 3, axis) = q * dt_s * dt_s / 2.0;
    Q(axis + 3, axis + 3) = q * dt_s;
  }
  for (int axis = 0; axis < 3; ++axis) Q(axis, axis) += options_.drift_psd_m2ps * dt_s;
  covariance = F * covariance * F.transpose() + Q;
}

void TargetFilter::start(double time_s, const Eigen::Vector3d& p_OB, const Eigen::Matrix3d& covariance_m2) {
  state_.setZero();
  state_.head<3>() = p_OB;
  covariance_.setZero();
  covariance_.topLeftCorner<3, 3>() = covariance_m2;
  covariance_(3, 3) = covariance_(4, 4) = options_.speed_sigma_mps * options_.speed_sigma_mps;
  time_s_ = time_s;
  started_ = true;
  doubts_ = 0;
}

TargetFilter::Update TargetFilter::update(const BallMeasurement& measurement, const Pose2& pose) {
  const Eigen::Vector3d& p_CB = measurement.p_CB;
  if (!measurement.is_sighting() || !std::isfinite(measurement.time_s) || !(measurement.time_s > stamp_s_) ||
      !p_CB.allFinite() || !measurement.covariance_m2.allFinite() || p_CB.norm() > max_distance_m ||
      measurement.covariance_m2.cwiseAbs().maxCoeff() > max_variance_m2) {
    return Update::ignored;
  }
  // Symmetric, and with the floor that keeps it invertible whatever came in.
  Eigen::Matrix3d R_C = 0.5 * (measurement.covariance_m2 + measurement.covariance_m2.transpose());
  R_C += options_.sigma_floor_m * options_.sigma_floor_m * Eigen::Matrix3d::Identity() +
         options_.model_share * options_.model_share * (p_CB * p_CB.transpose());
  const Eigen::LLT<Eigen::Matrix3d> positive(R_C);
  if (positive.info() != Eigen::Success) return Update::ignored;
  stamp_s_ = measurement.time_s;

  const Eigen::Isometry3d X_OC = X_WR(pose) * X_RC_;
  const Eigen::Vector3d p_OB = X_OC * p_CB;
  const Eigen::Matrix3d R = X_OC.linear() * R_C * X_OC.linear().transpose();
  if (!p_OB.allFinite()) return Update::ignored;
  if (!started_ || measurement.time_s - time_s_ > options_.forget_s) {
    start(measurement.time_s, p_OB, R);
    return Update::started;
  }

  State state = state_;
  Covariance covariance = covariance_;
  propagate(measurement.time_s - time_s_, state, covariance);
  const Eigen::Vector3d innovation = p_OB - state.head<3>();
  const Eigen::Matrix3d S = covariance.topLeftCorner<3, 3>() + R;
  const Eigen::LLT<Eigen::Matrix3d> S_llt(S);
  const double distance2 = innovation.dot(S_llt.solve(innovation));
  if (S_llt.info() != Eigen::Success || !(distance2 <= options_.gate_sigmas * options_.gate_sigmas)) {
    if (++doubts_ < options_.doubts_to_restart) return Update::doubted;
    start(measurement.time_s, p_OB, R);
    return Update::started;
  }
  doubts_ = 0;
  const Eigen::Matrix<double, 5, 3> K = S_llt.solve(covariance.leftCols<3>().transpose()).transpose();
  state_ = state + K * innovation;
  // Joseph's form keeps the covariance positive.
  Covariance I_KH = Covariance::Identity();
  I_KH.leftCols<3>() -= K;
  covariance_ = I_KH * covariance * I_KH.transpose() + K * R * K.transpose();
  time_s_ = measurement.time_s;
  return Update::accepted;
}

std::optional<TargetEstimate> TargetFilter::predict(double time_s) const {
  if (!started_ || !std::isfinite(time_s)) return std::nullopt;
  const double dt_s = std::max(0.0, time_s - time_s_);

  // A speed counts once it stands out; in between it fades in, so that the command does not jump.
  Eigen::Vector2d v = state_.tail<2>();
  const double speed = v.norm();
  const double sigma = std::sqrt(std::max(covariance_(3, 3), covariance_(4, 4)));
  const double threshold = std::max(options_.min_speed_mps, 3.0 * sigma);
  v *= threshold > 0.0 ? std::clamp((speed - threshold) / (0.5 * threshold), 0.0, 1.0) : 1.0;

  State state = state_;
  state.tail<2>() = v;
  Covariance covariance = covariance_;
  propagate(dt_s, state, covariance);
  if (!state.allFinite()) return std::nullopt;
  return TargetEstimate{state.head<3>(), v, covariance.topLeftCorner<3, 3>()};
}

}  // namespace ballservo
