#include "app/scenario/beliefs.hpp"

#include "calibration/base/numbers.hpp"
#include "calibration/base/options.hpp"

namespace ballservo {

Camera Beliefs::camera(const Camera& truth) const {
  if (focal_scale == 1) return truth;
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

void declare(OptionVisitor& v, Beliefs& beliefs, double latency_s) {
  const NumberRange scale = NumberRange::within(0.2, 5, "");
  v.number("focal_scale", beliefs.focal_scale, scale, "believed focal lengths over the true ones");
  v.number("diameter_scale", beliefs.diameter_scale, scale,
           "believed diameter of the target over the true one");
  v.number("pitch_error_rad", beliefs.pitch_error_rad, NumberRange::within(-0.5, 0.5, "rad"),
           "believed less true, of the camera's mount");
  v.number("forward_error_m", beliefs.forward_error_m, NumberRange::within(-0.5, 0.5, "m"),
           "believed less true, of the camera's mount");
  v.number("up_error_m", beliefs.up_error_m, NumberRange::within(-0.2, 0.5, "m"),
           "believed less true, of the camera's mount");
  v.number("latency_error_s", beliefs.latency_error_s, NumberRange::within(-2, 2, "s"),
           "believed less true, of the camera's latency");
  v.require(latency_s + beliefs.latency_error_s >= 0, "latency_error_s", number_text(beliefs.latency_error_s),
            "at least -camera.latency_s: a latency is not negative");
}

}  // namespace ballservo
