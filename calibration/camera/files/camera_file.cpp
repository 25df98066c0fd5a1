#include "calibration/camera/files/camera_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "calibration/base/fault.hpp"
#include "calibration/base/text_file.hpp"
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

CameraFileName split_camera_name(const std::string& file_or_file_and_name) {
  std::error_code ignored;
  const auto colon = file_or_file_and_name.rfind(':');
  if (colon == std::string::npos || std::filesystem::exists(file_or_file_and_name, ignored) ||
      !std::filesystem::exists(file_or_file_and_name.substr(0, colon), ignored))
    return {file_or_file_and_name, ""};
  return {file_or_file_and_name.substr(0, colon), file_or_file_and_name.substr(colon + 1)};
}

Camera read_camera(const std::string& file_or_file_and_name) {
  const auto [file, camera_name] = split_camera_name(file_or_file_and_name);
  const std::string text = read_text_file(file, max_camera_file_bytes);
  for (const CameraFileFormat& format : camera_file_formats())
    if (format.recognises(text)) return format.read(file, text, camera_name);
  if (text.find("<opencv_storage") != std::string::npos)
    throw InputError(file.string(), "a file of OpenCV's in XML",
                     "its YAML form, which FileStorage writes to names that end in .yml");
  std::vector<std::string_view> titles;
  for (const CameraFileFormat& format : camera_file_formats()) titles.push_back(format.title);
  throw InputError(file.string(), shown(text), fmt::format("a camera file: {}", fmt::join(titles, " or ")));
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

void check_camera_fits(const Camera& camera, ImageSize picture, const std::string& place) {
  if (camera.size() == picture) return;
  throw InputError(place,
                   fmt::format("a camera of {} x {} pixels", camera.size().width_px, camera.size().height_px),
                   fmt::format("one of {} x {}, as the pictures are", picture.width_px, picture.height_px));
}

}  // namespace ballservo
