#include "calibration/camera/files/camera_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/base/system_file.hpp"
#include "calibration/camera/files/camera_formats.hpp"

namespace ballservo {
namespace {

constexpr std::size_t max_camera_file_bytes = 1u << 20;

std::string shown(std::string_view text) {
  std::string line(text.substr(0, std::min<std::size_t>(text.find_first_of("\r\n"), 60)));
  for (char& c : line)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = '?';
  return line.empty() ? "nothing" : "\"" + line + "\" at its start";
}

/// Whether pictures of one size can be those of the other, made smaller or larger as they are.
bool has_shape_of(ImageSize a, ImageSize b) {
  constexpr double rounding = 0.01;  // of sizes to whole pixels, or to multiples of 8
  return std::abs(1.0 * a.width_px * b.height_px / (1.0 * a.height_px * b.width_px) - 1) <= rounding;
}

/// A camera whose pictures are made smaller or larger as they are; the middle of the first pixel is (0, 0).
Camera scaled_camera(const Camera& camera, ImageSize size, const std::string& place) {
  CameraParameters scaled = camera.parameters();
  const double x = static_cast<double>(size.width_px) / scaled.size.width_px,
               y = static_cast<double>(size.height_px) / scaled.size.height_px;
  if (!has_shape_of(size, scaled.size))
    throw InputError(place,
                     fmt::format("a camera of {} x {} pixels", scaled.size.width_px, scaled.size.height_px),
                     "a size of the same shape: a part cut out is another camera");
  scaled.size = size;
  scaled.fx_px *= x;
  scaled.fy_px *= y;
  scaled.cx_px = x * (scaled.cx_px + 0.5) - 0.5;
  scaled.cy_px = y * (scaled.cy_px + 0.5) - 0.5;
  return Camera(scaled, place);
}

}  // namespace

const std::vector<CameraFileFormat>& camera_file_formats() {
  static const std::vector<CameraFileFormat> formats{visp_camera_format(), opencv_camera_format(),
                                                     kalibr_camera_format(), ros_camera_format()};
  return formats;
}

const CameraFileFormat& camera_file_format(std::string_view name, const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  std::vector<std::string_view> names, extensions;
  for (const CameraFileFormat& format : camera_file_formats()) {
    const auto& own = format.extensions;
    if (name.empty() ? std::find(own.begin(), own.end(), extension) != own.end() : format.name == name)
      return format;
    names.push_back(format.name);
    extensions.insert(extensions.end(), own.begin(), own.end());
  }
  if (!name.empty())
    throw InputError("camera file format", std::string(name),
                     fmt::format("one of {}", fmt::join(names, ", ")));
  throw InputError(
      file.string(), extension.empty() ? "no extension" : "extension " + extension,
      fmt::format("{} (or say --format {})", fmt::join(extensions, ", "), fmt::join(names, ", ")));
}

CameraFileName split_camera_name(const std::string& camera_file) {
  const auto exists = [](const std::string& file) {
    std::error_code ignored;
    return std::filesystem::exists(file, ignored);
  };
  if (exists(camera_file)) return {camera_file, "", {}};
  if (const auto at = camera_file.rfind('@'); at != std::string::npos) {
    const std::string_view size = std::string_view(camera_file).substr(at + 1);
    const auto by = size.find('x');
    const auto width = parse_integer(size.substr(0, by));
    const auto height = by == std::string_view::npos ? std::nullopt : parse_integer(size.substr(by + 1));
    if (width && height && *width > 0 && *height > 0 && *width <= 65536 && *height <= 65536) {
      CameraFileName name = split_camera_name(camera_file.substr(0, at));
      name.scaled_to = {static_cast<int>(*width), static_cast<int>(*height)};
      return name;
    }
  }
  const auto colon = camera_file.rfind(':');
  if (const auto at = camera_file.rfind('@'); at != std::string::npos && exists(camera_file.substr(0, at)))
    throw InputError(camera_file, "the size '" + camera_file.substr(at + 1) + "'",
                     "FILE@WxH, each from 1 to 65536 px");
  if (colon == std::string::npos || !exists(camera_file.substr(0, colon))) return {camera_file, "", {}};
  return {camera_file.substr(0, colon), camera_file.substr(colon + 1), {}};
}

Camera read_camera(const std::string& camera_file) {
  const CameraFileName name = split_camera_name(camera_file);
  const std::string text = read_text_file(name.file, max_camera_file_bytes);
  for (const CameraFileFormat& format : camera_file_formats()) {
    if (!format.recognises(text)) continue;
    const Camera camera = format.read(name.file, text, name.camera_name);
    return name.scaled_to ? scaled_camera(camera, *name.scaled_to, camera_file) : camera;
  }
  if (text.find("<opencv_storage") != std::string::npos)
    throw InputError(name.file.string(), "a file of OpenCV's in XML",
                     "its YAML form, which FileStorage writes to names that end in .yml");
  std::vector<std::string_view> titles;
  for (const CameraFileFormat& format : camera_file_formats()) titles.push_back(format.title);
  throw InputError(name.file.string(), shown(text),
                   fmt::format("a camera file: {}", fmt::join(titles, " or ")));
}

std::string camera_file_text(const Camera& camera, const CameraFileFormat& format,
                             const std::string& camera_name) {
  const LensModel model = camera.parameters().model;
  std::vector<LensModel> known = format.models;
  known.insert(known.end(), format.partly.begin(), format.partly.end());
  if (std::find(known.begin(), known.end(), model) == known.end()) {
    std::vector<std::string_view> names;
    for (const LensModel held : known) names.push_back(lens_model_name(held));
    throw InputError(fmt::format("lens model for {}", format.title), std::string(lens_model_name(model)),
                     fmt::format("a model that this format holds: {}", fmt::join(names, ", ")));
  }
  return format.write(camera, camera_name);
}

void check_camera_fits(const Camera& camera, ImageSize picture, const std::string& place,
                       const std::string& of) {
  if (camera.size() == picture) return;
  throw InputError(place,
                   fmt::format("a camera of {} x {} pixels", camera.size().width_px, camera.size().height_px),
                   fmt::format("one of {} x {}, the size of {}", picture.width_px, picture.height_px, of) +
                       (has_shape_of(picture, camera.size())
                            ? fmt::format("; or FILE@{}x{}, if that was made smaller or larger",
                                          picture.width_px, picture.height_px)
                            : ""));
}

}  // namespace ballservo
