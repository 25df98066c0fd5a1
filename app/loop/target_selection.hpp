// Which of the tracks is the ball that the robot drives to.
#pragma once

#include <vector>

#include "perception/tracking/tracker.hpp"
#include "servo/motion/camera_mount.hpp"

namespace ballservo {

struct TargetOptions {
  ClassIndex color_class = 1;  ///< of the target, counted from 1 as in the colour table
  CameraMount mount;           ///< as the robot believes
  double height_m = 0.06;      ///< of the ball's centre over the floor
  double lift_m = 0;           ///< it may be lifted so much higher
  double greatest_scale = 1;   ///< places may be so many times as far from the camera as the ball, or as near
};

/// The target is the first track of its class that was confirmed, for as long as it lives; until then the
/// best tentative one. A track that lies elsewhere than at the ball's height, or between there and where it
/// is lifted to, by more than a badly known mount explains, is another thing: a sign on the wall.
class TargetSelection {
 public:
  explicit TargetSelection(const TargetOptions& options);

  /// The target among the tracks of a picture, which stand in the order of their age; null: none of them is.
  /// Tracks without a place, or whose place or quality is not finite, are passed over.
  const Track* choose(const std::vector<Track>& tracks);

 private:
  bool may_be(const Track& track) const;

  TargetOptions options_;
  Eigen::Isometry3d X_RC_;
  int followed_ = 0;  // a track's id, which count from 1
};

}  // namespace ballservo
