// A calibrated camera: which ray of the world reaches which pixel.
//
// Camera frame C: x right, y down, z forward, origin at the centre of projection, metres.
// Pixel (0, 0) is the centre of the top-left pixel; a pixel position is where the point appears in the
// picture as it was given, that is distorted. Every model is *defined* in its own format's direction and
// solved in the other.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/base/image_size.hpp"

namespace ballservo {

/// The lens models. Coefficients, in this order:
/// pinhole: none. visp: kdu (ViSP's "perspective with distortion", defined from pixel to ray).
/// brown: k1 k2 p1 p2 k3. brown8: k1 k2 p1 p2 k3 k4 k5 k6. kannala_brandt: k1 k2 k3 k4.
/// (Brown-Conrady as OpenCV and ROS have it, Kannala-Brandt as OpenCV's fisheye; both defined from ray to
/// pixel.)
enum class LensModel { pinhole, visp, brown, brown8, kannala_brandt };

inline constexpr std::array<LensModel, 5> all_lens_models{
    LensModel::pinhole, LensModel::visp, LensModel::brown, LensModel::brown8, LensModel::kannala_brandt};

std::string_view lens_model_name(LensModel model);  ///< "kannala_brandt"
std::optional<LensModel> lens_model_from_name(std::string_view name);
int coefficient_count(LensModel model);                       ///< 0, 1, 5, 8, 4
std::vector<std::string> coefficient_names(LensModel model);  ///< "k1", "k2", ...

/// The numbers that describe a camera; any values, checked by Camera's constructor.
struct CameraParameters {
  LensModel model = LensModel::pinhole;
  ImageSize size;
  double fx_px = 0, fy_px = 0;           ///< focal lengths
  double cx_px = 0, cy_px = 0;           ///< principal point
  std::array<double, 8> coefficients{};  ///< the first coefficient_count(model) count, the rest are 0
};

/// Where a lens is one-to-one: the disc of angles below `max_angle_rad`; for a lens defined from the picture
/// to the ray also the disc of normalised positions below `max_radius` (infinite for the others).
struct LensDomain {
  double max_angle_rad = 0;
  double max_radius = 0;
};

/// Whether a pixel position lies in a picture of that size, at least so far from its border.
inline bool is_inside_picture(const Eigen::Vector2d& pixel_px, ImageSize size, double margin_px = 0) {
  const double least_px = margin_px - 0.5;
  return pixel_px.x() >= least_px && pixel_px.y() >= least_px &&
         pixel_px.x() <= size.width_px - 1 - least_px && pixel_px.y() <= size.height_px - 1 - least_px;
}

/// A camera with valid parameters. Immutable and cheap to copy.
class Camera {
 public:
  /// Throws InputError, naming every fault: sizes below 1 or above 65536, focal lengths that are not finite
  /// and positive, a principal point that is not finite or further from the picture than its larger side,
  /// coefficients that are not finite, numbers beyond the model's coefficients. `place` stands for the file
  /// in messages.
  explicit Camera(const CameraParameters& parameters, const std::string& place = "camera");

  const CameraParameters& parameters() const { return parameters_; }
  ImageSize size() const { return parameters_.size; }
  /// Geometric mean of fx and fy: the focal length of the undistorted picture of square pixels (px).
  double focal_px() const;

  /// Where a point of the camera frame (m, any scale) appears (px); nothing if it does not appear at all:
  /// behind a perspective lens, beyond the angle up to which the model is one-to-one, or not finite. A result
  /// may lie outside the picture. Solved to machine precision where the model is defined the other way.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& p_C) const;
  /// Whether it appears in the picture.
  bool shows(const Eigen::Vector3d& p_C) const {
    const auto pixel_px = project(p_C);
    return pixel_px && is_inside_picture(*pixel_px, size());
  }

  /// The unit ray (camera frame) that reaches a pixel position; nothing if no ray does or it is not finite.
  /// Faster where the ray of a nearby pixel is known.
  std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& pixel_px,
                                           std::optional<Eigen::Vector3d> nearby_ray = {}) const;

  /// Derivative of `project` (2 x 3, px per unit of p_C) at a point that projects; nothing elsewhere.
  std::optional<Eigen::Matrix<double, 2, 3>> project_jacobian(const Eigen::Vector3d& p_C) const;

  /// The largest angle from the optical axis (rad) up to which the model is one-to-one.
  double max_angle_rad() const { return domain_.max_angle_rad; }

 private:
  bool may_appear(const Eigen::Vector3d& p_C) const;

  CameraParameters parameters_;
  LensDomain domain_;
};

/// The camera that is assumed when none is given: square pixels, the principal point in the middle, a lens so
/// long (focal length 10^4 picture widths) that the outline of a ball is a circle to better than a thousandth
/// of a pixel. Positions in 3-D that come from it mean nothing and are never shown.
Camera long_lens_camera(ImageSize size);

}  // namespace ballservo
