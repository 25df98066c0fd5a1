// Methods that fit the exact tangent cone of a ball to sub-pixel edge points.
#pragma once

#include <optional>

#include "app/comparison/estimators/methods.hpp"

namespace ballservo {

/// `steps` Gauss-Newton steps on sum w (angle outside the cone / sigma)^2 over the points of perception's
/// last step; one step is what runs on line.
std::optional<MethodFit> fit_sphere_steps(MethodScene& scene, int steps);
/// The minimum of the same, by Ceres.
std::optional<MethodFit> fit_sphere_converged(MethodScene& scene);
/// The minimum with the task's loss in place of the robust weights, by Ceres.
std::optional<MethodFit> fit_sphere_robust(MethodScene& scene);

}  // namespace ballservo
