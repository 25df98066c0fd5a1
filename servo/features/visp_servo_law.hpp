// A law is a set of visual features in a task of ViSP's vpServo.
#pragma once

#include <visp3/vs/vpServo.h>

#include <memory>

#include "servo/control/law.hpp"
#include "servo/features/ball_feature.hpp"
#include "servo/motion/camera_mount.hpp"

namespace ballservo {

/// What a law looks at: features of the ball with their desired values.
class BallFeatures {
 public:
  virtual ~BallFeatures() = default;
  /// Adds features and desired features to the task; they stay this object's. Called once.
  virtual void add_to(vpServo& task) = 0;
  /// The current features for a ball at p_CB (m, finite); false where they are not defined.
  virtual bool look_at(const Eigen::Vector3d& p_CB) = 0;
};

/// vpServo's EYEINHAND_L_cVe_eJe with the current interaction matrix L, for a robot on the floor: the end
/// effector frame is the robot frame, cVe the twist transformation of the mount's X_CR, and eJe that of a
/// unicycle (v along the robot's x, w about its z). With J = L cVe eJe and a ball that moves over ground at
/// v_CB,
///
///     (v, w) = -lambda J+ (s - s*) - J+ ds/dp v_CB,        ds/dp = -L's first three columns.
///
/// The second term, which vpServo does not have, is the feed-forward for a moving ball. Saturation and
/// prediction are the controller's. vpServo takes memory from the heap in every step.
class VispServoLaw final : public Law {
 public:
  /// Gain and mount as a LawCatalog has checked them; the features are two or more.
  VispServoLaw(double gain_per_s, const CameraMount& mount, std::unique_ptr<BallFeatures> features);
  VispServoLaw(const VispServoLaw&) = delete;
  VispServoLaw& operator=(const VispServoLaw&) = delete;
  ~VispServoLaw() override;

  /// error_1 and error_2 are the task's first two. Nothing where the features are not defined, and for a ball
  /// less than min_ahead_m ahead of the axle.
  std::optional<LawOutput> command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) override;

 private:
  CameraMount mount_;
  std::unique_ptr<BallFeatures> features_;
  vpServo task_;
};

}  // namespace ballservo
