// What the two sides of a lockstep tell each other (README.md): the parts of a message, made and read. Who
// reads trusts nothing.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/loop/ports.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/image_size.hpp"

namespace ballservo {

/// The other side is silent, is gone, or said what cannot be.
class PeerGone : public Refusal {
 public:
  /// `outcome`: of the run that ends here, a word of outcome_name.
  explicit PeerGone(const std::string& why, std::string outcome = "fault")
      : Refusal(why), outcome_(std::move(outcome)) {}
  const std::string& outcome() const { return outcome_; }

 private:
  std::string outcome_;
};

/// A message: its header in JSON, then the pixels of each picture that the header announces.
using LockstepParts = std::vector<std::string>;

inline constexpr std::size_t most_header_bytes = 1u << 20, most_frames = 64;

/// Controller to robot: drive so until then.
struct LockstepRequest {
  double until_s = 0;
  Twist2 command;
  double pan_radps = 0;
  std::string end{};          ///< why the controller leaves; empty: it stays
  nlohmann::json scenario{};  ///< of the first request: what the run is about; null where nothing is told
};

/// A frame that has arrived, with what is said of the ball in it (state none: it is not seen); its picture is
/// empty where none is sent.
struct LockstepFrame {
  CameraFrame frame;
  BallMeasurement ball;
};

/// Robot to controller: how it is then, and what has arrived since the last answer.
struct LockstepAnswer {
  RobotState state;
  std::optional<std::vector<SonarReading>> sonars{};  ///< nothing: the robot has none
  std::vector<LockstepFrame> frames{};
  std::optional<RobotMotion> truth{};  ///< for the record, not for the controller
  nlohmann::json robot{};  ///< of the first answer: what a controller must know; null where nothing is told
  std::string outcome{}, text{};  ///< how the run ended for the robot; empty: it goes on
};

LockstepParts parts_of(const LockstepRequest& request);
LockstepParts parts_of(const LockstepAnswer& answer);

/// Throws PeerGone, with what was found and what is allowed.
LockstepRequest request_of(const LockstepParts& parts);

/// What an answer must keep to.
struct AnswerBounds {
  double until_s = 0, period_s = 0.02;  ///< as asked for; it may be late by less than a period
  ImageSize picture{0, 0};              ///< of every frame; 0 x 0: frames come without
  double frame_s = -1;                  ///< frames begin after this one
  long frame = -1;
};
/// Throws PeerGone as request_of does.
LockstepAnswer answer_of(LockstepParts parts, const AnswerBounds& bounds);

}  // namespace ballservo
