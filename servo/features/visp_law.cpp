#include "servo/features/visp_law.hpp"

#include <visp3/core/vpColVector.h>
#include <visp3/core/vpHomogeneousMatrix.h>
#include <visp3/core/vpMatrix.h>
#include <visp3/core/vpVelocityTwistMatrix.h>
#include <visp3/visual_features/vpFeatureDepth.h>
#include <visp3/visual_features/vpFeaturePoint.h>
#include <visp3/vs/vpServo.h>

#include <cmath>

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {

namespace {

// vpFeatureDepth throws for Z <= 0, and x loses its meaning on the way there.
constexpr double min_depth_m = 1e-3, max_distance_m = 1e6;

bool has_features(const Eigen::Vector3d& p_CB) {
  return p_CB.allFinite() && p_CB.z() >= min_depth_m && p_CB.norm() < max_distance_m;
}

vpHomogeneousMatrix to_visp(const Eigen::Isometry3d& X) {
  vpHomogeneousMatrix M;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) M[row][column] = X.matrix()(row, column);
  }
  return M;
}

}  // namespace

struct VispLaw::Impl {
  CameraMount mount;
  double x_desired = 0, depth_desired_m = 0;
  vpVelocityTwistMatrix cVe;
  vpMatrix eJe;
  vpFeaturePoint point, point_desired;
  vpFeatureDepth depth, depth_desired;
  vpServo task;
  vpColVector u;

  void look_at(const Eigen::Vector3d& p_CB) {
    const double x = p_CB.x() / p_CB.z(), y = p_CB.y() / p_CB.z();
    point.buildFrom(x, y, p_CB.z());
    depth.buildFrom(x, y, p_CB.z(), std::log(p_CB.z() / depth_desired_m));
  }
};

VispLaw::VispLaw(const LawOptions& options, const ServoGoal& goal) : impl_(std::make_unique<Impl>()) {
  const Eigen::Vector3d p_CB = goal.desired_p_CB();
  if (!has_features(p_CB)) {
    throw InputError("target.distance_m", number_text(goal.distance_m),
                     "a distance at which the ball's centre lies before the camera, for law visp");
  }
  Impl& s = *impl_;
  s.mount = goal.mount;
  s.x_desired = p_CB.x() / p_CB.z();
  s.depth_desired_m = p_CB.z();
  s.cVe.buildFrom(to_visp(goal.mount.X_RC().inverse()));
  s.eJe.resize(6, 2);
  s.eJe[0][0] = 1.0;  // v along the robot's x
  s.eJe[5][1] = 1.0;  // w about the robot's z

  s.point_desired.buildFrom(s.x_desired, p_CB.y() / p_CB.z(), p_CB.z());
  s.depth_desired.buildFrom(s.x_desired, p_CB.y() / p_CB.z(), p_CB.z(), 0.0);
  s.look_at(p_CB);
  s.task.setServo(vpServo::EYEINHAND_L_cVe_eJe);
  s.task.setInteractionMatrixType(vpServo::CURRENT, vpServo::PSEUDO_INVERSE);
  s.task.setLambda(options.gain_per_s);
  s.task.set_cVe(s.cVe);
  s.task.set_eJe(s.eJe);
  s.task.addFeature(s.point, s.point_desired, vpFeaturePoint::selectX());
  s.task.addFeature(s.depth, s.depth_desired);
}

VispLaw::~VispLaw() { impl_->task.kill(); }

std::optional<Eigen::Vector2d> VispLaw::errors(const Eigen::Vector3d& p_CB) const {
  if (!has_features(p_CB)) return std::nullopt;
  return Eigen::Vector2d(p_CB.x() / p_CB.z() - impl_->x_desired, std::log(p_CB.z() / impl_->depth_desired_m));
}

std::optional<Eigen::Matrix2d> VispLaw::robot_jacobian(const Eigen::Vector3d& p_CB) const {
  if (!has_features(p_CB)) return std::nullopt;
  const double x = p_CB.x() / p_CB.z(), y = p_CB.y() / p_CB.z();
  vpFeaturePoint point;
  point.buildFrom(x, y, p_CB.z());
  vpFeatureDepth depth;
  depth.buildFrom(x, y, p_CB.z(), std::log(p_CB.z() / impl_->depth_desired_m));
  vpMatrix L = point.interaction(vpFeaturePoint::selectX());
  L.stack(depth.interaction());
  const vpMatrix product = L * impl_->cVe * impl_->eJe;
  Eigen::Matrix2d J;
  J << product[0][0], product[0][1], product[1][0], product[1][1];
  return J;
}

std::optional<Eigen::Matrix<double, 2, 3>> VispLaw::ball_jacobian(const Eigen::Vector3d& p_CB) const {
  if (!has_features(p_CB)) return std::nullopt;
  const double z = p_CB.z();
  Eigen::Matrix<double, 2, 3> L;
  L << 1.0 / z, 0.0, -p_CB.x() / (z * z),  //
      0.0, 0.0, 1.0 / z;
  return L;
}

std::optional<LawOutput> VispLaw::command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) {
  const auto e = errors(p_CB);
  if (!e || !v_CB.allFinite()) return std::nullopt;
  Impl& s = *impl_;
  if (!(ahead_of_axle_m(s.mount, p_CB) >= min_ahead_m)) return std::nullopt;
  s.look_at(p_CB);
  s.u = s.task.computeControlLaw();
  Eigen::Vector2d u(s.u[0], s.u[1]);
  if (!v_CB.isZero(0.0)) {
    // vpServo has no term for a target that moves by itself: added with its own pseudo-inverse of the task's
    // Jacobian.
    const Eigen::Vector2d drift = *ball_jacobian(p_CB) * v_CB;
    const vpMatrix inverse = s.task.getTaskJacobianPseudoInverse();
    u.x() -= inverse[0][0] * drift.x() + inverse[0][1] * drift.y();
    u.y() -= inverse[1][0] * drift.x() + inverse[1][1] * drift.y();
  }
  if (!u.allFinite()) return std::nullopt;
  return LawOutput{{u.x(), u.y()}, e->x(), e->y()};
}

}  // namespace ballservo
