// Closed-loop runs of scenarios.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/commands/ball_options.hpp"
#include "app/experiment/run_log.hpp"
#include "app/experiment/runner.hpp"
#include "app/experiment/simulated_robot.hpp"
#include "app/python/bindings.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/camera/files/camera_file.hpp"

namespace ballservo {
namespace {

/// What a callback said, as so many numbers.
template <int Count>
Eigen::Matrix<double, Count, 1> numbers_of(const py::object& said, const char* place, const char* allowed) {
  try {
    return said.cast<Eigen::Matrix<double, Count, 1>>();
  } catch (const py::cast_error&) {
    throw InputError(place, py::repr(said).cast<std::string>(), allowed);
  }
}

class PyLaw final : public Law {
 public:
  explicit PyLaw(const py::object& law) : law_(law) {}
  std::optional<LawOutput> command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) override {
    const py::gil_scoped_acquire held;
    const py::object said = law_(p_CB, v_CB);
    if (said.is_none()) return std::nullopt;
    const Eigen::Vector2d twist = numbers_of<2>(said, "law", "v_mps, w_radps; or None");
    if (!twist.allFinite()) return std::nullopt;
    return LawOutput{{twist.x(), twist.y()}};
  }

 private:
  const py::object& law_;
};

class PyRobot final : public RobotBody {
 public:
  explicit PyRobot(const py::object& robot) : robot_(robot) {}
  void command(const Twist2& twist) override {
    const py::gil_scoped_acquire held;
    robot_.attr("command")(twist.v_mps, twist.w_radps);
  }
  RobotMotion advance_to(double time_s) override {
    const py::gil_scoped_acquire held;
    const char* const allowed = "x_m, y_m, yaw_rad, v_mps, w_radps, all finite";
    const py::object said = robot_.attr("advance")(time_s);
    const auto n = numbers_of<5>(said, "robot.advance", allowed);
    if (!n.allFinite()) throw InputError("robot.advance", py::repr(said).cast<std::string>(), allowed);
    return {{n(0), n(1), n(2)}, {n(3), n(4)}};
  }
  void put(const Pose2&) override { throw std::logic_error("nobody touches a run of Python's"); }

 private:
  const py::object& robot_;
};

struct FinishedRun {
  std::string summary_json, log_csv, tracks_csv;
};

/// The camera's first picture where the robot stands at a pose.
py::array_t<std::uint8_t> look(const Scenario& scenario, const std::optional<Eigen::Vector3d>& pose) {
  constexpr double reach_m = 1e4;
  if (pose && !(pose->allFinite() && pose->cwiseAbs().maxCoeff() <= reach_m))
    throw InputError("pose", fmt::format("({}, {}, {})", pose->x(), pose->y(), pose->z()),
                     fmt::format("x_m, y_m, yaw_rad, each from {} to {}", -reach_m, reach_m));
  const Pose2 there = pose ? Pose2{pose->x(), pose->y(), pose->z()} : scenario.robot.pose;
  const CameraFrame frame = hearing_ctrl_c([&] {
    SimulatedCamera camera(scenario, scenario.seed, true, [&](double time_s) {
      return RobotTruth{time_s, there, {}};
    });
    SteppedClock clock;
    for (;;)
      if (auto taken = camera.take(clock, camera.next_start_s() + scenario.camera.exposure_s)) return *taken;
  });
  return py::array_t<std::uint8_t>({frame.bgr.rows, frame.bgr.cols, 3}, frame.bgr.data);
}

/// What is None is the scenario's own.
FinishedRun simulate(const Scenario& scenario, const std::string& perception, const py::object& law,
                     const py::object& robot, const py::object& camera, const py::object& on_step) {
  const py::gil_scoped_release released;
  RunOptions options;
  options.perception = parse_perception_level(perception);
  options.seed = scenario.seed;
  options.colors = colors_of(scenario, options.perception);
  if (!law.is_none())
    options.laws.add(scenario.law.name,
                     [&](const LawOptions&, const ServoGoal&) { return std::make_unique<PyLaw>(law); });
  if (!robot.is_none()) options.body = std::make_shared<PyRobot>(robot);
  if (!camera.is_none() && options.perception != PerceptionLevel::image)
    throw InputError("camera", "perception " + perception, "perception image, which looks at pictures");
  if (!camera.is_none())
    options.take_picture = [&](const CameraView& view) {
      const py::gil_scoped_acquire held;
      const py::array bgr(camera(view.X_WC.matrix(), view.time_s));
      const cv::Mat picture = picture_of(bgr);
      check_camera_fits(scenario.camera.camera, {picture.cols, picture.rows}, "camera");
      return picture.clone();  // the array is Python's
    };
  if (!on_step.is_none())
    options.on_step = [&](const StepRecord& now) {
      const py::gil_scoped_acquire held;
      on_step(now);
    };
  options.go_on = [](double) {
    const py::gil_scoped_acquire held;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    return true;
  };
  const RunRecord run = run_closed_loop(scenario, options);
  return {summary_json(run.summary, run.timing).dump(), log_csv(run.steps), run.tracks_csv};
}

Eigen::Vector3d array_of(const Pose2& pose) { return {pose.x_m, pose.y_m, pose.yaw_rad}; }
Eigen::Vector2d array_of(const Twist2& twist) { return {twist.v_mps, twist.w_radps}; }

}  // namespace

