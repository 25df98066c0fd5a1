// How much of a ball's outline a camera sees.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>

#include "calibration/camera/camera.hpp"
#include "servo/simulation/rendering/scene.hpp"

namespace ballservo {

/// The fraction of the area (px^2) of a ball's outline that lies in the picture and not behind anything. The
/// ball must be seen whole by the lens (project_sphere), if not by the picture.
///
/// In the plane across the ray to the ball's centre the outline is a circle, the shadow of a box or column a
/// convex polygon (the hull of its corners; round things have 48 of them) and that of a ball a conic: of each
/// of 256 rows the hidden part is known in closed form, weighted with the area that the lens makes of it.
/// Exact to about 0.002 where something is cut off, else exactly 1 or 0.
double visible_fraction(const Camera& camera, const Scene& scene, const Eigen::Isometry3d& X_WC,
                        std::size_t ball);

}  // namespace ballservo
