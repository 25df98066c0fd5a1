#include "app/io/display_window.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

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

bool DisplayWindow::show(const cv::Mat& bgr) {
  constexpr int escape = 27;
  if (!is_open_) cv::namedWindow(title_, cv::WINDOW_NORMAL | cv::WINDOW_KEEPRATIO);
  is_open_ = true;
  cv::imshow(title_, bgr);
  const int key = cv::waitKey(1);
  if (key == 'q' || key == escape) return false;
  return cv::getWindowProperty(title_, cv::WND_PROP_VISIBLE) > 0;
}

}  // namespace ballservo
