// Methods that fit the ball from the starting circle: a circle to the ring's pixels (paper, "Raffinement"),
// with the paper's formula for the position, or the exact tangent cone to sub-pixel edge points.
#pragma once

#include <optional>

#include "app/comparison/estimators/methods.hpp"

namespace ballservo {

/// The starting circle itself, before any refinement.
std::optional<MethodFit> fit_vote(MethodScene& scene);
/// `steps` Gauss-Newton steps on E(c) = sum |grad I|^2 C^2, the pixels chosen once; or anew around each
/// step's circle. Ends early where a step fails.
std::optional<MethodFit> fit_paper_steps(MethodScene& scene, int steps, bool reselect);
/// `steps` Gauss-Newton steps on sum w (angle outside the cone / sigma)^2 over the points of perception's
/// last step; one step is what runs on line.
std::optional<MethodFit> fit_sphere_steps(MethodScene& scene, int steps);
/// The minima of the same two, by Ceres; robust: with the task's loss, which for the cone stands in for the
/// points' robust weights.
std::optional<MethodFit> fit_paper_converged(MethodScene& scene, bool robust);
std::optional<MethodFit> fit_sphere_converged(MethodScene& scene, bool robust);
/// Algebraic circles through the same pixels and weights.
std::optional<MethodFit> fit_kasa(MethodScene& scene);
std::optional<MethodFit> fit_taubin(MethodScene& scene);

}  // namespace ballservo
