// The ball's centre as visual features of ViSP.
#pragma once

#include <visp3/visual_features/vpBasicFeature.h>

#include <Eigen/Geometry>
#include <functional>
#include <optional>

namespace ballservo {

/// Three coordinates s(q) of the ball's centre q = X_FC p_CB in a frame F that is fixed to the camera; the
/// derived class says which coordinates. Usable in any vpServo task, with any of the three selected by
/// FEATURE_LINE[0] to [2].
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
  BallFeature* duplicate() const override { return new BallFeature(*this); }

 protected:
  struct Coordinates {
    Eigen::Vector3d s;
    Eigen::Matrix3d ds_dq;
  };
  /// Nothing where the feature is not defined.
  using CoordinatesOf = std::function<std::optional<Coordinates>(const Eigen::Vector3d& q)>;
  enum class MiddleRow { length, angle };
  /// `name` is a literal.
  BallFeature(const char* name, const Eigen::Isometry3d& X_FC, MiddleRow middle_row,
              CoordinatesOf coordinates_of);

 private:
  const char* name_;
  Eigen::Isometry3d X_FC_;
  MiddleRow middle_row_;
  CoordinatesOf coordinates_of_;
  Eigen::Matrix<double, 3, 6> L_;
};

/// The turn from the camera's axes (right, down, ahead) to axes ahead, left, up of a level camera: R_FC.
Eigen::Matrix3d ahead_left_up();

/// Log range and direction of the ball's centre: s = (log rho, azimuth, elevation), rho = |p_CB| in metres,
/// azimuth positive to the left and elevation positive upwards of F's first axis (rad).
///
/// All three are functions of the cone that touches the ball, so of the image: the direction is that of its
/// axis, and rho = R / sin(alpha) for its half angle alpha and the ball's radius R, so that in the error
/// log(rho / rho*) = log(sin alpha* / sin alpha) the radius cancels. Range and direction are coupled neither
/// to each other nor, the range, to the camera's rotation, as with the spherical projection of Fomena and
/// Chaumette ("Improvements on visual servoing from spherical targets using a spherical projection model",
/// IEEE T-RO 25(4), 2009).
///
/// With q = R_FC p_CB = (a, b, c) and r^2 = a^2 + b^2,
///
///             [ a / rho^2         b / rho^2         c / rho^2 ]
///     ds/dq = [ -b / r^2          a / r^2           0         ]
///             [ -a c / (r rho^2)  -b c / (r rho^2)  r / rho^2 ],
///
/// not defined for a centre straight above or below the camera in F (r = 0).
///
/// On a robot on the floor, with F levelled, elevation and log range are tied by the ball's height, so that
/// the first two serve. There, with l the camera's distance ahead of the axle, a' = -v + w b and b' = -w (a +
/// l), so that
///
///     [rho'/rho ]   [ -a / rho^2   -l b / rho^2      ] [v]
///     [azimuth' ] = [  b / r^2     -(1 + l a / r^2)  ] [w],      det = (a + l) / rho^2,
///
/// singular exactly when the ball is abeam of the axle (a + l = 0).
class ConeFeature final : public BallFeature {
 public:
  explicit ConeFeature(const Eigen::Matrix3d& R_FC = ahead_left_up());
};

/// Cylindrical coordinates of the ball's centre in the robot frame: s = (range, bearing, height), with
/// p_RB = X_RC p_CB = (x, y, z) and r^2 = x^2 + y^2: range r (m), bearing atan2(y, x) (rad), height z (m).
///
/// Position-based visual servoing (Chaumette and Hutchinson, "Visual servo control, part I", IEEE RAM 13(4),
/// 2006): the image is turned into metres first, so an error of the ball's diameter, of the focal length or
/// of the mount moves the place where the robot stops, unless the goal was taught by showing.
///
///             [ x / r     y / r    0 ]
///     ds/dq = [ -y / r^2  x / r^2  0 ]
///             [ 0         0        1 ],
///
/// not defined for a centre straight above the axle's middle (r = 0).
///
/// For a robot on the floor x' = -v + w y and y' = -w x: the lever arm and the pitch are in X_RC, not in the
/// matrix,
///
///     [range'  ]   [ -x/r     0 ] [v]
///     [bearing'] = [  y/r^2  -1 ] [w],      det = x / r,
///
/// singular exactly when the ball is abeam of the axle (x = 0). Without delay errors decay from everywhere
/// ahead of it, range in a straight exponential where the other features' forward error is a logarithm or
/// counted along an axis.
class FloorFeature final : public BallFeature {
 public:
  explicit FloorFeature(const Eigen::Isometry3d& X_RC);
};

/// The ball's centre in units of its radius: s = q / R, q = R_FC p_CB.
///
/// Fomena and Chaumette ("Improvements on visual servoing from spherical targets using a spherical projection
/// model", IEEE T-RO 25(4), 2009) take the direction of the centre on the unit sphere over the radius of the
/// ball's image there, which is the centre over R, and find it linked linearly to the camera's translation:
/// in the camera's axes (F = C) L = [ -I / R  [s]x ]. p_CB / R is of the image alone; the R in L is what is
/// believed, and a wrong one multiplies the speeds only, which moves no equilibrium: stable while R_believed
/// / R is below 2.
///
/// A robot on the floor has two velocities, so that it can serve two of the three. With F levelled the third
/// (up) never changes, whatever the robot does: it says nothing, and the other two say all. Without the
/// levelling the pitch would mix it into the forward feature. With q = (a, b, c) and l the camera's distance
/// ahead of the axle, a ball at rest moves by a' = -v + w b, b' = -w (a + l), so that
///
///     [s_1']   [ -1/R    b/R        ] [v]
///     [s_2'] = [   0    -(a + l)/R  ] [w],      det = (a + l) / R^2,
///
/// singular exactly when the ball is abeam of the axle.
class SphereFeature final : public BallFeature {
 public:
  explicit SphereFeature(double radius_m, const Eigen::Matrix3d& R_FC = Eigen::Matrix3d::Identity());
};

}  // namespace ballservo
