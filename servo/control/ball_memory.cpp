#include "servo/control/ball_memory.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace ballservo {

namespace {

constexpr double max_distance_m = 1e3;  // balls further off are no sightings
constexpr double max_variance_m2 = 1e4;

// White acceleration of the ball in the floor plane (power density q). The filter's time constant is (r /
// q)^1/4 for sightings of noise density r: 0.36 s at 30 Hz and 10 mm.
constexpr double acceleration_psd_m2ps3 = 2e-4;
constexpr double drift_psd_m2ps = 1e-7;  // odometry's drift, as a random walk of the ball in its frame
constexpr double speed_sigma_mps = 0.3;  // of a ball just seen
// Where the scale is not known, the camera's tilt is not either: a ball seems to rise or sink as it comes
// near.
constexpr double height_psd_m2ps = 2.5e-3;
// What the covariances leave out, the camera's calibration above all: per distance along the ray, and in
// every direction.
constexpr double model_share = 0.003, sigma_floor_m = 2e-4;
constexpr double gate_sigmas = 4.0;     // 0.1 % of good sightings lie beyond (chi-square, 3 degrees)
constexpr double min_speed_mps = 0.03;  // below this, or below three sigma, the ball is taken to rest
constexpr double forget_s = 1.5;        // without a sighting for so long, the next one starts the filter anew
constexpr double extrapolate_s = 1.5;   // a ball out of sight is taken to go on moving for so long

}  // namespace

void TargetFilter::propagate(double dt_s, State& state, Covariance& covariance) const {
  Covariance F = Covariance::Identity();
  F(0, 3) = F(1, 4) = dt_s;
  state = F * state;
  const double q = acceleration_psd_m2ps3;
  Covariance Q = Covariance::Zero();
  for (int axis = 0; axis < 2; ++axis) {
    Q(axis, axis) = q * dt_s * dt_s * dt_s / 3.0;
    Q(axis, axis + 3) = Q(axis + 3, axis) = q * dt_s * dt_s / 2.0;
    Q(axis + 3, axis + 3) = q * dt_s;
  }
  for (int axis = 0; axis < 3; ++axis) Q(axis, axis) += drift_psd_m2ps * dt_s;
  if (scale_sigma_ > 0) Q(2, 2) += height_psd_m2ps * dt_s;
  covariance = F * covariance * F.transpose() + Q;
}

void TargetFilter::start(double time_s, const Eigen::Vector3d& p_OB, const Eigen::Matrix3d& covariance_m2,
                         const Eigen::Vector3d& c_OC) {
  const double scale = state_[5], scale_variance = covariance_(5, 5);  // what was learnt of it holds on
  state_ << p_OB + (scale - 1) * c_OC, 0, 0, scale;
  State by_scale;
  by_scale << c_OC, 0, 0, 1;
  covariance_ = scale_variance * by_scale * by_scale.transpose();
  covariance_.topLeftCorner<3, 3>() += covariance_m2;
  covariance_(3, 3) = covariance_(4, 4) = speed_sigma_mps * speed_sigma_mps;
  time_s_ = time_s;
  doubts_ = 0;
}

TargetFilter::Update TargetFilter::update(const BallMeasurement& measurement, const Pose2& pose) {
  const Eigen::Vector3d& p_CB = measurement.p_CB;
  if (!measurement.is_sighting() || !std::isfinite(measurement.time_s) || !(measurement.time_s > stamp_s_) ||
      !p_CB.allFinite() || !measurement.covariance_m2.allFinite() || p_CB.norm() > max_distance_m ||
      measurement.covariance_m2.cwiseAbs().maxCoeff() > max_variance_m2 ||
      !std::isfinite(measurement.pan_rad)) {
    return Update::ignored;
  }
  // Symmetric, and with the floor that keeps it invertible whatever came in.
  Eigen::Matrix3d R_C = 0.5 * (measurement.covariance_m2 + measurement.covariance_m2.transpose());
  R_C += sigma_floor_m * sigma_floor_m * Eigen::Matrix3d::Identity() +
         model_share * model_share * (p_CB * p_CB.transpose());
  const Eigen::LLT<Eigen::Matrix3d> positive(R_C);
  if (positive.info() != Eigen::Success) return Update::ignored;
  stamp_s_ = measurement.time_s;

  const Eigen::Isometry3d X_OC = X_WR(pose) * mount_.X_RC(measurement.pan_rad);
  const Eigen::Vector3d p_OB = X_OC * p_CB, c_OC = X_OC.translation();
  const Eigen::Matrix3d R = X_OC.linear() * R_C * X_OC.linear().transpose();
  if (!p_OB.allFinite()) return Update::ignored;
  if (measurement.time_s - time_s_ > forget_s) {
    start(measurement.time_s, p_OB, R, c_OC);
    return Update::started;
  }

  State state = state_;
  Covariance covariance = covariance_;
  propagate(measurement.time_s - time_s_, state, covariance);
  Eigen::Matrix<double, 3, 6> H = Eigen::Matrix<double, 3, 6>::Identity();
  H.col(5) = -c_OC;
  const Eigen::Vector3d innovation = p_OB - state.head<3>() + (state[5] - 1) * c_OC;
  const Eigen::Matrix<double, 6, 3> cross = covariance * H.transpose();
  const Eigen::Matrix3d S = H * cross + R;
  const Eigen::LLT<Eigen::Matrix3d> S_llt(S);
  const double distance2 = innovation.dot(S_llt.solve(innovation));
  if (S_llt.info() != Eigen::Success || !(distance2 <= gate_sigmas * gate_sigmas)) {
    if (++doubts_ < doubts_to_restart) return Update::doubted;
    start(measurement.time_s, p_OB, R, c_OC);
    return Update::started;
  }
  doubts_ = 0;
  const Eigen::Matrix<double, 6, 3> K = S_llt.solve(cross.transpose()).transpose();
  state_ = state + K * innovation;
  const double scale = std::clamp(state_[5], 1 / greatest_scale, greatest_scale);
  state_.head<3>() += (scale - state_[5]) * c_OC;  // where the ball seems to be stays
  state_[5] = scale;
  // Joseph's form keeps the covariance positive.
  const Covariance I_KH = Covariance::Identity() - K * H;
  covariance_ = I_KH * covariance * I_KH.transpose() + K * R * K.transpose();
  time_s_ = measurement.time_s;
  return Update::accepted;
}

