// What a closed-loop run leaves behind, as plain data: logs, summary and report are made from it.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibration/base/statistics.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "perception/tracking/light_adaptation.hpp"
#include "servo/control/controller.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

/// One control step; robot and ball are the truth, not what the robot believes, unless said.
struct StepRecord {
  long step = 0;
  double time_s = 0;
  bool known = true;  ///< the truth; else what would be true is NaN or false, and `twist` is as measured
  Pose2 pose;
  Twist2 twist;
  PanMotion pan;
  Pose2 odometry;  ///< where the robot believes to be
  ControlOutput control;
  Eigen::Vector3d p_WB{0, 0, 0};
  double range_error_m = 0;  ///< axle to the ball's centre in the floor plane, less the desired distance
  double range_m = 0, bearing_rad = 0;
  double clearance_m = 0;       ///< footprint to the nearest wall or obstacle
  double ball_clearance_m = 0;  ///< footprint to the nearest ball
  bool in_view = false;         ///< the ball's centre lies inside the picture
  bool hidden = false;          ///< an obstacle stands between the camera and the ball's centre
};

/// One camera frame, as far as the target is concerned.
struct FrameRecord {
  int frame = 0;
  double time_s = 0;                    ///< of the middle of the exposure
  double arrived_s = 0;                 ///< when the controller could hear of it
  std::optional<OutlineEllipse> truth;  ///< the ball's outline as it is
  CameraView view;                      ///< where the camera truly was
  double visible_fraction = 0;
  std::optional<Eigen::Vector3d> truth_p_CB;
  BallMeasurement measurement;
  std::optional<OutlineEllipse> measured;  ///< the outline as measured, or predicted while the track coasts
};

/// A picture worth keeping, with the measured outline drawn in.
struct KeyFrame {
  double time_s = 0;
  cv::Mat picture;
  std::string caption;
};

/// How a run ended.
enum class Outcome { reached, timeout, collision, lost, hit_by, fault, interrupted };
inline constexpr std::string_view outcome_names[]{"reached", "timeout", "collision",  "lost",
                                                  "hit_by",  "fault",   "interrupted"};
inline std::string_view outcome_name(Outcome outcome) {
  return outcome_names[static_cast<std::size_t>(outcome)];
}
/// Nothing for another word.
std::optional<Outcome> outcome_from_name(std::string_view name);

/// summary.json, apart from the wall clock's figures.
struct RunSummary {
  Outcome outcome = Outcome::timeout;
  std::string outcome_text;  ///< one sentence for people
  double settled_s = not_known;
  double time_optimal_s = not_known;
  double range_error_m = not_known;      ///< mean of the last second
  double bearing_error_rad = not_known;  ///< mean of the last second
  double range_rms_m = not_known;        ///< from settled_s on
  double bearing_rms_rad = not_known;    ///< from settled_s on
  double min_clearance_m = not_known;
  double out_of_view_s = 0;  ///< the ball's centre outside the picture, and nothing between it and the camera
  int lost_events = 0, ball_contacts = 0;
  std::string collision_cause;  ///< empty: no collision
  long steps = 0;
  double duration_s = 0;  ///< simulated time that the run took
};

/// How a run on the wall clock kept its times.
struct RealtimeTiming {
  long frames_late = 0;     ///< later than the camera's latency says: rendering and perception took longer
  long frames_skipped = 0;  ///< never exposed, for the one before was still being rendered
  long steps_skipped = 0;   ///< of the controller
  long guard_rests = 0;     ///< times that the guard on its own thread told the drive to rest
  std::vector<double> frame_age_ms;       ///< of frames when they arrived, from the middle of their exposure
  std::vector<double> control_period_ms;  ///< between two steps
  std::vector<double> guard_period_ms;    ///< between two looks of the guard
};

/// What the work cost, in processor time of its thread; rendering is not counted.
struct RunTiming {
  std::vector<double> image_to_command_ms;  ///< a frame's perception plus the control step that used it
  std::vector<double> control_us;           ///< a control step alone
  std::optional<RealtimeTiming> realtime;
};

struct RunRecord {
  std::vector<StepRecord> steps;
  std::vector<FrameRecord> frames;
  std::string tracks_csv;
  std::optional<AssumedLight> assumed_light;  ///< in which the ball showed, if not in the taught one
  std::vector<KeyFrame> key_frames;
  RunSummary summary;
  RunTiming timing;
};

/// Lets go of all but the last `most`, once there are twice as many.
template <typename Entry>
void forget_before_last(std::size_t most, std::vector<Entry>& entries) {
  if (entries.size() >= 2 * most)
    entries.erase(entries.begin(), entries.end() - static_cast<std::ptrdiff_t>(most));
}

}  // namespace ballservo
