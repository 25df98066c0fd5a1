#include "calibration/camera/files/camera_yaml.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace ballservo {

Camera finished_camera(StrictYaml& yaml, CameraParameters parameters, const std::string& place) {
  if (yaml.faults().empty()) yaml.faults().collect([&] { Camera(parameters, place); });
  yaml.finish();
  return Camera(parameters, place);
}

void check_camera_name(YamlNode& root, const std::string& wanted) {
  const std::string name = root.text("camera_name", "");
  if (!wanted.empty() && wanted != name)
    root.fault("camera_name", "\"" + name + "\"", "\"" + wanted + "\", the name asked for");
}

void read_sides(YamlNode& node, const std::string& key, ImageSize& size) {
  const auto sides = node.numbers(key, NumberRange::within(1, 65536, "px"), 2);
  for (const double side : sides)
    if (side != static_cast<int>(side)) node.fault(key, fmt::format("{}", side), "whole numbers (px)");
  if (sides.size() == 2) size = {static_cast<int>(sides[0]), static_cast<int>(sides[1])};
}

void set_brown(CameraParameters& parameters, const std::vector<double>& coefficients) {
  std::copy(coefficients.begin(), coefficients.end(), parameters.coefficients.begin());
  const bool straight =
      std::all_of(coefficients.begin(), coefficients.end(), [](double value) { return value == 0; });
  parameters.model = straight ? LensModel::pinhole : LensModel::brown;
  if (straight) parameters.coefficients = {};  // no negative zeros
}

void set_camera_matrix(YamlNode& node, const std::string& key, const std::vector<double>& matrix,
                       CameraParameters& parameters) {
  const bool is_read = std::any_of(matrix.begin(), matrix.end(), [](double value) { return value != 0; });
  if (matrix.size() != 9 || !is_read) return;  // a fault that is told already, or no camera
  parameters.fx_px = matrix[0], parameters.cx_px = matrix[2];
  parameters.fy_px = matrix[4], parameters.cy_px = matrix[5];
  if (matrix[1] != 0 || matrix[3] != 0 || matrix[6] != 0 || matrix[7] != 0 || matrix[8] != 1)
    node.fault(key, fmt::format("[{}]", fmt::join(matrix, ", ")), "[fx, 0, cx, 0, fy, cy, 0, 0, 1]: no skew");
  for (const double focal : {matrix[0], matrix[4]})
    if (focal <= 0) node.fault(key, fmt::format("focal length {}", focal), "a number above 0 (px)");
}

std::vector<double> camera_matrix(const CameraParameters& p) {
  return {p.fx_px, 0, p.cx_px, 0, p.fy_px, p.cy_px, 0, 0, 1};
}

std::vector<double> coefficients(const CameraParameters& p) {
  const int count = coefficient_count(p.model == LensModel::pinhole ? LensModel::brown : p.model);
  return {p.coefficients.begin(), p.coefficients.begin() + count};
}

std::string yaml_floats(const std::vector<double>& values) {
  std::string list;
  for (const double value : values) {
    std::string text = fmt::format("{}", value);
    if (text.find('.') == std::string::npos) text.insert(std::min(text.find('e'), text.size()), ".0");
    list += (list.empty() ? "" : ", ") + text;
  }
  return "[" + list + "]";
}

std::string yaml_quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20) continue;
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + "\"";
}

}  // namespace ballservo
