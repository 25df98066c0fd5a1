#include "app/comparison/pictures/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "app/comparison/pictures/plan_design.hpp"
#include "app/comparison/pictures/rendered_frame.hpp"
#include "calibration/base/system_file.hpp"
#include "calibration/camera/files/camera_file.hpp"

namespace ballservo {
namespace {

constexpr long long most_plan_frames = 1000000000;

// Measured: what a picture of 640x480 with all methods takes on one core, and what its rows need.
constexpr double seconds_a_frame = 0.15, seconds_a_view = 0.12, seconds_a_condition = 1.5, bytes_a_fit = 230;
constexpr double usual_pixels = 640.0 * 480.0;

bool is_name(const std::string& name) {
  return !name.empty() && name.size() <= 64 &&
         name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
}

// A camera as a condition names it: by its file, or by its numbers.
struct PlanCamera {
  std::string file;
  double focal_px = 0;
  int width_px = 640, height_px = 480;
  LensModel model = LensModel::pinhole;
  std::vector<double> coefficients{};
};

void declare(OptionVisitor& v, PlanCamera& camera) {
  v.text("file", camera.file, "camera file beside the plan, instead of numbers", otherwise("none"));
  v.only_if(camera.file.empty(), "no file", [&] {
    v.number("focal_px", camera.focal_px, NumberRange::within(20, 1e5, "px"), "focal length", required);
    v.integer("width_px", camera.width_px, 64, 8192, "width of the picture");
    v.integer("height_px", camera.height_px, 64, 8192, "height of the picture");
    v.one_of("model", camera.model, names_of(all_lens_models, lens_model_name), "lens model");
    const auto count = static_cast<std::size_t>(coefficient_count(camera.model));
    v.only_if(count > 0, "a model with any", [&] {
      v.numbers("coefficients", camera.coefficients, NumberRange::within(-100, 100, ""), count,
                "of the lens model, all of them", required);
    });
  });
}

struct PlanCondition {
  ComparisonCondition condition;
  std::optional<PlanCamera> camera{};  // nothing: as in the defaults
};

void declare(OptionVisitor& v, PlanCondition& plan) {
  v.maybe("camera", plan.camera,
          [&](const std::string& key, PlanCamera& camera) { v.map(key, [&] { declare(v, camera); }); });
  declare(v, plan.condition);
}

// A plan as its file says it.
struct PlanFile {
  std::uint64_t seed = 0;
  std::vector<std::string> methods{};
  RobustLoss loss = ComparisonPlan{}.loss;
  std::string claims{};
  PlanCondition defaults{};
  std::vector<PlanCondition> conditions{};
  std::optional<PlanDesign> design{};
};

void declare(OptionVisitor& v, PlanFile& plan) {
  v.integer("seed", plan.seed, 0, 1LL << 53, "of everything random");
  v.texts("methods", plan.methods, "names of methods", otherwise("all"));
  v.map("robust", [&] {
    v.one_of("loss", plan.loss.kind,
             {{"huber", RobustLossKind::huber},
              {"cauchy", RobustLossKind::cauchy},
              {"tukey", RobustLossKind::tukey}},
             "of the robust methods");
    v.number("scale_px", plan.loss.scale_px, NumberRange::above(0, 100, "px"),
             "residuals beyond it count less");
  });
  if (v.present("claims", false))
    v.choice("claims", plan.claims, {"paper"}, "the paper's claims are looked at one by one",
             otherwise("none"));
  v.integer("frames", plan.defaults.condition.frames, 1, most_plan_frames, "pictures of each condition");
  v.map("defaults", [&] { declare(v, plan.defaults); });
  const bool designed = v.present("design", false);
  v.list("conditions", 0, designed ? Fallback{} : required, [&](std::size_t) {
    PlanCondition& condition = plan.conditions.emplace_back(PlanCondition{plan.defaults.condition});
    v.text("name", condition.condition.name, "1 to 64 of a-z, 0-9 and _", required);
    declare(v, condition);
  });
  v.require(!plan.conditions.empty() || !v.present("conditions", false), "conditions", "none",
            "at least one condition");
  v.require(static_cast<double>(plan.conditions.size()) <= most_conditions, "conditions",
            std::to_string(plan.conditions.size()), fmt::format("at most {:g}", most_conditions));
  v.maybe("design", plan.design, [&](const std::string& key, PlanDesign& design) {
    v.map(key, [&] { declare(v, design, plan.defaults.condition); });
  });
}

// Gives a condition the camera that its `node` names; its covariance stands beside its file.
void set_camera(ComparisonCondition& condition, const PlanCamera& plan, YamlNode node,
                const std::filesystem::path& folder, std::vector<std::filesystem::path>& files,
                FaultList& faults) {
  condition.covariance.reset();
  try {
    if (!plan.file.empty()) {
      const std::string path = (folder / plan.file).string();
      files.emplace_back(split_camera_name(path).file);
      condition.camera = read_camera(path);
      condition.covariance = read_camera_covariance(path, condition.camera);
      return;
    }
    CameraParameters parameters;
    parameters.fx_px = parameters.fy_px = plan.focal_px;
    parameters.size = {plan.width_px, plan.height_px};
    parameters.cx_px = (plan.width_px - 1) / 2.0;
    parameters.cy_px = (plan.height_px - 1) / 2.0;
    parameters.model = plan.model;
    std::copy(plan.coefficients.begin(), plan.coefficients.end(), parameters.coefficients.begin());
    condition.camera = Camera(parameters, node.place("camera"));
  } catch (const InputError& error) {
    if (plan.file.empty()) return;  // a number that has its fault already
    const std::string place = node.map("camera").place("file");
    for (const Fault& fault : error.faults())
      faults.add(place + ": " + fault.place, fault.found, fault.allowed);
  }
}

// All methods where none is named.
MethodList find_methods(const std::vector<std::string>& names, YamlNode root) {
  MethodList methods;
  std::string allowed = "each of them once:";
  for (const FitMethod& method : fit_methods()) allowed += " " + method.name;
  for (const std::string& name : names) {
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

// The camera of a picture whose size is `factor` times as large.
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
  condition.ring_clutter = std::round(condition.ring_clutter);
  condition.same_color = std::round(condition.same_color);
  condition.camera = scaled_camera(condition.camera, condition.resolution);
  if (condition.covariance && condition.resolution != 1) {
    for (int row = 0; row < 4; ++row) {  // focal lengths and principal point are in pixels
      condition.covariance->row(row) *= condition.resolution;
      condition.covariance->col(row) *= condition.resolution;
    }
  }
  if (const std::string reason = why_not_rendered(condition); !reason.empty()) {
    faults.add(
        place, reason + " (" + condition.name + ")",
        "a ball that is wholly in the picture and in front of the camera, and settings that its painter "
        "knows");
  }
}

}  // namespace

ComparisonPlan parse_comparison_plan(const std::string& text, const std::string& name,
                                     const std::filesystem::path& folder) {
  StrictYaml document = StrictYaml::from_text(text, name);
  YamlNode root = document.root();
  FaultList& faults = document.faults();
  OptionReader reader(document, root);
  PlanFile file;
  declare(reader, file);

  ComparisonPlan plan;
  plan.seed = file.seed;
  plan.methods = find_methods(file.methods, root);
  plan.loss = file.loss;
  plan.paper_claims = file.claims == "paper";
  ComparisonCondition& defaults = file.defaults.condition;
  if (file.defaults.camera)
    set_camera(defaults, *file.defaults.camera, root.map("defaults"), folder, plan.files, faults);
  std::set<std::string> names;
  const auto add = [&](ComparisonCondition condition, const YamlNode& node) {
    finish_condition(node.place(), faults, names, condition);
    plan.conditions.push_back(std::move(condition));
  };
  if (static_cast<double>(file.conditions.size()) > most_conditions) file.conditions.clear();
  const std::vector<YamlNode> nodes =
      file.conditions.empty() ? std::vector<YamlNode>{} : root.list("conditions");
  for (std::size_t k = 0; k < file.conditions.size(); ++k) {
    auto& [condition, camera] = file.conditions[k];
    condition.camera = defaults.camera;
    condition.covariance = defaults.covariance;
    if (camera) set_camera(condition, *camera, nodes[k], folder, plan.files, faults);
    add(std::move(condition), nodes[k]);
  }
  if (file.design) {
    YamlNode node = root.map("design");
    for (ComparisonCondition& condition : designed_conditions(*file.design, node, defaults, plan.seed))
      add(std::move(condition), node);
  }
  document.finish();
  plan.text = text;
  plan.resolved_json = document.resolved_json();
  return plan;
}

ComparisonPlan read_comparison_plan(const std::filesystem::path& file) {
  return parse_comparison_plan(read_file_bytes(file, StrictYaml::max_bytes), file.string(),
                               file.parent_path());
}

std::vector<OptionRow> plan_keys() {
  PlanFile plan;
  OptionLister lister;
  declare(lister, plan);
  return lister.rows();
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
