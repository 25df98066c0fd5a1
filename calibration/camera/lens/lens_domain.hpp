// Up to where a lens is one-to-one, and the ray that reaches a position of the picture.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "calibration/camera/camera.hpp"

namespace ballservo {

/// Found by following the lens outwards in many directions until its Jacobian's determinant, or the growth
/// of the distance from the principal point, ceases to be positive; then by bisection to 1e-12 rad.
LensDomain find_lens_domain(LensModel model, const double* coefficients);

/// The ray (not of unit length) inside the domain that reaches a normalised position, to machine precision;
/// nothing if there is none. `guess`: a ray near it, if known; it saves time and changes nothing else.
std::optional<Eigen::Vector3d> solve_ray(LensModel model, const double* coefficients,
                                         const LensDomain& domain, const Eigen::Vector2d& position,
                                         const std::optional<Eigen::Vector3d>& guess);

}  // namespace ballservo
