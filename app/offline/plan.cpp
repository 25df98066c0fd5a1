#include "app/offline/plan.hpp"

#include <algorithm>
#include <set>

#include "app/offline/rendered_frame.hpp"
#include "calibration/camera/camera_file.hpp"
#include "calibration/color/color_names.hpp"
#include "calibration/files/image_file.hpp"
#include "calibration/files/numbers.hpp"

namespace ballservo {
namespace {

constexpr double largest_angle_rad = 1.2;
constexpr int most_frames = 100000;
constexpr std::size_t most_conditions = 1000;

bool is_name(const std::string& name) {
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

void read_camera_key(YamlNode node, const std::filesystem::path& folder, FaultList& faults, Camera& camera) {
  if (!node.has("camera")) return;
  YamlNode map = node.map("camera");
  if (map.has("file")) {
    const std::string file = map.text("file");
    if (file.empty()) return;
    try {
      camera = read_camera((folder / file).string());
    } catch (const InputError& error) {
      for (const Fault& fault : error.faults())
        faults.add(map.place("file") + ": " + fault.place, fault.found, fault.allowed);
    }
    return;
  }
  CameraParameters parameters;
  parameters.model = LensModel::pinhole;
  parameters.fx_px = parameters.fy_px = map.number("focal_px", NumberRange::within(20, 1e5, "px"));
  parameters.size.width_px = static_cast<int>(map.integer("width_px", 64, 8192, 640));
  parameters.size.height_px = static_cast<int>(map.integer("height_px", 64, 8192, 480));
  parameters.cx_px = (parameters.size.width_px - 1) / 2.0;
  parameters.cy_px = (parameters.size.height_px - 1) / 2.0;
  try {
    camera = Camera(parameters, map.place());
  } catch (const InputError&) {
    // The focal length has its fault already; the sizes are in range.
  }
}

void read_condition(YamlNode node, const std::filesystem::path& folder, FaultList& faults,
                    ComparisonCondition& condition) {
  condition.frames = static_cast<int>(node.integer("frames", 1, most_frames, condition.frames));
  read_camera_key(node, folder, faults, condition.camera);
  if (node.has("ball")) {
    YamlNode ball = node.map("ball");
    condition.ball_color = ball.choice("color", color_words(), condition.ball_color);
    condition.diameter_m = ball.number("diameter_m", {0, 10, true, false, "m"}, condition.diameter_m);
  }
  condition.depth_m = node.number("depth_m", {0, 100, true, false, "m"}, condition.depth_m);
  condition.off_axis_rad =
      node.number("off_axis_rad", NumberRange::within(0, largest_angle_rad, "rad"), condition.off_axis_rad);
  condition.occlusion = node.number("occlusion", NumberRange::within(0, 0.8, ""), condition.occlusion);
  const bool plain = condition.background == ComparisonBackground::plain;
  condition.background =
      node.choice("background", {"clutter", "plain"}, plain ? "plain" : "clutter") == "plain"
          ? ComparisonBackground::plain
          : ComparisonBackground::clutter;
  if (node.has("noise")) {
    YamlNode noise = node.map("noise");
    condition.sensor.read_noise =
        noise.number("read", NumberRange::within(0, 255, "grey levels"), condition.sensor.read_noise);
    condition.sensor.shot_noise =
        noise.number("shot", NumberRange::within(0, 255, "grey levels"), condition.sensor.shot_noise);
  }
  condition.sensor.blur_px =
      node.number("blur_px", NumberRange::within(0, 20, "px"), condition.sensor.blur_px);
  condition.sensor.gain = node.number("gain", {0, 100, true, false, ""}, condition.sensor.gain);
  condition.sensor.gamma = node.number("gamma", NumberRange::within(1, 3, ""), condition.sensor.gamma);
}

std::vector<FitMethod> read_methods(YamlNode root) {
  std::vector<FitMethod> methods;
  std::string allowed = "each of them once:";
  for (const FitMethod method : all_fit_methods) allowed += " " + std::string(fit_method_name(method));
  for (YamlNode item : root.list("methods")) {
    const std::string name = item.as_text();
    const auto method = fit_method_from_name(name);
    if (!method || std::count(methods.begin(), methods.end(), *method) > 0) {
      root.fault("methods", name, allowed);
    } else {
      methods.push_back(*method);
    }
  }
  if (methods.empty()) methods.assign(all_fit_methods.begin(), all_fit_methods.end());
  return methods;
}

ComparisonPlan read_plan(StrictYaml document, const std::filesystem::path& folder) {
  YamlNode root = document.root();
  ComparisonPlan plan;
  plan.seed = static_cast<std::uint64_t>(root.integer("seed", 0, 1LL << 53, 0));
  plan.methods = read_methods(root);
  ComparisonCondition defaults;
  defaults.frames = static_cast<int>(root.integer("frames", 1, most_frames, defaults.frames));
  if (root.has("defaults")) read_condition(root.map("defaults"), folder, document.faults(), defaults);

  std::vector<YamlNode> nodes = root.list("conditions", true);
  if (nodes.empty() && root.has("conditions")) root.fault("conditions", "none", "at least one condition");
  if (nodes.size() > most_conditions) {
    root.fault("conditions", std::to_string(nodes.size()), "at most " + std::to_string(most_conditions));
    nodes.clear();
  }
  std::set<std::string> names;
  for (YamlNode& node : nodes) {
    ComparisonCondition condition = defaults;
    condition.name = node.text("name");
    if (!is_name(condition.name)) {
      node.fault("name", "'" + condition.name + "'", "1 to 64 of a-z, 0-9 and _");
    } else if (!names.insert(condition.name).second) {
      node.fault("name", "'" + condition.name + "' again", "a name for each condition of its own");
    }
    read_condition(node, folder, document.faults(), condition);
    if (const std::string reason = why_not_rendered(condition); !reason.empty()) {
      document.faults().add(node.place(), reason,
                            "a ball that is wholly in the picture and in front of the camera");
    }
    plan.conditions.push_back(std::move(condition));
  }
  document.finish();
  plan.resolved_json = document.resolved_json();
  return plan;
}

}  // namespace

ComparisonPlan read_comparison_plan(const std::filesystem::path& file) {
  return read_plan(StrictYaml::from_file(file), file.parent_path());
}

ComparisonPlan parse_comparison_plan(const std::string& text, const std::string& name,
                                     const std::filesystem::path& folder) {
  return read_plan(StrictYaml::from_text(text, name), folder);
}

}  // namespace ballservo
