// A window on the screen that shows pictures as they come.
#pragma once

#include <opencv2/core.hpp>
#include <string>

namespace ballservo {

/// Opens with its first picture and closes with the object.
class DisplayWindow {
 public:
  /// Throws InputError where no window can be opened. To be made before any threads are (see
  /// can_open_window).
  explicit DisplayWindow(std::string title);
  ~DisplayWindow();
  DisplayWindow(const DisplayWindow&) = delete;
  DisplayWindow& operator=(const DisplayWindow&) = delete;

  /// Shows a picture (8-bit BGR). False once the user has had enough: by 'q', Esc, or closing the window.
  bool show(const cv::Mat& bgr);

 private:
  std::string title_;
  bool is_open_ = false;
};

}  // namespace ballservo
