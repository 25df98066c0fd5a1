// A camera, or pictures on a disk, that ViSP reads: any vpFrameGrabber.
//
// Needs ViSP's headers only where the grabber is made.
#pragma once

#include <memory>

#include "app/loop/ports.hpp"

class vpFrameGrabber;

namespace ballservo {

struct VispCameraOptions {
  double rate_hz = 30;   ///< so often a frame is asked for; a grabber that waits for its camera may be slower
  double latency_s = 0;  ///< from the middle of an exposure until `acquire` returns, on the wall clock
};

class VispCamera final : public FrameSource {
 public:
  /// Opens the grabber, which must outlive it, with the first frame. Throws InputError for a rate that is not
  /// above 0 or a latency below 0, and what the grabber throws.
  VispCamera(vpFrameGrabber& grabber, const VispCameraOptions& options);
  ~VispCamera() override;

  std::optional<CameraFrame> take(Clock& clock, double until_s) override;

 private:
  struct Image;
  vpFrameGrabber& grabber_;
  VispCameraOptions options_;
  std::unique_ptr<Image> image_;
  long number_ = 0;
  double due_s_ = 0;
};

}  // namespace ballservo
