// What a user plugs into the loop: a camera, something that finds the ball in its frames, and a robot. (The
// law is plugged into the Controller.)
//
// Times are seconds on the clock of the run (clock.hpp). Frames: R robot, C camera (CONVENTIONS.md). What a
// port throws ends the run: the robot is told to rest, and the exception is handed on.
#pragma once

#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>

#include "app/loop/clock.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "servo/avoidance/floor_scan.hpp"
#include "servo/avoidance/sonar.hpp"
#include "servo/control/ball_measurement.hpp"
#include "servo/motion/camera_mount.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo {

/// One picture of the camera.
struct CameraFrame {
  long number = 0;    ///< counts from 0; frames may be missing
  double time_s = 0;  ///< of the middle of its exposure
  /// The controller hears of it no earlier than then: a simulated camera states its latency thus. A real
  /// camera leaves it as it is; its frames arrive when perception is done with them.
  double arrives_s = -std::numeric_limits<double>::infinity();
  cv::Mat bgr{};       ///< 8-bit BGR; may be empty for a perception that needs no picture
  double pan_rad = 0;  ///< the camera was turned so far to the left in the middle of the exposure
};

/// A camera. One thread calls it: the caller's of `run_loop`, a thread of its own in `run_threaded_loop`.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// The next frame, in order of time: waits on `clock` for one that is due by `until_s`; nothing, at once,
  /// where none is. A driver that cannot say when the next is due may wait for it.
  virtual std::optional<CameraFrame> take(Clock& clock, double until_s) = 0;
};

/// What a frame shows: the floor as if the camera had not been turned.
struct Percept {
  BallMeasurement ball;                     ///< of the frame's time
  std::optional<OutlineEllipse> outline{};  ///< the ball's in the picture (px), as seen or as predicted
  FloorScan floor{};                        ///< `count` 0 where nothing is said of the floor
};

/// Finds the ball in frames. Called in the camera's thread, with frames in order of time.
class BallPerception {
 public:
  virtual ~BallPerception() = default;
  virtual Percept look(const CameraFrame& frame) = 0;
};

/// What the robot knows of its own motion.
struct RobotState {
  double time_s = 0;  ///< when it was so
  Pose2 odometry;     ///< X_OR: O is wherever the odometry began
  Twist2 twist;       ///< as measured
  PanMotion pan{};    ///< of the camera, as measured
};

/// A robot with two driven wheels. Called by one thread at a time.
class Robot {
 public:
  virtual ~Robot() = default;
  /// The robot now, or as late as it knows. Times that do not advance stop the robot.
  virtual RobotState read(double now_s) = 0;
  /// Drives at that velocity until told otherwise; it must come to rest by itself when the program dies.
  virtual void command(const Twist2& twist, double now_s) = 0;
  /// Turns the camera at that speed, left positive, until told otherwise. For mounts with a pan.
  virtual void pan(double speed_radps, double now_s) { (void)speed_radps, (void)now_s; }
  /// Whether there are sonars: without them the controller must do without avoidance.
  virtual bool has_sonars() const { return false; }
  /// Hands over what the sonars have said since the last call, in order of arrival.
  virtual void listen(const std::function<void(const SonarReading&)>& hear) { (void)hear; }
};

}  // namespace ballservo
