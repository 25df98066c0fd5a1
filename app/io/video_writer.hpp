// Videos that appear whole or not at all.
#pragma once

#include <filesystem>
#include <opencv2/videoio.hpp>
#include <string>

#include "calibration/base/output.hpp"

namespace ballservo {

/// Writes H.264 in .mp4 (plays in browsers) or FFV1 in .mkv (bit exact), told by the file's extension.
class VideoFile {
 public:
  /// Throws InputError for another extension or a target that may not be written.
  VideoFile(const std::filesystem::path& target, Overwrite overwrite, double fps);

  /// Pictures (8-bit BGR) all of the first one's size; odd sizes are cut by one pixel, which H.264 asks for.
  void write(const cv::Mat& bgr);

  /// Closes the video and moves it into place; nothing is left where no picture was written, or not all
  /// could be (InputError).
  void commit();

 private:
  std::string place() const;

  OutputFile file_;
  double fps_;
  bool exact_ = false;
  cv::VideoWriter writer_;
  int written_ = 0;
};

}  // namespace ballservo