void add_driving(py::module_& module) {
  py::class_<Scenario>(module, "Scenario", "A scenario as one seed has it.")
      .def(py::init([](const Path& file, const std::vector<std::string>& sets, std::uint64_t seed) {
             return load_scenario(file, sets, seed);
           }),
           py::arg("file"), py::arg("sets") = std::vector<std::string>{}, py::arg("seed") = 0,
           "sets: \"key.path=value\" each")
      .def_property_readonly(
          "document", [](const Scenario& s) { return python_of(s.resolved_json); },
          "What stands in it, after sets and what the seed drew.")
      .def_readonly("seed", &Scenario::seed)
      .def_property_readonly(
          "pose", [](const Scenario& s) { return array_of(s.robot.pose); },
          "The robot's at time 0 in the world: x_m, y_m, yaw_rad.")
      .def_property_readonly(
          "X_RC", [](const Scenario& s) { return s.goal().mount.X_RC().matrix(); },
          "The camera's pose in the robot frame (x forward, y left, z up), as the robot believes, (4, 4).")
      .def_property_readonly(
          "goal_p_RB", [](const Scenario& s) { return s.goal().desired_p_RB(); },
          "Where the ball's centre is in the robot frame at the goal, m, (3,).")
      .def_property_readonly("camera",
                             [](const Scenario& s) {
                               return KnownCamera{s.camera.camera, std::nullopt};
                             })
      .def(
          "p_WB", [](const Scenario& s, double time_s) { return s.target_ball().p_WB(time_s); },
          py::arg("time_s"), "Where the target's centre is in the world then, m, (3,).")
      .def("look", &look, py::arg("pose") = py::none(),
           "The camera's first picture where the robot stands at pose (x_m, y_m, yaw_rad; None: its own), "
           "uint8 (height, width, 3).");

  py::class_<StepRecord>(module, "Step", "A control step: the truth, and what the controller did.")
      .def_readonly("time_s", &StepRecord::time_s)
      .def_property_readonly(
          "pose", [](const StepRecord& s) { return array_of(s.pose); },
          "The robot's in the world: x_m, y_m, yaw_rad.")
      .def_property_readonly(
          "twist", [](const StepRecord& s) { return array_of(s.twist); }, "v_mps, w_radps")
      .def_property_readonly(
          "command", [](const StepRecord& s) { return array_of(s.control.command); }, "v_mps, w_radps")
      .def_property_readonly("state", [](const StepRecord& s) { return control_state_name(s.control.state); })
      .def_readonly("p_WB", &StepRecord::p_WB, "The ball's centre in the world, m, (3,).")
      .def_readonly("range_error_m", &StepRecord::range_error_m)
      .def_readonly("bearing_rad", &StepRecord::bearing_rad);
  py::class_<FinishedRun>(module, "Run", "A closed-loop run.")
      .def_property_readonly(
          "summary", [](const FinishedRun& r) { return python_of(r.summary_json); }, "As summary.json.")
      .def_readonly("log_csv", &FinishedRun::log_csv, "As log.csv: one row a control step.")
      .def_readonly("tracks_csv", &FinishedRun::tracks_csv, "As tracks.csv.")
      .def_property_readonly(
          "log", [](const FinishedRun& r) { return columns_of(r.log_csv); },
          "log.csv as an array a column, by its name; NaN where a cell is empty.")
      .def_property_readonly(
          "tracks", [](const FinishedRun& r) { return columns_of(r.tracks_csv); }, "The same of tracks.csv.");
  module.def("simulate", &simulate, py::arg("scenario"), py::arg("perception") = "geometric", py::kw_only(),
             py::arg("law") = py::none(), py::arg("robot") = py::none(), py::arg("camera") = py::none(),
             py::arg("on_step") = py::none(),
             R"(Drives a scenario to its end; perception image, geometric or truth.

law(p_CB, v_CB) -> (v_mps, w_radps), or None where there is no answer: instead of the scenario's law.
    p_CB: the ball's centre in the camera frame, m, (3,); v_CB: its velocity over ground in its axes, m/s.
robot: what is driven instead of the scenario's drive. robot.command(v_mps, w_radps) is told to it;
    robot.advance(time_s) -> (x_m, y_m, yaw_rad, v_mps, w_radps) moves it on to a time not before the last,
    the first being 0: its true pose in the world and its speeds.
camera(X_WC, time_s) -> bgr: takes the pictures instead of the renderer, for perception image.
    X_WC: the camera's pose in the world, (4, 4); bgr: uint8 (height, width, 3) of the camera's size.
on_step(step): called after each control step.

What they raise ends the run and comes out of this call.)");
}

}  // namespace ballservo
