#include "app/comparison/pictures/condition.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <set>

#include "calibration/camera/sphere_outline.hpp"
#include "calibration/color/color_names.hpp"

namespace ballservo {
namespace {

std::string occlusion_words(const ComparisonCondition& condition) {
  constexpr std::array<const char*, 5> sides{"", " on the left", " on the right", " below", " above"};
  return fmt::format("{:.0f} % hidden{}", 100 * condition.occlusion,
                     sides[static_cast<std::size_t>(condition.occlusion_side)]);
}

}  // namespace

void declare(OptionVisitor& v, ComparisonCondition& c) {
  const NumberRange share = NumberRange::within(0, 1, ""), start_px = NumberRange::within(0, 50, "px");
  v.integer("frames", c.frames, 1, 1000000000, "pictures of the condition");
  if (v.present("pictures", false)) {
    v.map("pictures", [&] {
      v.one_of("type", c.painter,
               {{"lab", Painter::lab}, {"room", Painter::room}, {"painted", Painter::painted}},
               "rendered in a lab, rendered in a room, or painted without the renderer", required);
      v.boolean("half_shade", c.look.half_shade, "painted: half of the ball lies in shade");
      v.boolean("highlight", c.look.highlight, "painted: a glossy ball");
      v.boolean("marbled", c.look.marbled, "painted: a marbled ball");
      v.boolean("contact_shadow", c.look.contact_shadow, "painted: a shadow where it touches the floor");
    });
  }
  v.number("depth_m", c.depth_m, NumberRange::above(0, 100, "m"), "distance Z");
  v.number("off_axis_rad", c.off_axis_rad, NumberRange::within(0, 1.2, "rad"), "angle off the axis");
  v.number("occlusion", c.occlusion, NumberRange::within(0, 0.8, ""), "hidden part of the disc");
  v.one_of("occlusion_side", c.occlusion_side,
           {{"any", OcclusionSide::any},
            {"left", OcclusionSide::left},
            {"right", OcclusionSide::right},
            {"below", OcclusionSide::below},
            {"above", OcclusionSide::above}},
           "where it is hidden, as the picture shows it");
  declare(v, c.sensor);
  v.number("motion_blur_px", c.motion_blur_px, NumberRange::within(0, 40, "px"), "motion while exposed");
  v.map("light", [&] {
    v.number("level", c.light_level, NumberRange::above(0, 10, ""), "light, of the usual");
    v.maybe("angle_rad", c.light_angle_rad, [&](const std::string& key, double& angle_rad) {
      v.number(key, angle_rad, NumberRange::within(0, 2, "rad"), "lamp's angle from the camera",
               otherwise("by chance"));
    });
  });
  v.one_of("background", c.background,
           {{"clutter", ComparisonBackground::clutter}, {"plain", ComparisonBackground::plain}},
           "textured walls and boxes, or walls of one colour");
  v.number("contrast", c.contrast, share, "contrast to the background: 0 is the ball's own colour");
  v.number("ring_clutter", c.ring_clutter, NumberRange::within(0, 20, "boxes"), "edges across the outline");
  v.number("same_color", c.same_color, NumberRange::within(0, 20, "things"), "things of the ball's colour");
  v.boolean("touching", c.touching, "a bar of the ball's colour touches it");
  bool no_ball = !c.has_ball;
  v.boolean("no_ball", no_ball, "room and painted: only what may be taken for a ball");
  c.has_ball = !no_ball;
  v.boolean("at_border", c.at_border, "room and painted: the ball's centre lies near the picture's border");
  v.maybe("start", c.start, [&](const std::string& key, StartError& start) {
    v.map(key, [&] {
      v.number("center_px", start.center_px, start_px, "start's error, centre: sigma, from the truth");
      v.number("radius_px", start.radius_px, start_px, "start's error, radius: sigma, from the truth");
    });
  });
  v.map("ball", [&] {
    v.choice("color", c.ball_color, color_words(), "a colour word");
    v.number("diameter_m", c.diameter_m, NumberRange::above(0, 10, "m"), "ball's diameter");
    v.one_of("pattern", c.ball_pattern, names_of(all_patterns, pattern_name), "what is painted on it");
  });
  v.number("resolution", c.resolution, NumberRange::within(0.1, 4, ""), "resolution, of the camera's");
  v.number("calibration_sigmas", c.calibration_sigmas, NumberRange::within(0, 100, "sigmas"),
           "calibration error: drawn from the covariance beside the camera's file");
}

std::optional<ConditionNumber> find_number(ComparisonCondition condition, const std::string& key) {
  static const std::set<std::string> log{"depth_m", "light.level", "ball.diameter_m", "resolution"};
  std::optional<ConditionNumber> found;
  NumberFinder finder(key, [&](double value, const Option& option) {
    const std::string unit = option.range.unit.empty() ? "" : " (" + option.range.unit + ")";
    const std::string label = option.help.substr(0, option.help.find(':')) + unit;
    found = {value, option.range, label, log.count(key) > 0};
  });
  declare(finder, condition);
  return found;
}

void set_number(ComparisonCondition& condition, const std::string& key, double value) {
  NumberFinder finder(key, [value](double& number, const Option&) { number = value; });
  declare(finder, condition);
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
  say(condition.painter == Painter::room, "in a room");
  say(condition.painter == Painter::painted, "painted");
  say(condition.look.half_shade, "half of it in shade");
  say(condition.look.highlight, "glossy");
  say(condition.look.marbled, "marbled");
  say(condition.look.contact_shadow, "contact shadow");
  say(condition.at_border, "half outside the picture");
  say(!condition.has_ball, "without the ball");
  if (condition.start)
    say(true, fmt::format("fits start off the truth by {:g} px, radius {:g} px (sigma)",
                          condition.start->center_px, condition.start->radius_px));
  say(condition.calibration_sigmas > 0,
      fmt::format("the camera off by {:g} sigma", condition.calibration_sigmas));
  return text;
}

}  // namespace ballservo
