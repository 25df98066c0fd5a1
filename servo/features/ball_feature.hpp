// The ball's centre as visual features of ViSP.
#pragma once

#include <visp3/visual_features/vpBasicFeature.h>

#include <Eigen/Geometry>

namespace ballservo {

/// Three coordinates s(q) of the ball's centre q = X_FC p_CB in a frame F that is fixed to the camera; the
/// derived class says which coordinates. Usable in any vpServo task, with any of the three selected.
///
/// A camera that moves at (v, w) (its own axes, m/s and rad/s) sees a ball at rest move by p' = -v - w x p
/// (Chaumette and Hutchinson, "Visual servo control, part I", IEEE RAM 13(4), 2006, equation 3), so that the
/// interaction matrix (3 x 6) is
///
///     L = ds/dq R_FC [ -I  [p_CB]x ].
class BallFeature : public vpBasicFeature {
 public:
  bool defined_at(const Eigen::Vector3d& p_CB) const;
  /// The feature of a ball at p_CB (m). Throws vpFeatureException where it is not defined.
  void buildFrom(const Eigen::Vector3d& p_CB);

  /// s = 0, for a ball nowhere.
  void init() override;
  /// The selected rows of L, in the order of the coordinates.
  vpMatrix interaction(unsigned int select = FEATURE_ALL) override;
  /// The selected rows of s - s*, angles from -pi to pi. Throws vpFeatureException for an s* of another
  /// dimension.
  vpColVector error(const vpBasicFeature& s_star, unsigned int select = FEATURE_ALL) override;
  /// On standard output, as vpServo::print asks for it.
  void print(unsigned int select = FEATURE_ALL) const override;
  /// Draws nothing.
  void display(const vpCameraParameters&, const vpImage<unsigned char>&, const vpColor& = vpColor::green,
               unsigned int = 1) const override {}
  void display(const vpCameraParameters&, const vpImage<vpRGBa>&, const vpColor& = vpColor::green,
               unsigned int = 1) const override {}

 protected:
  enum class MiddleRow { length, angle };
  BallFeature(const Eigen::Isometry3d& X_FC, MiddleRow middle_row);

 private:
  virtual const char* name() const = 0;
  virtual bool defined(const Eigen::Vector3d& q) const = 0;
  /// s, and ds/dq.
  virtual Eigen::Vector3d coordinates(const Eigen::Vector3d& q, Eigen::Matrix3d& derivative) const = 0;

  Eigen::Isometry3d X_FC_;
  MiddleRow middle_row_;
  Eigen::Matrix<double, 3, 6> L_;
};

/// The turn from the camera's axes (right, down, ahead) to axes ahead, left, up of a level camera: R_FC.
Eigen::Matrix3d ahead_left_up();

}  // namespace ballservo
