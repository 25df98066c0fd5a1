// The camera of a scenario: when it exposes, which of its frames arrive, what their pictures show, and what
// is true of them.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "app/experiment/simulated_robot.hpp"
#include "app/loop/ports.hpp"
#include "app/scenario/scenario.hpp"
#include "servo/simulation/rendering/camera_renderer.hpp"
#include "servo/simulation/rendering/truth.hpp"

namespace ballservo {

/// In the middle of an exposure: where the camera was and when, where the robot was, and what was true of the
/// target.
struct ExposureTruth {
  CameraView view;
  Pose2 robot;
  double pan_rad = 0;
  BallTruth target;
  double level = 1;  ///< factor that a fault puts on the light
};

/// The picture that a camera takes of what it sees in the middle of the exposure, of the camera's size.
using TakePicture = std::function<cv::Mat(const CameraView& view)>;

/// Frame k is exposed from k / rate on. The same scenario and poses give the same frames. On the wall
/// clock, frames that should have begun while the one before was still being rendered are left out.
class SimulatedCamera final : public FrameSource {
 public:
  /// Where the robot is at a time, or shortly after it.
  using RobotAt = std::function<RobotTruth(double time_s)>;

  /// `scenario` must outlive the camera. Pictures are rendered unless `take_picture` takes them.
  SimulatedCamera(const Scenario& scenario, bool with_pictures, RobotAt robot, TakePicture take_picture = {});

  std::optional<CameraFrame> take(Clock& clock, double until_s) override;

  /// The scenario's world is another from now on.
  void look_around() {
    if (renderer_) renderer_->set_world(scenario_.world);
    lit_views_.clear();
  }

  /// Of the frame last taken; for the thread that took it.
  const ExposureTruth& truth() const { return truth_; }
  /// The frame that is exposed next, and when that begins (s).
  long next_frame() const { return frame_; }
  double next_start_s() const { return static_cast<double>(frame_) / scenario_.camera.rate_hz; }
  /// Frames left out so far.
  long skipped() const { return skipped_; }

 private:
  /// An instant of the exposure, in shares of it; the middle is looked at even where it is not one of those
  /// rendered.
  struct Instant {
    double share = 0.5;
    bool rendered = true;
  };
  void skip_to(double time_s);
  std::optional<CameraFrame> expose(const RobotTruth& robot);
  void render_light();

  const Scenario& scenario_;
  RobotAt robot_;
  TakePicture take_picture_;                  // where pictures are needed and not rendered
  std::unique_ptr<CameraRenderer> renderer_;  // where they are rendered
  CameraFaults faults_;
  std::vector<Instant> instants_;
  long frame_ = 0, skipped_ = 0;
  std::vector<CameraView> views_;  // of the exposure under way
  std::size_t next_instant_ = 0;
  std::vector<CameraView> lit_views_;  // of the exposure whose light is kept
  cv::Mat light_;
  ExposureTruth truth_;
};

}  // namespace ballservo
