// The camera of a run with what looks at its frames: what was seen in them arrives late.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "app/experiment/ball_sight.hpp"
#include "app/experiment/floor_sight.hpp"
#include "app/experiment/runner.hpp"
#include "app/experiment/simulated_camera.hpp"
#include "app/scenario/scenario.hpp"

namespace ballservo {

/// A frame that has been exposed and looked at.
struct SeenFrame {
  FrameRecord record;
  FloorScan floor;           ///< empty where nobody looks at the floor
  cv::Mat picture;           ///< empty where none was rendered
  double arrives_s = 0;      ///< when the control loop hears of it
  double perception_ms = 0;  ///< processor time
};

class RunCamera {
 public:
  /// Throws InputError for level image without colours, or with colours that do not hold the target's class.
  /// `scenario` must outlive the camera.
  RunCamera(const Scenario& scenario, const RunOptions& options);

  /// When the next instant of an exposure is due (s).
  double next_s() const { return camera_.next_s(); }

  /// Takes that instant, at `time_s`, with the robot where it is then. The frame, where this was its last
  /// instant and was not dropped; the rows of its balls (tracks.csv) are then appended to `rows`.
  std::optional<SeenFrame> expose(double time_s, const Pose2& robot, std::string& rows);

  /// Leaves out the frames that should have begun before that time, the one under way apart; how many.
  long skip_to(double time_s) { return camera_.skip_to(time_s); }

 private:
  SeenFrame look(ExposedFrame&& exposed, std::string& rows);

  const Scenario& scenario_;
  bool image_;
  std::unique_ptr<BallSight> sight_;
  std::unique_ptr<FloorSight> floor_;  // where the floor is looked at
  SimulatedCamera camera_;
};

}  // namespace ballservo
