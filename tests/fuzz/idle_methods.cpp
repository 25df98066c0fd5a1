// The methods that a plan may name: the fuzzed parser looks their names up and runs none.
#include "app/comparison/estimators/fits.hpp"
#include "app/comparison/estimators/method_scene.hpp"
#include "app/comparison/estimators/peers.hpp"

namespace ballservo {

std::optional<MethodFit> fit_vote(MethodScene&) { return std::nullopt; }
std::optional<MethodFit> fit_paper_steps(MethodScene&, int, bool) { return std::nullopt; }
std::optional<MethodFit> fit_sphere_steps(MethodScene&, int) { return std::nullopt; }
std::optional<MethodFit> fit_paper_converged(MethodScene&, bool) { return std::nullopt; }
std::optional<MethodFit> fit_sphere_converged(MethodScene&, bool) { return std::nullopt; }
std::optional<MethodFit> fit_kasa(MethodScene&) { return std::nullopt; }
std::optional<MethodFit> fit_taubin(MethodScene&) { return std::nullopt; }
std::optional<MethodFit> fit_hough_circles(MethodScene&, const HoughSettings&) { return std::nullopt; }
std::optional<MethodFit> fit_hsv_contour(MethodScene&) { return std::nullopt; }
std::optional<MethodFit> fit_vpdot2(MethodScene&) { return std::nullopt; }
std::vector<MethodFit> detect_hough_gradient(MethodScene&) { return {}; }
std::vector<MethodFit> detect_hsv_contour(MethodScene&) { return {}; }
std::vector<MethodFit> MethodScene::detections(BallFit) { return {}; }

}  // namespace ballservo
