// Perception from pictures: detector and tracker, the selection of the target, and the floor where it is
// asked for.
#pragma once

#include <optional>
#include <vector>

#include "app/loop/floor_detection.hpp"
#include "app/loop/ports.hpp"
#include "app/loop/target_selection.hpp"
#include "perception/tracking/tracker.hpp"

namespace ballservo {

class ImagePerception final : public BallPerception {
 public:
  ImagePerception(Tracker tracker, const TargetOptions& target, std::optional<FloorDetection> floor = {})
      : tracker_(std::move(tracker)), selection_(target), floor_(std::move(floor)) {}

  /// Throws InputError for a picture that is not of the camera's size or type.
  Percept look(const CameraFrame& frame) override;

  /// All tracks in the last picture; there must have been one.
  const std::vector<Track>& tracks() const { return *tracks_; }
  const Tracker& tracker() const { return tracker_; }

 private:
  Tracker tracker_;
  TargetSelection selection_;
  std::optional<FloorDetection> floor_;
  const std::vector<Track>* tracks_ = nullptr;
};

}  // namespace ballservo
