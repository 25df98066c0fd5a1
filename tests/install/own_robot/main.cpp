// A camera, a robot and a law of one's own drive to a ball that is only seen: usage: own_robot red.colors
#include <cstdio>

#include "../drawn_ball.hpp"
#include "app/loop/image_perception.hpp"
#include "app/loop/loop.hpp"
#include "calibration/color/color_file.hpp"

using namespace ballservo;

// Says how fast it is told to go, and goes.
class MyRobot : public Robot {
 public:
  RobotState read(double now_s) override {
    now_.odometry = integrate(now_.odometry, now_.twist, now_s - now_.time_s);
    now_.time_s = now_s;
    return now_;
  }
  void command(const Twist2& twist, double now_s) override {
    now_.twist = twist;
    if (commands_++ % 100 == 0)
      std::printf("%5.2f s: %.3f m/s, %.3f rad/s\n", now_s, twist.v_mps, twist.w_radps);
  }

 private:
  RobotState now_;
  long commands_ = 0;
};

// Draws what it would see, thirty times a second, and hands it over 30 ms later.
class MyCamera : public FrameSource {
 public:
  MyCamera(MyRobot& robot, const ServoGoal& goal, const Eigen::Vector3d& p_WB)
      : robot_(robot), goal_(goal), p_WB_(p_WB) {}

  std::optional<CameraFrame> take(Clock& clock, double until_s) override {
    const double due_s = static_cast<double>(frames_) / 30;
    if (due_s > until_s) return std::nullopt;
    clock.sleep_until(due_s);
    const Eigen::Isometry3d X_WC = X_WR(robot_.read(due_s).odometry) * goal_.mount.X_RC();
    return CameraFrame{frames_++, due_s, due_s + 0.03,
                       draw_ball(X_WC.inverse() * p_WB_, goal_.ball_radius_m)};
  }

 private:
  MyRobot& robot_;
  ServoGoal goal_;
  Eigen::Vector3d p_WB_;
  long frames_ = 0;
};

// The further the faster, and turn towards it.
class MyLaw : public Law {
 public:
  explicit MyLaw(const ServoGoal& goal) : goal_(goal) {}
  std::optional<LawOutput> command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d&) override {
    const Eigen::Vector3d p_RB = goal_.mount.X_RC() * p_CB;
    const double range_m = p_RB.head<2>().norm() - goal_.distance_m,
                 bearing_rad = std::atan2(p_RB.y(), p_RB.x());
    return LawOutput{{1.0 * range_m, 2.0 * bearing_rad}, range_m, bearing_rad};
  }

 private:
  ServoGoal goal_;
};

int main(int, char** arguments) {
  ControllerOptions options;  // 0.8 m before a ball of 12 cm
  options.latency_s = 0.03;
  options.actuation_delay_s = 0;
  const Eigen::Vector3d p_WB(2.4, 0.5, options.goal.ball_height_m);

  CameraParameters lens;
  lens.size = {640, 480};
  lens.fx_px = lens.fy_px = focal_px;
  lens.cx_px = center_x_px;
  lens.cy_px = center_y_px;
  const auto colors = std::make_shared<ColorTable>(read_color_file(arguments[1]));
  DetectorOptions detector;
  detector.radii.resize(1);
  detector.radii[0].radius_m = options.goal.ball_radius_m;
  ImagePerception perception(Tracker(Detector(std::make_shared<RayTable>(Camera(lens)), colors, detector)),
                             TargetOptions{1, options.goal.mount, options.goal.ball_height_m});

  MyRobot robot;
  MyCamera camera(robot, options.goal, p_WB);
  Controller controller(options, std::make_unique<MyLaw>(options.goal));
  SteppedClock clock;  // a WallClock for a real robot
  run_loop({camera, perception, robot, controller}, clock, [](double time_s) { return time_s < 15; });

  const Eigen::Vector2d p_RB = in_robot_frame(robot.read(15).odometry, p_WB.head<2>());
  const double range_mm = 1e3 * (p_RB.norm() - options.goal.distance_m);
  const double bearing_deg = 57.29578 * std::atan2(p_RB.y(), p_RB.x());
  std::printf("stands %.2f mm and %.3f degrees off the goal\n", range_mm, bearing_deg);
  return std::abs(range_mm) <= 10 && std::abs(bearing_deg) <= 0.5 ? 0 : 1;
}
