// The pictures of a run that are worth keeping.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <vector>

#include "app/experiment/run_record.hpp"
#include "app/loop/loop_observer.hpp"
#include "app/scenario/scenario.hpp"

namespace ballservo {

/// Draws what was measured into the frames' pictures, and keeps those where the controller's state changed,
/// some of the way, and the last one.
class PictureKeeper final : public LoopObserver {
 public:
  /// `scenario` must outlive it. `show` is called with each drawn picture.
  PictureKeeper(const Scenario& scenario, std::function<void(const cv::Mat& picture)> show);

  void frame(const FrameEvent& event) override;
  void step(const StepEvent& event) override { state_ = event.control.state; }

  /// All that were kept, in order of time.
  std::vector<KeyFrame> finish();

 private:
  const Scenario& scenario_;
  std::function<void(const cv::Mat&)> show_;
  std::atomic<ControlState> state_{ControlState::search};
  double next_s_ = 0;
  std::optional<ControlState> last_state_;
  std::vector<KeyFrame> kept_;
  KeyFrame last_;
};

}  // namespace ballservo
