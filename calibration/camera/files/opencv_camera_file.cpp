#include <fmt/format.h>

#include <algorithm>

#include "calibration/camera/files/camera_formats.hpp"
#include "calibration/camera/files/camera_yaml.hpp"

namespace ballservo {
namespace {

using Names = std::vector<std::string_view>;

// Keys without underscores, in small letters: image_width, image_Width and imageWidth are one.
const Names width_names{"imagewidth"}, height_names{"imageheight"};
const Names size_names{"cameraresolution", "imagesize"};
const Names matrix_names{"cameramatrix"};
const Names distortion_names{"distortioncoefficients", "distortioncoeffs", "distcoeffs"};

std::string plain(const std::string& key) {
  std::string result;
  for (const char c : key)
    if (c != '_') result += static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return result;
}

bool is_one_of(const std::string& key, const Names& names) {
  return std::find(names.begin(), names.end(), plain(key)) != names.end();
}

bool is_opencv_text(std::string_view text) { return text.substr(0, 5) == "%YAML"; }

/// The key that is spelled in one of these ways; `usual` where there is none. A second one is a fault.
std::string key_of(YamlNode& root, const Names& names, const std::string& usual) {
  std::string found;
  for (const std::string& key : root.keys()) {
    if (!is_one_of(key, names)) continue;
    if (!found.empty()) root.fault(key, "the same as " + found + " a second time", "one of the two");
    if (found.empty()) found = key;
  }
  return found.empty() ? usual : found;
}

/// A matrix of FileStorage: {rows, cols, dt, data}. Its numbers row by row, with its shape; empty with a
/// fault.
struct Matrix {
  long long rows = 0, columns = 0;
  std::vector<double> data;
};
Matrix read_opencv_matrix(YamlNode& root, const std::string& key) {
  YamlNode node = root.map(key);
  if (!root.has(key)) return {};
  Matrix matrix{node.integer("rows", 1, 64), node.integer("cols", 1, 64), {}};
  const std::string type = node.text("dt");
  if (type != "d" && type != "f")
    node.fault("dt", "\"" + type + "\"", "d or f: a matrix of floating-point numbers of one channel");
  matrix.data = node.numbers("data", NumberRange::any(""), 0);
  if (static_cast<long long>(matrix.data.size()) != matrix.rows * matrix.columns) {
    if (!matrix.data.empty())
      node.fault("data", fmt::format("{} numbers", matrix.data.size()),
                 fmt::format("rows x cols = {} x {} numbers", matrix.rows, matrix.columns));
    return {};
  }
  return matrix;
}

void read_size(YamlNode& root, ImageSize& size) {
  const std::string key = key_of(root, size_names, "");
  if (!key.empty()) return read_sides(root, key, size);
  size.width_px = static_cast<int>(root.integer(key_of(root, width_names, "image_width"), 1, 65536));
  size.height_px = static_cast<int>(root.integer(key_of(root, height_names, "image_height"), 1, 65536));
}

void read_opencv_distortion(YamlNode& root, CameraParameters& parameters) {
  const std::string key = key_of(root, distortion_names, "distortion_coefficients");
  const auto [rows, columns, data] = read_opencv_matrix(root, key);
  const bool fisheye = root.integer("fisheye_model", 0, 1, 0) == 1;
  if (data.empty()) return;
  if (rows != 1 && columns != 1)
    return root.fault(key, fmt::format("a matrix of {} x {}", rows, columns), "one row or one column");
  const std::size_t count = data.size();
  if (fisheye && count != 4)
    return root.fault(key, fmt::format("{} coefficients with fisheye_model: 1", count),
                      "k1 k2 k3 k4, as cv::fisheye has them");
  if (!fisheye && (count == 4 || count == 5)) return set_brown(parameters, data);
  if (!fisheye && count != 8 && count != 12 && count != 14)
    return root.fault(key, fmt::format("{} coefficients", count), "4, 5, 8, 12 or 14");
  if (count > 8 && std::any_of(data.begin() + 8, data.end(), [](double value) { return value != 0; }))
    return root.fault(key,
                      fmt::format("{} coefficients, with {}", count,
                                  count == 12 ? "a thin prism (s1 to s4)"
                                              : "a thin prism or a tilted sensor (s1 to s4, taux, tauy)"),
                      "at most k1 k2 p1 p2 k3 k4 k5 k6, or zeros beyond them");
  parameters.model = fisheye ? LensModel::kannala_brandt : LensModel::brown8;
  std::copy_n(data.begin(), fisheye ? 4 : 8, parameters.coefficients.begin());
}

/// What else may stand in the file: anything that does not speak of the lens.
void leave_the_rest(YamlNode& root) {
  for (const std::string& key : root.keys()) {
    const std::string name = plain(key);
    if (name == "fisheyemodel" && key != "fisheye_model")
      root.fault(key, "an unknown key", "fisheye_model");
    else if (name == "xi" || (key != "fisheye_model" && (name.find("model") != std::string::npos ||
                                                         name.find("fisheye") != std::string::npos)))
      root.fault(key, "a lens that is described otherwise than by OpenCV's calibration program",
                 "camera_matrix, distortion_coefficients and fisheye_model alone");
    else
      root.leave_aside(key);
  }
}

Camera read_opencv(const std::filesystem::path& file, const std::string& text,
                   const std::string& camera_name) {
  // "%YAML:1.0" is no directive of YAML's: a comment in its place keeps the lines' numbers.
  std::string yaml_text = text;
  yaml_text[text.find('%')] = '#';
  StrictYaml yaml = StrictYaml::from_text(yaml_text, file.string(), YamlTags::opencv);
  YamlNode root = yaml.root();
  CameraParameters parameters;
  read_size(root, parameters.size);
  check_camera_name(root, camera_name);
  const std::string key = key_of(root, matrix_names, "camera_matrix");
  const Matrix matrix = read_opencv_matrix(root, key);
  if (!matrix.data.empty() && (matrix.rows != 3 || matrix.columns != 3))
    root.fault(key, fmt::format("a matrix of {} x {}", matrix.rows, matrix.columns), "3 x 3");
  else
    set_camera_matrix(root, key, matrix.data, parameters);
  read_opencv_distortion(root, parameters);
  leave_the_rest(root);
  return finished_camera(yaml, parameters, file.string());
}

std::string opencv_matrix_text(std::string_view name, int rows, const std::vector<double>& data) {
  return fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: {}\n", name, rows,
                     data.size() / static_cast<std::size_t>(rows), yaml_floats(data));
}

std::string write_opencv(const Camera& camera, const std::string& camera_name) {
  const CameraParameters& p = camera.parameters();
  const std::vector<double> column = coefficients(p);
  return fmt::format(
             "%YAML:1.0\n---\ncamera_name: {}\nimage_width: {}\nimage_height: {}\nfisheye_model: {}\n",
             yaml_quoted(camera_name), p.size.width_px, p.size.height_px,
             p.model == LensModel::kannala_brandt ? 1 : 0) +
         opencv_matrix_text("camera_matrix", 3, camera_matrix(p)) +
         opencv_matrix_text("distortion_coefficients", static_cast<int>(column.size()), column);
}

}  // namespace

CameraFileFormat opencv_camera_format() {
  return {"opencv",
          "OpenCV YAML",
          {},
          {LensModel::pinhole, LensModel::brown, LensModel::brown8, LensModel::kannala_brandt},
          is_opencv_text,
          read_opencv,
          write_opencv};
}

}  // namespace ballservo
