#include "servo/features/visp_servo_law.hpp"

#include <visp3/core/vpHomogeneousMatrix.h>
#include <visp3/core/vpVelocityTwistMatrix.h>

#include <utility>

namespace ballservo {

namespace {

// Beyond it vpServo's pseudo-inverse would take the smaller of the two singular values for 0.
constexpr double farthest_ball_m = 1e6;

vpHomogeneousMatrix to_visp(const Eigen::Isometry3d& X) {
  vpHomogeneousMatrix M;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) M[row][column] = X.matrix()(row, column);
  }
  return M;
}

vpMatrix unicycle_eJe() {
  vpMatrix eJe(6, 2);
  eJe[0][0] = 1.0;
  eJe[5][1] = 1.0;
  return eJe;
}

}  // namespace

VispServoLaw::VispServoLaw(double gain_per_s, const CameraMount& mount,
                           std::unique_ptr<BallFeatures> features)
    : mount_(mount), features_(std::move(features)) {
  // Not by vpServo(type): ViSP 3.5 leaves the threshold of the pseudo-inverse uninitialised there.
  task_.setServo(vpServo::EYEINHAND_L_cVe_eJe);
  task_.setInteractionMatrixType(vpServo::CURRENT, vpServo::PSEUDO_INVERSE);
  task_.setLambda(gain_per_s);
  task_.set_cVe(vpVelocityTwistMatrix(to_visp(mount.X_RC().inverse())));
  task_.set_eJe(unicycle_eJe());
  features_->add_to(task_);
}

VispServoLaw::~VispServoLaw() { task_.kill(); }

std::optional<LawOutput> VispServoLaw::command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) {
  if (!p_CB.allFinite() || !v_CB.allFinite() || p_CB.norm() >= farthest_ball_m) return std::nullopt;
  if (ahead_of_axle_m(mount_, p_CB) < min_ahead_m || !features_->look_at(p_CB)) return std::nullopt;
  vpColVector u = task_.computeControlLaw();
  if (!v_CB.isZero(0.0)) {
    vpColVector v(6);  // the camera's velocity by which a ball at rest would seem to move so
    for (unsigned int axis = 0; axis < 3; ++axis) v[axis] = -v_CB[axis];
    u -= task_.getTaskJacobianPseudoInverse() * (task_.getInteractionMatrix() * v);
  }
  const LawOutput output{{u[0], u[1]}, task_.error[0], task_.error[1]};
  if (!output.twist.is_finite()) return std::nullopt;
  return output;
}

}  // namespace ballservo
