#include "app/comparison/pictures/condition.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

using C = ComparisonCondition;

std::vector<ConditionFactor> make_factors() {
  const NumberRange share = NumberRange::within(0, 1, ""), px = NumberRange::within(0, 20, "px"),
                    levels = NumberRange::within(0, 255, "grey levels");
  return {
      {"depth_m",
       "distance Z (m)",
       {0, 100, true, false, "m"},
       [](const C& c) { return c.depth_m; },
       [](C& c, double x) { c.depth_m = x; },
       true},
      {"off_axis_rad", "angle off the axis (rad)", NumberRange::within(0, 1.2, "rad"),
       [](const C& c) { return c.off_axis_rad; }, [](C& c, double x) { c.off_axis_rad = x; }},
      {"occlusion", "hidden part of the disc", NumberRange::within(0, 0.8, ""),
       [](const C& c) { return c.occlusion; }, [](C& c, double x) { c.occlusion = x; }},
      {"blur_px", "blur, sigma (px)", px, [](const C& c) { return c.sensor.blur_px; },
       [](C& c, double x) { c.sensor.blur_px = x; }},
      {"motion_blur_px", "motion while exposed (px)", NumberRange::within(0, 40, "px"),
       [](const C& c) { return c.motion_blur_px; }, [](C& c, double x) { c.motion_blur_px = x; }},
      {"noise.read", "noise, sigma (grey levels)", levels, [](const C& c) { return c.sensor.read_noise; },
       [](C& c, double x) { c.sensor.read_noise = x; }},
      {"noise.shot", "shot noise (grey levels)", levels, [](const C& c) { return c.sensor.shot_noise; },
       [](C& c, double x) { c.sensor.shot_noise = x; }},
      {"light.level",
       "light (of the usual)",
       {0, 10, true, false, ""},
       [](const C& c) { return c.light_level; },
       [](C& c, double x) { c.light_level = x; },
       true},
      {"light.angle_rad", "lamp's angle from the camera (rad)", NumberRange::within(0, 2, "rad"),
       [](const C& c) { return c.light_angle_rad.value_or(std::nan("")); },
       [](C& c, double x) { c.light_angle_rad = x; }},
      {"contrast", "contrast to the background", share, [](const C& c) { return c.contrast; },
       [](C& c, double x) { c.contrast = x; }},
      {"ring_clutter", "edges across the outline", NumberRange::within(0, 20, "boxes"),
       [](const C& c) { return c.ring_clutter; }, [](C& c, double x) { c.ring_clutter = std::round(x); }},
      {"same_color", "things of the ball's colour", NumberRange::within(0, 20, "things"),
       [](const C& c) { return c.same_color; }, [](C& c, double x) { c.same_color = std::round(x); }},
      {"start.center_px", "start's error, centre (px)", NumberRange::within(0, 50, "px"),
       [](const C& c) { return c.start_center_px; },
       [](C& c, double x) {
         c.start_at_truth = true;
         c.start_center_px = x;
       }},
      {"start.radius_px", "start's error, radius (px)", NumberRange::within(0, 50, "px"),
       [](const C& c) { return c.start_radius_px; },
       [](C& c, double x) {
         c.start_at_truth = true;
         c.start_radius_px = x;
       }},
      {"ball.diameter_m",
       "ball's diameter (m)",
       {0, 10, true, false, "m"},
       [](const C& c) { return c.diameter_m; },
       [](C& c, double x) { c.diameter_m = x; },
       true},
      {"resolution", "resolution (of the camera's)", NumberRange::within(0.1, 4, ""),
       [](const C& c) { return c.resolution; }, [](C& c, double x) { c.resolution = x; }, true},
      {"calibration_sigmas", "calibration error (sigmas)", NumberRange::within(0, 100, "sigmas"),
       [](const C& c) { return c.calibration_sigmas; }, [](C& c, double x) { c.calibration_sigmas = x; }},
      {"gain",
       "gain",
       {0, 100, true, false, ""},
       [](const C& c) { return c.sensor.gain; },
       [](C& c, double x) { c.sensor.gain = x; }},
      {"gamma", "the camera's gamma", NumberRange::within(1, 3, ""),
       [](const C& c) { return c.sensor.gamma; }, [](C& c, double x) { c.sensor.gamma = x; }},
  };
}

