#include <fmt/format.h>

#include <algorithm>

#include "calibration/camera/files/camera_formats.hpp"
#include "calibration/camera/files/camera_yaml.hpp"

namespace ballservo {
namespace {

struct RosModel {
  std::string_view name;
  LensModel model;
  std::vector<std::size_t> counts;  // of coefficients that occur; missing ones are 0
};

const std::vector<RosModel>& ros_models() {
  static const std::vector<RosModel> models{{"plumb_bob", LensModel::brown, {5, 4}},
                                            {"rational_polynomial", LensModel::brown8, {8}},
                                            {"equidistant", LensModel::kannala_brandt, {4}}};
  return models;
}

bool is_ros_text(std::string_view text) {
  // Keys at the start of a line; an OpenCV file has some of them too, but says so in its first line.
  const auto has_key = [&](std::string_view key) {
    const auto at = text.find(key);
    return at != std::string_view::npos && (at == 0 || text[at - 1] == '\n');
  };
  return text.substr(0, 5) != "%YAML" &&
         (has_key("camera_matrix:") || has_key("distortion_model:") || has_key("image_width:"));
}

/// A matrix of ROS: {rows, cols, data}. Its numbers, or nothing but faults.
std::vector<double> read_ros_matrix(YamlNode& parent, const std::string& key, long long rows,
                                    long long columns, bool required) {
  YamlNode node = parent.map(key, required);
  if (!parent.has(key)) return {};
  node.integer("rows", rows, rows);
  node.integer("cols", columns, columns);
  return node.numbers("data", NumberRange::any(""), static_cast<std::size_t>(rows * columns));
}

void read_ros_distortion(YamlNode& root, CameraParameters& parameters) {
  std::vector<std::string> names;
  for (const RosModel& ros : ros_models()) names.emplace_back(ros.name);
  const std::string name = root.choice("distortion_model", names);
  YamlNode node = root.map("distortion_coefficients");
  if (!root.has("distortion_coefficients")) return;
  node.integer("rows", 1, 1);
  const long long count = node.integer("cols", 4, 14);
  const auto data = node.numbers("data", NumberRange::any(""), 0);
  const auto ros = std::find_if(ros_models().begin(), ros_models().end(),
                                [&](const RosModel& candidate) { return candidate.name == name; });
  if (ros == ros_models().end() || data.empty()) return;
  if (std::find(ros->counts.begin(), ros->counts.end(), data.size()) == ros->counts.end() ||
      count != static_cast<long long>(data.size())) {
    root.fault("distortion_coefficients", fmt::format("{} numbers, cols {}", data.size(), count),
               fmt::format("{} for {}", fmt::join(ros->counts, " or "), name));
    return;
  }
  if (ros->model == LensModel::brown) return set_brown(parameters, data);
  std::copy(data.begin(), data.end(), parameters.coefficients.begin());
  parameters.model = ros->model;
}

Camera read_ros(const std::filesystem::path& file, const std::string& text, const std::string& camera_name) {
  StrictYaml yaml = StrictYaml::from_text(text, file.string());
  YamlNode root = yaml.root();
  CameraParameters parameters;
  parameters.size.width_px = static_cast<int>(root.integer("image_width", 1, 65536));
  parameters.size.height_px = static_cast<int>(root.integer("image_height", 1, 65536));
  check_camera_name(root, camera_name);
  set_camera_matrix(root, "camera_matrix", read_ros_matrix(root, "camera_matrix", 3, 3, true), parameters);
  read_ros_distortion(root, parameters);
  read_ros_matrix(root, "rectification_matrix", 3, 3, false);
  read_ros_matrix(root, "projection_matrix", 3, 4, false);
  for (const char* key : {"binning_x", "binning_y"}) root.integer(key, 0, 65536, 0);
  YamlNode roi = root.map("roi", false);
  for (const char* key : {"x_offset", "y_offset", "width", "height"}) roi.integer(key, 0, 65536, 0);
  roi.boolean("do_rectify", false);
  return finished_camera(yaml, parameters, file.string());
}

std::string ros_matrix_text(std::string_view name, int rows, const std::vector<double>& data) {
  return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: {}\n", name, rows,
                     data.size() / static_cast<std::size_t>(rows), yaml_floats(data));
}

std::string write_ros(const Camera& camera, const std::string& camera_name) {
  const CameraParameters& p = camera.parameters();
  const LensModel model = p.model == LensModel::pinhole ? LensModel::brown : p.model;
  const auto ros = std::find_if(ros_models().begin(), ros_models().end(),
                                [&](const RosModel& candidate) { return candidate.model == model; });
  return fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\n", p.size.width_px,
                     p.size.height_px, yaml_quoted(camera_name)) +
         ros_matrix_text("camera_matrix", 3, camera_matrix(p)) +
         fmt::format("distortion_model: {}\n", ros->name) +
         ros_matrix_text("distortion_coefficients", 1, coefficients(p)) +
         ros_matrix_text("rectification_matrix", 3, {1, 0, 0, 0, 1, 0, 0, 0, 1}) +
         ros_matrix_text("projection_matrix", 3,
                         {p.fx_px, 0, p.cx_px, 0, 0, p.fy_px, p.cy_px, 0, 0, 0, 1, 0});
}

}  // namespace

CameraFileFormat ros_camera_format() {
  return {"ros",
          "ROS camera_info YAML",
          {".yaml", ".yml"},
          {LensModel::pinhole, LensModel::brown, LensModel::brown8, LensModel::kannala_brandt},
          is_ros_text,
          read_ros,
          write_ros};
}

}  // namespace ballservo
