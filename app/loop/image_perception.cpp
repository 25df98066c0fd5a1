#include "app/loop/image_perception.hpp"

namespace ballservo {

Percept ImagePerception::look(const CameraFrame& frame) {
  Percept percept;
  percept.ball.time_s = frame.time_s;
  tracks_ = &tracker_.update(frame.bgr, frame.time_s);
  if (const Track* target = selection_.choose(*tracks_)) {
    percept.ball.state = target->state;
    percept.ball.p_CB = target->ball.position->p_C;
    percept.ball.covariance_m2 = target->ball.position->covariance_m2;
    percept.outline = target->ball.outline;
  }
  if (floor_) percept.floor = floor_->look(frame.bgr, frame.time_s, percept.outline);
  return percept;
}

}  // namespace ballservo
