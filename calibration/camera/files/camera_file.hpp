// Camera files of other people's tools, told apart by their content.
//
// A format is one file (`visp_camera_file.cpp`, `ros_camera_file.cpp`, `opencv_camera_file.cpp`,
// `kalibr_camera_file.cpp`), declared in `camera_formats.hpp`, and one line in `camera_file.cpp`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/camera/camera.hpp"

namespace ballservo {

/// What one format can do.
struct CameraFileFormat {
  std::string_view name;                     ///< "visp", as `--format` has it
  std::string_view title;                    ///< "ViSP XML", for messages
  std::vector<std::string_view> extensions;  ///< that mean this format: ".xml"
  std::vector<LensModel> models;             ///< of which it holds every camera, simplest first
  bool (*recognises)(std::string_view text);
  /// The camera of that name (empty: the only one). `file` is where `text` was read from, for messages and
  /// for readers that want a path.
  Camera (*read)(const std::filesystem::path& file, const std::string& text, const std::string& camera_name);
  std::string (*write)(const Camera& camera, const std::string& camera_name);
  std::vector<LensModel> partly{};  ///< of which it holds some cameras; `write` refuses the others
};

const std::vector<CameraFileFormat>& camera_file_formats();

/// The format called `name`; without a name, the one that the file name's extension means. InputError where
/// there is none.
const CameraFileFormat& camera_file_format(std::string_view name, const std::filesystem::path& file);

/// FILE[:NAME][@WxH]: a camera file's path; where one camera of several is meant, the camera's name; and the
/// size of the same sensor's pictures, scaled. A file whose own name has a colon or @ is taken for what it
/// is.
struct CameraFileName {
  std::filesystem::path file;
  std::string camera_name;
  std::optional<ImageSize> scaled_to;
};
CameraFileName split_camera_name(const std::string& camera_file);

/// Reads FILE[:NAME][@WxH]. InputError with every fault for a file that is missing, larger than 1 MB, in no
/// known format, or describes no valid camera (NaN, negative focal lengths, missing or unknown entries...).
/// For a size of another shape, too.
Camera read_camera(const std::string& camera_file);

/// The bytes of a camera file; every number reads back as the same double. InputError naming model and format
/// where the format cannot hold the model, or not with these coefficients. `camera_name` is written where the
/// format has a place for it.
std::string camera_file_text(const Camera& camera, const CameraFileFormat& format,
                             const std::string& camera_name);

/// InputError if pictures of the given size are not this camera's; `place` names the camera, `of` what has
/// that size.
void check_camera_fits(const Camera& camera, ImageSize picture, const std::string& place,
                       const std::string& of = "the pictures");

}  // namespace ballservo
