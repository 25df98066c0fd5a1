// A window on the screen that shows pictures as they come.
#pragma once

#include <chrono>
#include <opencv2/core.hpp>
#include <optional>
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

  /// Shows a picture (8-bit BGR) in its own size, until the user makes the window another; where a time is
  /// given, no sooner after the last picture than the times say. False once the user has had enough: by 'q',
  /// Esc, or closing the window.
  bool show(const cv::Mat& bgr, std::optional<double> time_s);

 private:
  using Clock = std::chrono::steady_clock;
  bool wait(Clock::duration time);

  std::string title_;
  bool is_open_ = false;
  Clock::time_point start_;   // of the sequence
  Clock::duration shown_{0};  // the last picture's time since then
};

}  // namespace ballservo
