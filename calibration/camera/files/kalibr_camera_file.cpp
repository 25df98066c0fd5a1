#include <fmt/format.h>

#include <algorithm>

#include "calibration/camera/files/camera_formats.hpp"
#include "calibration/camera/files/camera_yaml.hpp"

namespace ballservo {
namespace {

bool is_camera_name(std::string_view name) {
  return name.size() > 3 && name.substr(0, 3) == "cam" &&
         std::all_of(name.begin() + 3, name.end(), [](char c) { return c >= '0' && c <= '9'; });
}

bool is_kalibr_text(std::string_view text) {
  // A line that begins with the key cam0, or another number.
  for (std::size_t start = 0; start < text.size();
       start = std::min(text.find('\n', start), text.size() - 1) + 1) {
    const std::string_view line = text.substr(start, text.find('\n', start) - start);
    if (line.find(':') != std::string_view::npos && is_camera_name(line.substr(0, line.find(':'))))
      return true;
  }
  return false;
}

/// The camera that is meant: the one of that name, or the only one. Empty with a fault.
std::string chosen_camera(StrictYaml& yaml, YamlNode& root, const std::string& file,
                          const std::string& camera_name) {
  std::vector<std::string> cameras;
  for (const std::string& key : root.keys())
    if (is_camera_name(key)) cameras.push_back(key);
  const std::string known = fmt::format("{}", fmt::join(cameras, ", "));
  const bool has_it = std::find(cameras.begin(), cameras.end(), camera_name) != cameras.end();
  if (camera_name.empty() && cameras.size() > 1)
    yaml.faults().add(file, "several cameras: " + known, "FILE:NAME says which one is meant");
  else if (!camera_name.empty() && !has_it)
    yaml.faults().add(file, "no camera \"" + camera_name + "\"", "one of its cameras: " + known);
  const std::string chosen = has_it ? camera_name : cameras.size() == 1 ? cameras.front() : "";
  for (const std::string& other : cameras)
    if (other != chosen) root.leave_aside(other);
  yaml.faults().throw_if_any();
  return chosen;
}

void read_kalibr_distortion(YamlNode& node, CameraParameters& parameters) {
  const std::string model = node.text("distortion_model");
  if (model != "none" && model != "radtan" && model != "equidistant") {
    node.leave_aside("distortion_coeffs");
    return node.fault("distortion_model", model.empty() ? "nothing" : model,
                      "one of none, radtan, equidistant");
  }
  const auto numbers = node.numbers("distortion_coeffs", NumberRange::any(""), 0);
  const std::size_t count = model == "none" ? 0 : 4;
  if (numbers.size() != count)
    return node.fault("distortion_coeffs", fmt::format("{} coefficients", numbers.size()),
                      fmt::format("{} for {}", count, model));
  if (model == "radtan") return set_brown(parameters, numbers);
  std::copy(numbers.begin(), numbers.end(), parameters.coefficients.begin());
  if (model == "equidistant") parameters.model = LensModel::kannala_brandt;
}

Camera read_kalibr(const std::filesystem::path& file, const std::string& text,
                   const std::string& camera_name) {
  StrictYaml yaml = StrictYaml::from_text(text, file.string());
  YamlNode root = yaml.root();
  const std::string chosen = chosen_camera(yaml, root, file.string(), camera_name);
  YamlNode node = root.map(chosen);
  CameraParameters parameters;
  const std::string model = node.text("camera_model");
  if (model == "pinhole") {
    const auto numbers = node.numbers("intrinsics", NumberRange::any(""), 4);
    parameters.fx_px = numbers[0], parameters.fy_px = numbers[1];
    parameters.cx_px = numbers[2], parameters.cy_px = numbers[3];
    read_kalibr_distortion(node, parameters);
  } else {
    node.fault("camera_model", model.empty() ? "nothing" : model,
               "pinhole, with distortion_model none, radtan or equidistant");
    for (const char* key : {"intrinsics", "distortion_model", "distortion_coeffs"}) node.leave_aside(key);
  }
  read_sides(node, "resolution", parameters.size);
  for (const char* key :
       {"rostopic", "cam_overlaps", "T_cn_cnm1", "T_cam_imu", "timeshift_cam_imu", "line_delay"})
    node.leave_aside(key);
  return finished_camera(yaml, parameters, file.string());
}

std::string write_kalibr(const Camera& camera, const std::string&) {
  const CameraParameters& p = camera.parameters();
  const auto& k = p.coefficients;
  if (p.model == LensModel::brown && k[4] != 0)
    throw InputError("lens model for Kalibr camchain YAML", fmt::format("brown with k3 = {}", k[4]),
                     "brown with k3 = 0: Kalibr's radtan has k1, k2, p1 and p2 alone");
  const bool straight = p.model == LensModel::pinhole;
  const char* distortion = straight ? "none" : p.model == LensModel::brown ? "radtan" : "equidistant";
  std::vector<double> coefficients;
  if (!straight) coefficients.assign(k.begin(), k.begin() + 4);
  return fmt::format(
      "cam0:\n  camera_model: pinhole\n  intrinsics: {}\n  distortion_model: {}\n  distortion_coeffs: {}\n"
      "  resolution: [{}, {}]\n  rostopic: /cam0/image_raw\n  cam_overlaps: []\n",
      yaml_floats({p.fx_px, p.fy_px, p.cx_px, p.cy_px}), distortion, yaml_floats(coefficients),
      p.size.width_px, p.size.height_px);
}

}  // namespace

CameraFileFormat kalibr_camera_format() {
  return {"kalibr",
          "Kalibr camchain YAML",
          {},
          {LensModel::pinhole, LensModel::kannala_brandt},
          is_kalibr_text,
          read_kalibr,
          write_kalibr,
          {LensModel::brown}};
}

}  // namespace ballservo
