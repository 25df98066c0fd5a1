#include "app/scenario/beliefs.hpp"

#include "calibration/base/numbers.hpp"

namespace ballservo {

Camera Beliefs::camera(const Camera& truth) const {
  CameraParameters parameters = truth.parameters();
  parameters.fx_px *= focal_scale;
  parameters.fy_px *= focal_scale;
  return Camera(parameters, "believed camera");
}

CameraMount Beliefs::mount(const CameraMount& truth) const {
  CameraMount mount = truth;
  mount.forward_m += forward_error_m;
  mount.up_m += up_error_m;
  mount.pitch_down_rad += pitch_error_rad;
  return mount;
}

Beliefs read_beliefs(YamlNode root, double latency_s) {
  YamlNode node = root.map("believed", false);
  Beliefs beliefs;
  const NumberRange scale = NumberRange::within(0.2, 5, "");
  beliefs.focal_scale = node.number("focal_scale", scale, 1.0);
  beliefs.diameter_scale = node.number("diameter_scale", scale, 1.0);
  beliefs.pitch_error_rad = node.number("pitch_error_rad", NumberRange::within(-0.5, 0.5, "rad"), 0.0);
  beliefs.forward_error_m = node.number("forward_error_m", NumberRange::within(-0.5, 0.5, "m"), 0.0);
  beliefs.up_error_m = node.number("up_error_m", NumberRange::within(-0.2, 0.5, "m"), 0.0);
  beliefs.latency_error_s = node.number("latency_error_s", NumberRange::within(-2, 2, "s"), 0.0);
  if (latency_s + beliefs.latency_error_s < 0) {
    node.fault("latency_error_s", number_text(beliefs.latency_error_s),
               "at least -camera.latency_s: a latency is not negative");
  }
  return beliefs;
}

}  // namespace ballservo
