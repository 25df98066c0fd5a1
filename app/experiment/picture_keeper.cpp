#include "app/experiment/picture_keeper.hpp"

#include <fmt/format.h>

#include <utility>

#include "app/experiment/run_video.hpp"

namespace ballservo {

namespace {
constexpr std::size_t max_key_frames = 9;
}

PictureKeeper::PictureKeeper(const Scenario& scenario, std::function<void(const cv::Mat& picture)> show)
    : scenario_(scenario), show_(std::move(show)) {}

void PictureKeeper::frame(const FrameEvent& event) {
  if (event.frame.bgr.empty()) return;
  FrameRecord frame;
  frame.time_s = event.frame.time_s;
  frame.measurement = event.percept.ball;
  frame.measured = event.percept.outline;
  const ControlState state = state_;
  std::string text = fmt::format("{:6.2f} s  {}  {}", frame.time_s, control_state_name(state),
                                 track_state_name(frame.measurement.state));
  if (frame.measurement.state != TrackState::none) {
    text += fmt::format("  {:.3f} m", frame.measurement.p_CB.norm());
  }
  cv::Mat picture = event.frame.bgr.clone();
  draw_sight(picture, scenario_.camera.camera, frame, scenario_.target_ball().radius_m(), text);
  const bool changed = !last_state_ || *last_state_ != state;
  const bool halfway = state == ControlState::approach && frame.time_s >= next_s_;
  if ((changed || halfway) && kept_.size() + 1 < max_key_frames) {
    kept_.push_back(
        {frame.time_s, picture, fmt::format("{:.2f} s: {}", frame.time_s, control_state_name(state))});
    next_s_ = frame.time_s + 2.5;
  }
  last_state_ = state;
  last_ = {frame.time_s, picture, fmt::format("{:.2f} s: the last frame", frame.time_s)};
  show_(picture);
}

std::vector<KeyFrame> PictureKeeper::finish() {
  if (!last_.picture.empty()) kept_.push_back(std::move(last_));
  return std::move(kept_);
}

}  // namespace ballservo
