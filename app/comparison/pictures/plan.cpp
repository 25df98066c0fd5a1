#include "app/comparison/pictures/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "app/comparison/pictures/plan_design.hpp"
#include "app/comparison/pictures/rendered_frame.hpp"
#include "calibration/base/system_file.hpp"
#include "calibration/camera/files/camera_file.hpp"
#include "calibration/color/color_names.hpp"

namespace ballservo {
namespace {

constexpr long long most_frames = 1000000000;

// Measured: what a picture of 640x480 with all methods takes on one core, and what its rows need.
constexpr double seconds_a_frame = 0.15, seconds_a_view = 0.12, seconds_a_condition = 1.5, bytes_a_fit = 230;
constexpr double usual_pixels = 640.0 * 480.0;

bool is_name(const std::string& name) {
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

void read_camera_file(YamlNode& map, const std::filesystem::path& folder, FaultList& faults,
                      ComparisonCondition& condition) {
  const std::string file = map.text("file");
  if (file.empty()) return;
  try {
    const std::string path = (folder / file).string();
    condition.camera = read_camera(path);
    condition.covariance = read_camera_covariance(path, condition.camera);
  } catch (const InputError& error) {
    for (const Fault& fault : error.faults())
      faults.add(map.place("file") + ": " + fault.place, fault.found, fault.allowed);
  }
}

void read_camera_key(YamlNode node, const std::filesystem::path& folder, FaultList& faults,
                     ComparisonCondition& condition) {
  if (!node.has("camera")) return;
  YamlNode map = node.map("camera");
  condition.covariance.reset();
  if (map.has("file")) {
    read_camera_file(map, folder, faults, condition);
    return;
  }
  CameraParameters parameters;
  parameters.fx_px = parameters.fy_px = map.number("focal_px", NumberRange::within(20, 1e5, "px"));
  parameters.size.width_px = static_cast<int>(map.integer("width_px", 64, 8192, 640));
  parameters.size.height_px = static_cast<int>(map.integer("height_px", 64, 8192, 480));
  parameters.cx_px = (parameters.size.width_px - 1) / 2.0;
  parameters.cy_px = (parameters.size.height_px - 1) / 2.0;
  std::vector<std::string> models;
  for (const LensModel model : all_lens_models) models.emplace_back(lens_model_name(model));
  parameters.model = *lens_model_from_name(map.choice("model", models, "pinhole"));
  const auto count = static_cast<std::size_t>(coefficient_count(parameters.model));
  if (count > 0) {
    const std::vector<double> coefficients =
        map.numbers("coefficients", NumberRange::within(-100, 100, ""), count);
    if (coefficients.size() == count)
      std::copy(coefficients.begin(), coefficients.end(), parameters.coefficients.begin());
  }
  try {
    condition.camera = Camera(parameters, map.place());
  } catch (const InputError&) {
    // The focal length has its fault already; the sizes are in range.
  }
}

// The numbers that a condition shares with designs: `noise.read` is `read` below `noise`.
void read_factors(YamlNode& node, ComparisonCondition& condition) {
  for (const ConditionFactor& factor : condition_factors()) {
    const std::size_t dot = factor.key.find('.');
    const std::string first = factor.key.substr(0, dot);
    if (!node.has(first)) continue;
    if (dot == std::string::npos) {
      factor.set(condition, node.number(first, factor.range, factor.get(condition)));
      continue;
    }
    YamlNode below = node.map(first);
    const std::string second = factor.key.substr(dot + 1);
    if (below.has(second)) factor.set(condition, below.number(second, factor.range, 0.0));
  }
}

void read_pictures(YamlNode map, ComparisonCondition& condition) {
  const std::vector<std::string> painters{"lab", "room", "painted"};
  const std::string type = map.choice("type", painters);
  condition.painter =
      static_cast<Painter>(std::find(painters.begin(), painters.end(), type) - painters.begin());
  PaintedLook& look = condition.look;
  look.half_shade = map.boolean("half_shade", look.half_shade);
  look.highlight = map.boolean("highlight", look.highlight);
  look.marbled = map.boolean("marbled", look.marbled);
  look.contact_shadow = map.boolean("contact_shadow", look.contact_shadow);
}

void read_condition(YamlNode node, const std::filesystem::path& folder, FaultList& faults,
                    ComparisonCondition& condition) {
  condition.frames = static_cast<int>(node.integer("frames", 1, most_frames, condition.frames));
  if (node.has("pictures")) read_pictures(node.map("pictures"), condition);
  read_camera_key(node, folder, faults, condition);
  read_factors(node, condition);
  if (node.has("ball")) {
    YamlNode ball = node.map("ball");
    condition.ball_color = ball.choice("color", color_words(), condition.ball_color);
    std::vector<std::string> patterns;
    for (const Pattern pattern : all_patterns) patterns.emplace_back(pattern_name(pattern));
    const std::string name =
        ball.choice("pattern", patterns, std::string(pattern_name(condition.ball_pattern)));
    for (const Pattern pattern : all_patterns) {
      if (pattern_name(pattern) == name) condition.ball_pattern = pattern;
    }
  }
  const std::vector<std::string> sides{"any", "left", "right", "below", "above"};
  const std::string side =
      node.choice("occlusion_side", sides, sides[static_cast<std::size_t>(condition.occlusion_side)]);
  condition.occlusion_side =
      static_cast<OcclusionSide>(std::find(sides.begin(), sides.end(), side) - sides.begin());
  const bool plain = condition.background == ComparisonBackground::plain;
  condition.background =
      node.choice("background", {"clutter", "plain"}, plain ? "plain" : "clutter") == "plain"
          ? ComparisonBackground::plain
          : ComparisonBackground::clutter;
  condition.touching = node.boolean("touching", condition.touching);
  condition.has_ball = !node.boolean("no_ball", !condition.has_ball);
  condition.at_border = node.boolean("at_border", condition.at_border);
}

MethodList read_methods(YamlNode root) {
  MethodList methods;
  std::string allowed = "each of them once:";
  for (const FitMethod& method : fit_methods()) allowed += " " + method.name;
  for (YamlNode item : root.list("methods")) {
    const std::string name = item.as_text();
    const FitMethod* method = find_fit_method(name);
    if (!method || std::count(methods.begin(), methods.end(), method) > 0) {
      root.fault("methods", name, allowed);
    } else {
      methods.push_back(method);
    }
  }
  if (methods.empty()) {
    for (const FitMethod& method : fit_methods()) methods.push_back(&method);
  }
  return methods;
}

RobustLoss read_loss(YamlNode root) {
  RobustLoss loss{RobustLossKind::cauchy, 0.3};
  if (!root.has("robust")) return loss;
  YamlNode node = root.map("robust");
  const std::string name = node.choice("loss", {"huber", "cauchy", "tukey"}, "cauchy");
  loss.kind = name == "huber"   ? RobustLossKind::huber
              : name == "tukey" ? RobustLossKind::tukey
                                : RobustLossKind::cauchy;
  loss.scale_px = node.number("scale_px", {0, 100, true, false, "px"}, loss.scale_px);
  return loss;
}

// What can only be told once a condition is whole.
void finish_condition(const std::string& place, FaultList& faults, std::set<std::string>& names,
                      ComparisonCondition& condition) {
  if (!is_name(condition.name)) {
    faults.add(place + ": name", "'" + condition.name + "'", "1 to 64 of a-z, 0-9 and _");
  } else if (!names.insert(condition.name).second) {
    faults.add(place + ": name", "'" + condition.name + "' again", "a name for each condition of its own");
  }
  if (condition.calibration_sigmas > 0 && !condition.covariance) {
    faults.add(place + ": calibration_sigmas", fmt::format("{:g}", condition.calibration_sigmas),
               "0, or a camera file with the covariance that `calibrate camera` writes beside it");
  }
  condition.camera = scaled_camera(condition.camera, condition.resolution);
  if (condition.covariance && condition.resolution != 1) {
    for (int row = 0; row < 4; ++row) {  // focal lengths and principal point are in pixels
      condition.covariance->covariance.row(row) *= condition.resolution;
      condition.covariance->covariance.col(row) *= condition.resolution;
    }
  }
  if (const std::string reason = why_not_rendered(condition); !reason.empty()) {
    faults.add(
        place, reason + " (" + condition.name + ")",
        "a ball that is wholly in the picture and in front of the camera, and settings that its painter "
        "knows");
  }
}

ComparisonPlan read_plan(const std::string& text, const std::string& name,
                         const std::filesystem::path& folder) {
  StrictYaml document = StrictYaml::from_text(text, name);
  YamlNode root = document.root();
  ComparisonPlan plan;
  plan.seed = static_cast<std::uint64_t>(root.integer("seed", 0, 1LL << 53, 0));
  plan.methods = read_methods(root);
  plan.loss = read_loss(root);
  plan.paper_claims = root.has("claims") && root.choice("claims", {"paper"}) == "paper";
  ComparisonCondition defaults;
  defaults.frames = static_cast<int>(root.integer("frames", 1, most_frames, defaults.frames));
  if (root.has("defaults")) read_condition(root.map("defaults"), folder, document.faults(), defaults);

  std::set<std::string> names;
  std::vector<YamlNode> nodes = root.list("conditions", !root.has("design"));
  if (nodes.empty() && root.has("conditions")) root.fault("conditions", "none", "at least one condition");
  if (static_cast<double>(nodes.size()) > most_conditions) {
    root.fault("conditions", std::to_string(nodes.size()), fmt::format("at most {:g}", most_conditions));
    nodes.clear();
  }
  for (YamlNode& node : nodes) {
    ComparisonCondition condition = defaults;
    condition.name = node.text("name");
    read_condition(node, folder, document.faults(), condition);
    finish_condition(node.place(), document.faults(), names, condition);
    plan.conditions.push_back(std::move(condition));
  }
  if (root.has("design")) {
    YamlNode design = root.map("design");
    for (ComparisonCondition& condition : designed_conditions(design, defaults, plan.seed)) {
      finish_condition(design.place(), document.faults(), names, condition);
      plan.conditions.push_back(std::move(condition));
    }
  }
  document.finish();
  plan.text = text;
  plan.resolved_json = document.resolved_json();
  return plan;
}

}  // namespace

ComparisonPlan read_comparison_plan(const std::filesystem::path& file) {
  return read_plan(read_file_bytes(file, StrictYaml::max_bytes), file.string(), file.parent_path());
}

ComparisonPlan parse_comparison_plan(const std::string& text, const std::string& name,
                                     const std::filesystem::path& folder) {
  return read_plan(text, name, folder);
}

PlanEstimate estimate(const ComparisonPlan& plan) {
  PlanEstimate sum;
  for (const ComparisonCondition& condition : plan.conditions) {
    const ImageSize size = condition.camera.size();
    const double pixels = static_cast<double>(size.width_px) * size.height_px / usual_pixels;
    const double views = condition.motion_blur_px > 0 ? motion_views : 1;
    sum.frames += condition.frames;
    sum.core_hours +=
        pixels * (seconds_a_condition + condition.frames * (seconds_a_frame + views * seconds_a_view)) / 3600;
    sum.disk_bytes += condition.frames * bytes_a_fit * static_cast<double>(plan.methods.size());
  }
  return sum;
}

std::string in_words(const PlanEstimate& estimate, int threads) {
  const double hours = estimate.core_hours / std::max(1, threads);
  const std::string time = hours < 1.0 / 60 ? fmt::format("{:.0f} s", 3600 * hours)
                           : hours < 1      ? fmt::format("{:.0f} minutes", 60 * hours)
                           : hours < 48     ? fmt::format("{:.1f} hours", hours)
                                            : fmt::format("{:.0f} days", hours / 24);
  const double mb = estimate.disk_bytes / 1e6;
  return fmt::format("{:.0f} frames: about {} on {} core{} and {} of disk", estimate.frames, time, threads,
                     threads == 1 ? "" : "s",
                     mb < 1000 ? fmt::format("{:.0f} MB", mb) : fmt::format("{:.1f} GB", mb / 1000));
}

}  // namespace ballservo
