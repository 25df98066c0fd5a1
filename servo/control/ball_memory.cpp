#include "servo/control/ball_memory.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {

namespace {
constexpr double extrapolate_s = 1.5;  // a ball out of sight is taken to go on moving for so long
}  // namespace

void BallMemory::see(const BallMeasurement& measurement, double arrived_s) {
  if (inbox_count_ == inbox_.size()) {  // more frames than steps can read: the oldest goes
    std::move(inbox_.begin() + 1, inbox_.end(), inbox_.begin());
    --inbox_count_;
  }
  inbox_[inbox_count_++] = {measurement, arrived_s};
}

void BallMemory::take_in(double time_s, const PoseHistory& poses) {
  nonsense_ = false;
  for (std::size_t i = 0; i < inbox_count_; ++i) {
    const BallMeasurement& frame = inbox_[i].frame;
    const bool claims_ball = frame.state != TrackState::none;
    if (!std::isfinite(frame.time_s) ||
        (claims_ball && (!frame.p_CB.allFinite() || !frame.covariance_m2.allFinite()))) {
      nonsense_ = true;
      continue;
    }
    if (frame.time_s <= frame_s_ || frame.time_s > time_s) continue;
    frame_s_ = frame.time_s;
    frame_arrived_s_ = std::min(inbox_[i].arrived_s, time_s);
    track_state_ = frame.state;
    if (!frame.is_sighting()) continue;
    const auto pose = poses.at(frame.time_s);
    if (!pose) continue;  // older than all that is remembered
    const TargetFilter::Update update = filter_.update(frame, *pose);
    if (update == TargetFilter::Update::ignored || update == TargetFilter::Update::doubted) continue;
    if (update == TargetFilter::Update::started) confirmed_ = 0;
    sighting_s_ = frame.time_s;
    confirmed_ = frame.state == TrackState::confirmed ? confirmed_ + 1 : 0;
  }
  inbox_count_ = 0;
}

std::optional<TargetEstimate> BallMemory::predict(double time_s) const {
  const double until_s = filter_.last_time_s() + extrapolate_s;
  auto estimate = filter_.predict(std::min(time_s, until_s));
  if (estimate && time_s > until_s) estimate->v_OB.setZero();
  return estimate;
}

}  // namespace ballservo
