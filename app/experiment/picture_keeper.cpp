#include "app/experiment/picture_keeper.hpp"

#include <fmt/format.h>

#include "app/experiment/run_video.hpp"

namespace ballservo {

namespace {
constexpr std::size_t max_key_frames = 9;
}

PictureKeeper::PictureKeeper(const Scenario& scenario)
    : scenario_(scenario), radius_m_(scenario.target_ball().radius_m()) {}

void PictureKeeper::take(const FrameRecord& frame, ControlState state, cv::Mat& picture) {
  if (picture.empty()) return;
  std::string text = fmt::format("{:6.2f} s  {}  {}", frame.time_s, control_state_name(state),
                                 track_state_name(frame.measurement.state));
  if (frame.measurement.state != TrackState::none) {
    text += fmt::format("  {:.3f} m", frame.measurement.p_CB.norm());
  }
  draw_sight(picture, scenario_.camera.camera, frame, radius_m_, text);
  const bool changed = !last_state_ || *last_state_ != state;
  const bool halfway = state == ControlState::approach && frame.time_s >= next_s_;
  if ((changed || halfway) && kept_.size() + 1 < max_key_frames) {
    kept_.push_back({frame.time_s, picture.clone(),
                     fmt::format("{:.2f} s: {}", frame.time_s, control_state_name(state))});
    next_s_ = frame.time_s + 2.5;
  }
  last_state_ = state;
  last_ = {frame.time_s, picture, fmt::format("{:.2f} s: the last frame", frame.time_s)};
}

std::vector<KeyFrame> PictureKeeper::finish() {
  if (!last_.picture.empty()) kept_.push_back(std::move(last_));
  return std::move(kept_);
}

}  // namespace ballservo
