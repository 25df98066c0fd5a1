// The fits that a plan may name: the fuzzed parser looks their names up and runs none.
#include "app/comparison/estimators/circle_methods.hpp"
#include "app/comparison/estimators/cone_methods.hpp"
#include "app/comparison/estimators/peer_methods.hpp"

namespace ballservo {

std::optional<MethodFit> fit_vote(MethodScene&) { return std::nullopt; }
std::optional<MethodFit> fit_paper_steps(MethodScene&, int, bool) { return std::nullopt; }
std::optional<MethodFit> fit_paper_converged(MethodScene&) { return std::nullopt; }
std::optional<MethodFit> fit_paper_robust(MethodScene&) { return std::nullopt; }
std::optional<MethodFit> fit_kasa(MethodScene&) { return std::nullopt; }
std::optional<MethodFit> fit_taubin(MethodScene&) { return std::nullopt; }
std::optional<MethodFit> fit_sphere_steps(MethodScene&, int) { return std::nullopt; }
std::optional<MethodFit> fit_sphere_converged(MethodScene&) { return std::nullopt; }
std::optional<MethodFit> fit_sphere_robust(MethodScene&) { return std::nullopt; }
std::optional<MethodFit> fit_hough_gradient(MethodScene&) { return std::nullopt; }
std::optional<MethodFit> fit_hough_gradient_alt(MethodScene&) { return std::nullopt; }
std::optional<MethodFit> fit_hsv_contour(MethodScene&) { return std::nullopt; }
std::optional<MethodFit> fit_vpdot2(MethodScene&) { return std::nullopt; }

}  // namespace ballservo
