// Methods that fit a circle to the ring's pixels (paper, "Raffinement"), with the paper's formula for the
// position.
#pragma once

#include <optional>

#include "app/comparison/estimators/methods.hpp"

namespace ballservo {

/// The starting circle itself, before any refinement.
std::optional<MethodFit> fit_vote(MethodScene& scene);
/// `steps` Gauss-Newton steps on E(c) = sum |grad I|^2 C^2, the pixels chosen once; or anew around each
/// step's circle. Ends early where a step fails.
std::optional<MethodFit> fit_paper_steps(MethodScene& scene, int steps, bool reselect);
/// The minimum of E(c), by Ceres.
std::optional<MethodFit> fit_paper_converged(MethodScene& scene);
/// The minimum of E(c) with the task's loss in place of C^2, by Ceres.
std::optional<MethodFit> fit_paper_robust(MethodScene& scene);
/// Algebraic circles through the same pixels and weights.
std::optional<MethodFit> fit_kasa(MethodScene& scene);
std::optional<MethodFit> fit_taubin(MethodScene& scene);

}  // namespace ballservo