std::optional<TargetEstimate> TargetFilter::predict(double time_s) const {
  if (time_s_ == never || !std::isfinite(time_s)) return std::nullopt;
  const double dt_s = std::max(0.0, time_s - time_s_);

  // A speed counts once it stands out; in between it fades in, so that the command does not jump.
  const double scale = state_[5];
  Eigen::Vector2d v = state_.segment<2>(3) / scale;
  const double speed = v.norm();
  const double sigma = std::sqrt(std::max(covariance_(3, 3), covariance_(4, 4))) / scale;
  const double threshold = std::max(min_speed_mps, 3.0 * sigma);
  v *= threshold > 0.0 ? std::clamp((speed - threshold) / (0.5 * threshold), 0.0, 1.0) : 1.0;

  State state = state_;
  state.segment<2>(3) = v * scale;
  Covariance covariance = covariance_;
  propagate(dt_s, state, covariance);
  if (!state.allFinite()) return std::nullopt;
  const Eigen::Vector3d p_OB = state.head<3>() / scale;
  Eigen::Matrix<double, 3, 6> by_state = Eigen::Matrix<double, 3, 6>::Identity() / scale;
  by_state.col(5) = -p_OB / scale;
  return TargetEstimate{p_OB, v, by_state * covariance * by_state.transpose(), scale};
}

void BallMemory::see(const BallMeasurement& measurement, double arrived_s) {
  if (inbox_count_ == inbox_.size()) {  // more frames than steps can read: the oldest goes
    std::move(inbox_.begin() + 1, inbox_.end(), inbox_.begin());
    --inbox_count_;
  }
  inbox_[inbox_count_++] = {measurement, arrived_s};
}

void BallMemory::take_in(double time_s, const PoseHistory& poses) {
  nonsense_ = false;
  for (std::size_t i = 0; i < inbox_count_; ++i) {
    const BallMeasurement& frame = inbox_[i].frame;
    const bool claims_ball = frame.state != TrackState::none;
    if (!std::isfinite(frame.time_s) ||
        (claims_ball &&
         (!frame.p_CB.allFinite() || !frame.covariance_m2.allFinite() || !std::isfinite(frame.pan_rad)))) {
      nonsense_ = true;
      continue;
    }
    if (frame.time_s <= frame_s_ || frame.time_s > time_s) continue;
    frame_s_ = frame.time_s;
    frame_arrived_s_ = std::min(inbox_[i].arrived_s, time_s);
    track_state_ = frame.state;
    if (!frame.is_sighting()) continue;
    const auto pose = pose_at(poses, frame.time_s);
    if (!pose) continue;  // older than all that is remembered
    const TargetFilter::Update update = filter_.update(frame, *pose);
    if (update == TargetFilter::Update::ignored || update == TargetFilter::Update::doubted) continue;
    if (update == TargetFilter::Update::started) confirmed_ = 0;
    sighting_s_ = frame.time_s;
    confirmed_ = frame.state == TrackState::confirmed ? confirmed_ + 1 : 0;
  }
  inbox_count_ = 0;
}

std::optional<TargetEstimate> BallMemory::predict(double time_s) const {
  const double until_s = filter_.last_time_s() + extrapolate_s;
  auto estimate = filter_.predict(std::min(time_s, until_s));
  if (estimate && time_s > until_s) estimate->v_OB.setZero();
  return estimate;
}

}  // namespace ballservo