std::string occlusion_words(const ComparisonCondition& condition) {
  constexpr std::array<const char*, 5> sides{"", " on the left", " on the right", " below", " above"};
  return fmt::format("{:.0f} % hidden{}", 100 * condition.occlusion,
                     sides[static_cast<std::size_t>(condition.occlusion_side)]);
}

// Painter and look; nothing for the lab's pictures.
std::string picture_words(const ComparisonCondition& condition) {
  if (condition.painter == Painter::lab) return "";
  std::string text = condition.painter == Painter::room ? ", in a room" : ", painted";
  if (condition.look.half_shade) text += ", half of it in shade";
  if (condition.look.highlight) text += ", glossy";
  if (condition.look.marbled) text += ", marbled";
  if (condition.look.contact_shadow) text += ", contact shadow";
  if (condition.at_border) text += ", half outside the picture";
  return text;
}

}  // namespace

const std::vector<ConditionFactor>& condition_factors() {
  static const std::vector<ConditionFactor> factors = make_factors();
  return factors;
}

const ConditionFactor* find_condition_factor(std::string_view key) {
  for (const ConditionFactor& factor : condition_factors()) {
    if (factor.key == key) return &factor;
  }
  return nullptr;
}

std::string in_words(const ComparisonCondition& condition) {
  const auto outline = project_sphere(condition.camera, {0, 0, condition.depth_m}, condition.radius_m());
  std::string text =
      fmt::format("{} ball of {:g} mm, {:.0f} px across, Z = {:g} m, f = {:.0f} px", condition.ball_color,
                  1000 * condition.diameter_m, outline ? 2 * outline->radius_px : 0.0, condition.depth_m,
                  condition.camera.focal_px());
  const auto say = [&](bool unusual, const std::string& words) {
    if (unusual) text += ", " + words;
  };
  const LensModel model = condition.camera.parameters().model;
  say(model != LensModel::pinhole, std::string(lens_model_name(model)) + " lens");
  say(condition.off_axis_rad > 0,
      fmt::format("{:.0f} deg off the axis", condition.off_axis_rad * 180 / M_PI));
  say(condition.occlusion > 0, occlusion_words(condition));
  say(true,
      fmt::format("noise sigma {:g}, blur {:g} px", condition.sensor.read_noise, condition.sensor.blur_px));
  say(condition.motion_blur_px > 0, fmt::format("moves {:g} px while exposed", condition.motion_blur_px));
  say(condition.ball_pattern != Pattern::plain, std::string(pattern_name(condition.ball_pattern)) + " on it");
  say(condition.light_level != 1, fmt::format("{:g} times the light", condition.light_level));
  say(condition.light_angle_rad.has_value(),
      fmt::format("lamp {:.0f} deg from the camera", condition.light_angle_rad.value_or(0) * 180 / M_PI));
  say(condition.contrast != 1, fmt::format("contrast {:g}", condition.contrast));
  say(condition.ring_clutter > 0, fmt::format("{:g} boxes across its outline", condition.ring_clutter));
  say(condition.same_color > 0, fmt::format("{:g} things of its colour", condition.same_color));
  say(condition.touching, "a bar of its colour touches it");
  text += picture_words(condition);
  say(!condition.has_ball, "without the ball");
  say(condition.start_at_truth, fmt::format("fits start off the truth by {:g} px, radius {:g} px (sigma)",
                                            condition.start_center_px, condition.start_radius_px));
  say(condition.calibration_sigmas > 0,
      fmt::format("the camera off by {:g} sigma", condition.calibration_sigmas));
  return text;
}

Camera scaled_camera(const Camera& camera, double factor) {
  if (factor == 1) return camera;
  CameraParameters p = camera.parameters();
  const auto scaled = [&](int size) { return std::max(1, static_cast<int>(std::lround(size * factor))); };
  p.size = {scaled(p.size.width_px), scaled(p.size.height_px)};
  p.fx_px *= factor;
  p.fy_px *= factor;
  p.cx_px = (p.cx_px + 0.5) * factor - 0.5;
  p.cy_px = (p.cy_px + 0.5) * factor - 0.5;
  return Camera(p);
}

}  // namespace ballservo
