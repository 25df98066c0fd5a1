// The camera of a scenario: when it exposes, which of its frames arrive, and what their pictures show.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "app/scenario/scenario.hpp"
#include "servo/simulation/rendering/camera_renderer.hpp"

namespace ballservo {

/// A frame whose exposure is over.
struct ExposedFrame {
  long frame = 0;
  double start_s = 0;  ///< of the exposure
  /// In the middle of the exposure: where the camera was and when; where the robot was.
  CameraView middle;
  Pose2 robot;
  double level = 1;  ///< factor that a fault puts on the light
  cv::Mat picture;   ///< 8-bit BGR; empty where none is rendered
};

/// Frame k is exposed from k / rate on. The same scenario, seed and poses give the same frames.
class SimulatedCamera {
 public:
  /// `scenario` must outlive the camera.
  SimulatedCamera(const Scenario& scenario, std::uint64_t seed, bool with_pictures);

  /// Of the exposure under way, or the next one.
  long frame() const { return frame_; }
  /// When the next instant of an exposure is due (s).
  double next_s() const;

  /// Takes that instant, at `time_s`, with the robot where it is then. The frame, where this was its last
  /// instant and was not dropped.
  std::optional<ExposedFrame> expose(double time_s, const Pose2& robot);

  /// Leaves out the frames that should have begun before that time, the one under way apart; how many.
  long skip_to(double time_s);

 private:
  /// An instant of the exposure, in shares of it; the middle is looked at even where it is not one of those
  /// rendered.
  struct Instant {
    double share = 0.5;
    bool rendered = true;
  };
  double start_s() const;

  const Scenario& scenario_;
  std::uint64_t seed_;
  std::unique_ptr<CameraRenderer> renderer_;  // where pictures are needed
  CameraFaults faults_;
  std::vector<Instant> instants_;
  long frame_ = 0;
  std::size_t next_instant_ = 0;
  std::vector<CameraView> views_;
  CameraView middle_;
  Pose2 middle_robot_;
};

}  // namespace ballservo
