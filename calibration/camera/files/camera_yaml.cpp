#include "calibration/camera/files/camera_yaml.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace ballservo {

Camera finished_camera(StrictYaml& yaml, CameraParameters parameters, const std::string& place) {
  if (yaml.faults().empty()) yaml.faults().collect([&] { Camera(parameters, place); });
  yaml.finish();
  return Camera(parameters, place);
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
  if (matrix.size() != 9) return;
  parameters.fx_px = matrix[0], parameters.cx_px = matrix[2];
  parameters.fy_px = matrix[4], parameters.cy_px = matrix[5];
  if (matrix[1] != 0 || matrix[3] != 0 || matrix[6] != 0 || matrix[7] != 0 || matrix[8] != 1)
    node.fault(key, fmt::format("[{}]", fmt::join(matrix, ", ")), "[fx, 0, cx, 0, fy, cy, 0, 0, 1]: no skew");
  for (const double focal : {matrix[0], matrix[4]})
    if (focal <= 0) node.fault(key, fmt::format("focal length {}", focal), "a number above 0 (px)");
}

std::string yaml_float(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find('.') == std::string::npos) text.insert(std::min(text.find('e'), text.size()), ".0");
  return text;
}

std::string yaml_floats(const std::vector<double>& values) {
  std::string text = "[";
  for (const double value : values) text += (text.size() > 1 ? ", " : "") + yaml_float(value);
  return text + "]";
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
