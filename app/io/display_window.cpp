#include "app/io/display_window.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <opencv2/highgui.hpp>
#include <utility>

#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

/// Toolkits (Qt, GTK) end the process where there is no display: tried in a process of its own.
bool can_open_window() {
  const pid_t child = fork();
  if (child < 0) return false;
  if (child == 0) {
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    try {
      cv::namedWindow("ballservo");
    } catch (const cv::Exception&) {
      _exit(1);
    }
    _exit(0);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

std::string display_text() {
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY"}) {
    const char* value = std::getenv(name);
    if (value != nullptr && *value != '\0') return std::string("no window on ") + name + "=" + value;
  }
  return "neither DISPLAY nor WAYLAND_DISPLAY set";
}

}  // namespace

DisplayWindow::DisplayWindow(std::string title) : title_(std::move(title)) {
  if (!can_open_window()) {
    throw InputError("--display", display_text(), "a display on which a window can be opened");
  }
}

DisplayWindow::~DisplayWindow() {
  if (is_open_) cv::destroyAllWindows();
}

/// Hands the user's doings on for so long; false once they want no more.
bool DisplayWindow::wait(Clock::duration time) {
  constexpr int escape = 27;
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
  const int key = cv::waitKey(static_cast<int>(std::clamp<long>(ms, 1, 100)));
  return key != 'q' && key != escape && cv::getWindowProperty(title_, cv::WND_PROP_VISIBLE) > 0;
}

bool DisplayWindow::show(const cv::Mat& bgr, std::optional<double> time_s) {
  const auto after_start =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(time_s.value_or(0)));
  if (!is_open_) {
    cv::namedWindow(title_, cv::WINDOW_NORMAL | cv::WINDOW_KEEPRATIO | cv::WINDOW_GUI_NORMAL);
    cv::resizeWindow(title_, bgr.cols, bgr.rows);
  }
  if (!is_open_ || after_start < shown_) start_ = Clock::now() - after_start;  // another sequence begins
  is_open_ = true;
  shown_ = after_start;
  while (time_s && Clock::now() < start_ + after_start) {
    if (!wait(start_ + after_start - Clock::now())) return false;
  }
  start_ = std::max(start_, Clock::now() - after_start);  // what comes late holds up what follows
  cv::imshow(title_, bgr);
  return wait({});
}

}  // namespace ballservo
