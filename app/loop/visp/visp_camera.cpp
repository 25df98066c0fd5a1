#include "app/loop/visp/visp_camera.hpp"

#include <visp3/core/vpFrameGrabber.h>
#include <visp3/core/vpImage.h>
#include <visp3/core/vpRGBa.h>

#include <opencv2/imgproc.hpp>

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {

struct VispCamera::Image {
  vpImage<vpRGBa> rgba;
};

VispCamera::VispCamera(vpFrameGrabber& grabber, const VispCameraOptions& options)
    : grabber_(grabber), options_(options), image_(std::make_unique<Image>()) {
  FaultList faults;
  if (!(options.rate_hz > 0)) faults.add("rate_hz", number_text(options.rate_hz), "a number above 0 (Hz)");
  if (!(options.latency_s >= 0)) faults.add("latency_s", number_text(options.latency_s), "0 or more (s)");
  faults.throw_if_any();
  grabber.open(image_->rgba);
}

VispCamera::~VispCamera() = default;

std::optional<CameraFrame> VispCamera::take(Clock& clock, double until_s) {
  if (due_s_ > until_s) return std::nullopt;
  clock.sleep_until(due_s_);
  grabber_.acquire(image_->rgba);
  due_s_ += 1 / options_.rate_hz;
  CameraFrame frame{number_++, clock.now_s() - options_.latency_s};
  vpImage<vpRGBa>& rgba = image_->rgba;
  const cv::Mat view(static_cast<int>(rgba.getHeight()), static_cast<int>(rgba.getWidth()), CV_8UC4,
                     rgba.bitmap);
  cv::cvtColor(view, frame.bgr, cv::COLOR_RGBA2BGR);
  return frame;
}

}  // namespace ballservo
