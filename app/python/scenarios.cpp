// Scenarios.
#include <fmt/format.h>

#include <optional>

#include "app/commands/ball_options.hpp"
#include "app/experiment/simulated_camera.hpp"
#include "app/loop/clock.hpp"
#include "app/python/bindings.hpp"
#include "app/scenario/scenario.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/camera/files/camera_file.hpp"

namespace ballservo {
namespace {

/// The camera's first picture where the robot stands at a pose.
py::array_t<std::uint8_t> look(const Scenario& scenario, const std::optional<Eigen::Vector3d>& pose) {
  constexpr double reach_m = 1e4;
  if (pose && !(pose->allFinite() && pose->cwiseAbs().maxCoeff() <= reach_m))
    throw InputError("pose", fmt::format("({}, {}, {})", pose->x(), pose->y(), pose->z()),
                     fmt::format("x_m, y_m, yaw_rad, each from {} to {}", -reach_m, reach_m));
  const Pose2 there = pose ? Pose2{pose->x(), pose->y(), pose->z()} : scenario.robot.pose;
  const CameraFrame frame = hearing_ctrl_c([&] {
    SimulatedCamera camera(scenario, true, [&](double time_s) { return RobotTruth{time_s, there, {}}; });
    SteppedClock clock;
    for (;;)
      if (auto taken = camera.take(clock, camera.next_start_s() + scenario.camera.exposure_s)) return *taken;
  });
  return py::array_t<std::uint8_t>({frame.bgr.rows, frame.bgr.cols, 3}, frame.bgr.data);
}

}  // namespace

void add_scenarios(py::module_& module) {
  py::class_<Scenario>(module, "Scenario", "A scenario as one seed has it.")
      .def(py::init([](const Path& file, const std::vector<std::string>& sets, std::uint64_t seed) {
             return load_scenario(file, sets, seed);
           }),
           py::arg("file"), py::arg("sets") = std::vector<std::string>{}, py::arg("seed") = 0,
           "sets: \"key.path=value\" each")
      .def_property_readonly(
          "document", [](const Scenario& s) { return python_of(s.resolved_json); },
          "What stands in it, after sets and what the seed drew.")
      .def_readonly("seed", &Scenario::seed, "That drew what varies.")
      .def_property_readonly(
          "pose", [](const Scenario& s) { return array_of(s.robot.pose); },
          "The robot's at time 0 in the world: x_m, y_m, yaw_rad.")
      .def_property_readonly(
          "X_RC", [](const Scenario& s) { return s.goal().mount.X_RC().matrix(); },
          "The camera's pose in the robot frame (x forward, y left, z up) where a pan does not turn it, as "
          "the robot believes, (4, 4).")
      .def_property_readonly(
          "goal_p_RB", [](const Scenario& s) { return s.goal().desired_p_RB(); },
          "Where the ball's centre is in the robot frame at the goal, m, (3,).")
      .def_property_readonly(
          "camera",
          [](const Scenario& s) {
            return KnownCamera{s.camera.camera, {}};
          },
          "The robot's camera, as it truly is.")
      .def(
          "p_WB", [](const Scenario& s, double time_s) { return s.target_ball().p_WB(time_s); },
          py::arg("time_s"), "Where the target's centre is in the world then, m, (3,).")
      .def("look", &look, py::arg("pose") = py::none(),
           "The camera's first picture where the robot stands at pose (x_m, y_m, yaw_rad; None: its own), "
           "uint8 (height, width, 3).");
}

}  // namespace ballservo
