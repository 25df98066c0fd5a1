#include "app/io/live_camera.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <opencv2/videoio.hpp>
#include <regex>
#include <string>
#include <thread>
#include <utility>

#include "app/io/interrupt.hpp"
#include "app/io/track_stream.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {
namespace {

using SteadyClock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto picture_deadline = 5s;

/// What the grabbing thread and the reader share. The thread owns a share of it, for a driver may hang inside
/// a read for longer than the program wants to wait.
struct Grabbing {
  cv::VideoCapture capture;
  std::mutex mutex;
  std::condition_variable changed;
  cv::Mat newest;
  SteadyClock::time_point taken;
  long count = 0;
  bool stop = false, ended = false;
};

void grab_until_stopped(const std::shared_ptr<Grabbing>& shared) {
  while (true) {
    cv::Mat picture;
    bool read = false;
    try {
      read = shared->capture.read(picture) && picture.type() == CV_8UC3;
    } catch (const cv::Exception&) {
      read = false;
    }
    const std::lock_guard lock(shared->mutex);
    if (read) {
      shared->newest = picture;
      shared->taken = SteadyClock::now();
      ++shared->count;
    }
    if (!read || shared->stop) shared->ended = true;
    shared->changed.notify_all();
    if (shared->ended) return;
  }
}

/// Whether the camera's format halves its colours: JPEG, and the packed and planar ones of 4:2:2 and 4:2:0.
bool sends_coarse_chroma(const cv::VideoCapture& capture) {
  const auto format = static_cast<int>(capture.get(cv::CAP_PROP_FOURCC));
  for (const char* coarse : {"MJPG", "JPEG", "YUYV", "UYVY", "YVYU", "NV12", "NV21", "YU12", "YV12"})
    if (format == cv::VideoWriter::fourcc(coarse[0], coarse[1], coarse[2], coarse[3])) return true;
  return false;
}

class LiveCamera : public FrameSequence {
 public:
  LiveCamera(int number, std::string name, std::shared_ptr<Grabbing> shared)
      : name_(std::move(name)),
        coarse_chroma_(sends_coarse_chroma(shared->capture)),
        controls_(open_v4l2_device(number)),
        shared_(std::move(shared)) {
    std::thread(grab_until_stopped, shared_).detach();
  }
  ~LiveCamera() override {
    std::unique_lock lock(shared_->mutex);
    shared_->stop = true;
    shared_->changed.wait_for(lock, 1s, [&] { return shared_->ended; });
  }

  std::optional<Frame> next() override {
    const auto deadline = SteadyClock::now() + picture_deadline;
    std::unique_lock lock(shared_->mutex);
    while (shared_->count == seen_) {
      if (interrupt_requested()) return std::nullopt;
      if (shared_->ended || SteadyClock::now() > deadline) {
        throw InputError(name_, shared_->ended ? "a camera that has gone" : "no picture for five seconds",
                         "a camera that delivers pictures");
      }
      shared_->changed.wait_for(lock, 50ms);
    }
    if (seen_ == 0) start_ = shared_->taken;
    seen_ = shared_->count;
    const double time_s = std::chrono::duration<double>(shared_->taken - start_).count();
    return Frame{shared_->newest, name_, index_++, time_s, coarse_chroma_, unix_time_s(shared_->taken)};
  }
  std::string name() const override { return name_; }
  long length() const override { return 0; }
  const CameraControls* controls() const override { return &controls_; }

 private:
  std::string name_;
  bool coarse_chroma_;
  CameraControls controls_;
  std::shared_ptr<Grabbing> shared_;
  long seen_ = 0;
  int index_ = 0;
  SteadyClock::time_point start_;
};

}  // namespace

std::optional<CameraMode> parse_camera_mode(const std::string& text) {
  static const std::regex form(R"((\d{1,3})(?:@(\d{1,5})x(\d{1,5})(?:@([0-9.]{1,9}))?)?)");
  std::smatch match;
  if (!std::regex_match(text, match, form)) return std::nullopt;
  const auto value = [&](std::size_t group) { return parse_number(match[group].str()).value_or(0); };
  const CameraMode mode{
      static_cast<int>(value(1)), {static_cast<int>(value(2)), static_cast<int>(value(3))}, value(4)};
  const bool sized = mode.size.width_px > 0 && mode.size.height_px > 0;
  if (mode.number > 255 || sized != match[2].matched || (mode.rate_hz > 0) != match[4].matched)
    return std::nullopt;
  return mode;
}

std::string other_mode(const CameraMode& asked, double width_px, double height_px, double rate_hz) {
  const bool sized =
      asked.size == ImageSize{} || (asked.size.width_px == width_px && asked.size.height_px == height_px);
  if (sized && (asked.rate_hz == 0 || std::abs(rate_hz - asked.rate_hz) < 0.5)) return "";
  return fmt::format("{:g} x {:g} pixels at {:g} Hz", width_px, height_px, rate_hz);
}

std::unique_ptr<FrameSequence> open_live_camera(const CameraMode& mode, double max_pixels) {
  const std::string name = "camera:" + std::to_string(mode.number);
  std::vector<int> wanted;
  if (mode.size.width_px > 0)
    wanted = {cv::CAP_PROP_FRAME_WIDTH, mode.size.width_px, cv::CAP_PROP_FRAME_HEIGHT, mode.size.height_px};
  auto shared = std::make_shared<Grabbing>();
  bool opened = false;
  try {
    opened = shared->capture.open(mode.number, cv::CAP_V4L2, wanted);
    if (opened && mode.rate_hz > 0) shared->capture.set(cv::CAP_PROP_FPS, mode.rate_hz);
  } catch (const cv::Exception&) {
    opened = false;
  }
  if (!opened) throw InputError(name, "no camera that can be opened", "the number of a camera (/dev/videoN)");
  const double width = shared->capture.get(cv::CAP_PROP_FRAME_WIDTH);
  const double height = shared->capture.get(cv::CAP_PROP_FRAME_HEIGHT);
  if (!(width * height <= max_pixels))
    throw InputError(name, fmt::format("pictures of {} x {} pixels", width, height),
                     fmt::format("at most {:.0f} pixels (--max-pixels sets the limit)", max_pixels));
  const std::string other = other_mode(mode, width, height, shared->capture.get(cv::CAP_PROP_FPS));
  if (!other.empty())
    throw InputError(name, "a camera that gives " + other + " instead", "one of its own sizes and rates");
  return std::make_unique<LiveCamera>(mode.number, name, std::move(shared));
}

}  // namespace ballservo
