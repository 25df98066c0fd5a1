// Pictures of a run: what the camera saw with what was made of it, and the room from above; those that are
// worth keeping.
#pragma once

#include <Eigen/Geometry>
#include <atomic>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "app/experiment/run_record.hpp"
#include "app/loop/loop_observer.hpp"
#include "app/scenario/scenario.hpp"
#include "calibration/camera/camera.hpp"
#include "servo/simulation/robot/sonar_ring.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

/// A command as it is drawn: where the robot's front comes to with it in the next 1.5 s.
std::vector<Eigen::Vector2d> foreseen_way(const Pose2& pose, const Twist2& twist, const Footprint& body);

/// Draws the ball's outline and centre as measured (from p_CB, by the camera and radius that are believed)
/// into a camera picture, with a line of text below; a prediction is drawn in grey.
void draw_detection(cv::Mat& bgr, const Camera& camera, const BallMeasurement& ball, double ball_radius_m,
                    const std::string& text);

/// The room from above, drawn once, and the robot on its way in it.
class TopView {
 public:
  /// A picture of that height (px); the width follows from what is shown: start, where the ball comes
  /// (`ball_floor`), what stands near their way and room to go around it, within the walls.
  TopView(const World& world, const Footprint& footprint, const Pose2& start,
          const Eigen::AlignedBox2d& ball_floor, double goal_distance_m, int height_px,
          const SonarBeam& beam = {});

  /// A metre and what the colours mean, the robot's trail so far, the sonars' newest beams (pale as far as
  /// they heard nothing, each echo an arc), robot and ball as they are now, the circle of the desired
  /// distance, and where the command leads: as intended (orange), and as guard and shield let it pass (green,
  /// over it; what they say of it above).
  cv::Mat draw(const std::vector<StepRecord>& steps, const std::vector<SonarFiring>& firings = {}) const;

 private:
  void draw_legend(cv::Mat& picture, bool hears, bool looks_aside) const;
  void draw_beams(cv::Mat& picture, double now_s, const std::vector<SonarFiring>& firings) const;
  Eigen::Vector2d pixel(const Eigen::Vector2d& p_W) const;
  std::vector<Eigen::Vector2d> pixels(const std::vector<Eigen::Vector2d>& points_W) const;
  Footprint footprint_;
  Eigen::Vector2d low_{0, 0};
  double scale_ = 100, goal_distance_m_ = 0;
  SonarBeam beam_;
  cv::Mat room_;
  std::vector<Ball> balls_;
};

/// Both side by side, in the height of the camera's picture.
cv::Mat side_by_side(const cv::Mat& left, const cv::Mat& right);

/// Draws what was measured into the frames' pictures, and keeps those where the controller's state changed,
/// some of the way, and the last one.
class PictureKeeper final : public LoopObserver {
 public:
  /// `scenario` must outlive it. `show`, if any, is called with each picture, drawn.
  explicit PictureKeeper(const Scenario& scenario, std::function<void(const cv::Mat& picture)> show = {});

  void frame(const FrameEvent& event) override;
  void step(const StepEvent& event) override { state_ = event.control.state; }

  /// All that were kept, in order of time.
  std::vector<KeyFrame> finish();

 private:
  struct Seen {
    cv::Mat bgr;
    double time_s;
    ControlState state;
    BallMeasurement ball;
  };
  cv::Mat drawn(const Seen& seen) const;

  const Scenario& scenario_;
  std::function<void(const cv::Mat&)> show_;
  std::atomic<ControlState> state_{ControlState::search};
  double next_s_ = 0;
  std::vector<KeyFrame> kept_;
  std::optional<Seen> last_;
};

}  // namespace ballservo
