#include "app/io/live_camera.hpp"

#include <fmt/format.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <opencv2/videoio.hpp>
#include <string>
#include <thread>
#include <utility>

#include "app/io/interrupt.hpp"
#include "app/io/track_stream.hpp"

namespace ballservo {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto picture_deadline = 5s;

/// What the grabbing thread and the reader share. The thread owns a share of it, for a driver may hang inside
/// a read for longer than the program wants to wait.
struct Grabbing {
  cv::VideoCapture capture;
  std::mutex mutex;
  std::condition_variable changed;
  cv::Mat newest;
  Clock::time_point taken;
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
      shared->taken = Clock::now();
      ++shared->count;
    }
    if (!read || shared->stop) shared->ended = true;
    shared->changed.notify_all();
    if (shared->ended) return;
  }
}

class LiveCamera : public FrameSequence {
 public:
  LiveCamera(int number, std::string name, std::shared_ptr<Grabbing> shared)
      : name_(std::move(name)), controls_(open_v4l2_device(number)), shared_(std::move(shared)) {
    std::thread(grab_until_stopped, shared_).detach();
  }
  ~LiveCamera() override {
    std::unique_lock lock(shared_->mutex);
    shared_->stop = true;
    shared_->changed.wait_for(lock, 1s, [&] { return shared_->ended; });
  }

  std::optional<Frame> next() override {
    const auto deadline = Clock::now() + picture_deadline;
    std::unique_lock lock(shared_->mutex);
    while (shared_->count == seen_) {
      if (interrupt_requested()) return std::nullopt;
      if (shared_->ended || Clock::now() > deadline) {
        throw InputError(name_, shared_->ended ? "a camera that has gone" : "no picture for five seconds",
                         "a camera that delivers pictures");
      }
      shared_->changed.wait_for(lock, 50ms);
    }
    if (seen_ == 0) start_ = shared_->taken;
    seen_ = shared_->count;
    const double time_s = std::chrono::duration<double>(shared_->taken - start_).count();
    const double captured_unix_s =
        unix_time_s() - std::chrono::duration<double>(Clock::now() - shared_->taken).count();
    return Frame{shared_->newest, name_, index_++, time_s, captured_unix_s};
  }
  std::string name() const override { return name_; }
  long length() const override { return 0; }
  const CameraControls* controls() const override { return &controls_; }

 private:
  std::string name_;
  CameraControls controls_;
  std::shared_ptr<Grabbing> shared_;
  long seen_ = 0;
  int index_ = 0;
  Clock::time_point start_;
};

}  // namespace

std::unique_ptr<FrameSequence> open_live_camera(int number, double max_pixels, FaultList& faults) {
  const std::string name = "camera:" + std::to_string(number);
  auto shared = std::make_shared<Grabbing>();
  bool opened = false;
  try {
    opened = shared->capture.open(number, cv::CAP_V4L2);
  } catch (const cv::Exception&) {
    opened = false;
  }
  if (!opened) {
    faults.add(name, "no camera that can be opened", "the number of a camera (/dev/videoN)");
    return nullptr;
  }
  const double width = shared->capture.get(cv::CAP_PROP_FRAME_WIDTH);
  const double height = shared->capture.get(cv::CAP_PROP_FRAME_HEIGHT);
  if (!(width * height <= max_pixels)) {
    faults.add(name, fmt::format("pictures of {} x {} pixels", width, height),
               fmt::format("at most {:.0f} pixels (--max-pixels sets the limit)", max_pixels));
    return nullptr;
  }
  return std::make_unique<LiveCamera>(number, name, std::move(shared));
}

}  // namespace ballservo
