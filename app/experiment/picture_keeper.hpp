// The pictures of a run that are worth keeping.
#pragma once

#include <optional>

#include "app/experiment/run_record.hpp"
#include "app/scenario/scenario.hpp"

namespace ballservo {

/// Draws what was measured into the frames' pictures, and keeps those where the controller's state changed,
/// some of the way, and the last one.
class PictureKeeper {
 public:
  /// `scenario` must outlive it.
  explicit PictureKeeper(const Scenario& scenario);

  /// Draws into the picture, where there is one; `state` is the controller's at that time.
  void take(const FrameRecord& frame, ControlState state, cv::Mat& picture);

  /// All that were kept, in order of time.
  std::vector<KeyFrame> finish();

 private:
  const Scenario& scenario_;
  double radius_m_, next_s_ = 0;
  std::optional<ControlState> last_state_;
  std::vector<KeyFrame> kept_;
  KeyFrame last_;
};

}  // namespace ballservo
