// SOURCE of the command line: image files, folders of images, video files, cameras.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/io/camera_controls.hpp"
#include "calibration/base/strict_yaml.hpp"

namespace ballservo {

/// One picture of a source.
struct Frame {
  cv::Mat bgr;                 ///< 8-bit BGR
  std::string source;          ///< the file's name without folders, or "camera:0"
  int index = 0;               ///< counts from 0 within a video or camera; 0 for a still
  double time_s = 0;           ///< since the sequence's first picture
  bool coarse_chroma = false;  ///< its colours were stored or sent at a lower resolution than brightness
  std::optional<double> captured_unix_s{};  ///< where the source tells it
};

/// Pictures that follow each other in time: a video, a folder, a camera, or the single files of the command
/// line.
class FrameSequence {
 public:
  virtual ~FrameSequence() = default;
  /// The next picture, or nothing at the end. Throws InputError for a picture that cannot be read.
  virtual std::optional<Frame> next() = 0;
  virtual std::string name() const = 0;
  virtual long length() const = 0;                                         ///< 0 where unknown
  virtual std::vector<std::filesystem::path> files() const { return {}; }  ///< none: a camera
  virtual const CameraControls* controls() const { return nullptr; }       ///< a camera's
  /// How a camera is set, as far as it tells ("exposure", "gain", "white_balance_k" ...).
  std::map<std::string, double> camera_settings() const {
    return controls() != nullptr ? controls()->values() : std::map<std::string, double>();
  }
};

/// Whether a folder's file counts as one of its pictures: .png, .jpg and so on.
bool has_image_name(const std::filesystem::path& file);

/// Of times that pictures do not carry.
inline NumberRange fps_range() { return NumberRange::within(1e-3, 1e4, "Hz"); }

/// Opens the sources, in order, checking all of them first (every fault at once). Each video, folder or
/// camera is a sequence of its own; single image files together form one. `fps` times pictures that carry no
/// time.
std::vector<std::unique_ptr<FrameSequence>> open_sources(const std::vector<std::string>& sources, double fps,
                                                         double max_pixels);

/// What a source names: an image file, or what has many pictures.
struct SourceFile {
  enum class Kind { image, video, camera };
  std::filesystem::path path;  ///< of a camera its name, "camera:0"
  Kind kind = Kind::image;
};
/// The images, videos and cameras that the sources name (folders opened, in natural order).
std::vector<SourceFile> source_files(const std::vector<std::string>& sources);

/// File names that several different files of the sequences have, in order: results name a file without its
/// folders, so that these can't be told apart there.
std::vector<std::string> repeated_names(const std::vector<std::unique_ptr<FrameSequence>>& sequences);

/// The image files that the sources name (folders opened, in natural order); a video or a camera is a
/// fault, `allowed` what would be none.
std::vector<std::filesystem::path> image_files(
    const std::vector<std::string>& sources, const std::string& allowed = "image files or folders of images");

}  // namespace ballservo
