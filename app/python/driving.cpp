// Closed-loop runs, and what is plugged into them.
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

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
    const auto numbers = said.cast<Eigen::Matrix<double, Count, 1>>();
    if (numbers.allFinite()) return numbers;
  } catch (const py::cast_error&) {
  }
  throw InputError(place, py::repr(said).cast<std::string>(), allowed);
}

class PyLaw final : public Law {
 public:
  explicit PyLaw(const py::object& law) : law_(law) {}
  std::optional<LawOutput> command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) override {
    const py::gil_scoped_acquire held;
    const py::object said = law_(p_CB, v_CB);
    if (said.is_none()) return std::nullopt;
    const Eigen::Vector2d twist = numbers_of<2>(said, "law", "v_mps, w_radps, finite; or None");
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
    const auto n = numbers_of<5>(robot_.attr("advance")(time_s), "robot.advance",
                                 "x_m, y_m, yaw_rad, v_mps, w_radps, all finite");
    return {{n(0), n(1), n(2)}, {n(3), n(4)}};
  }
  void put(const Pose2&) override { throw std::logic_error("nobody touches a run of Python's"); }

 private:
  const py::object& robot_;
};

struct PyStep {
  StepRecord now;
  std::optional<FrameRecord> frame;
};

/// What is None is the scenario's own.
class PyRun {
 public:
  PyRun(const Scenario& scenario, const std::string& perception, py::object law, py::object robot,
        py::object camera)
      : goes_on_(new Parts{scenario, {}, std::move(law), std::move(robot), std::move(camera), std::nullopt}) {
    Parts& parts = *goes_on_;
    RunOptions& options = parts.options;
    options.perception = parse_perception_level(perception);
    if (!parts.law.is_none())
      options.laws.add(scenario.law.name, [&](const LawOptions&, const ServoGoal&) {
        return std::make_unique<PyLaw>(parts.law);
      });
    if (!parts.robot.is_none()) options.body = std::make_shared<PyRobot>(parts.robot);
    if (!parts.camera.is_none() && options.perception != PerceptionLevel::image)
      throw InputError("camera", "perception " + perception, "perception image, which looks at pictures");
    if (!parts.camera.is_none())
      options.take_picture = [&](const CameraView& view) {
        const py::gil_scoped_acquire held;
        const py::array bgr(parts.camera(view.X_WC.matrix(), view.time_s));
        const cv::Mat picture = picture_of(bgr);
        const ImageSize size = parts.scenario.camera.camera.size();
        if (picture.cols != size.width_px || picture.rows != size.height_px)
          throw InputError("camera", fmt::format("a picture of {} x {} px", picture.cols, picture.rows),
                           fmt::format("one of {} x {} px, as the scenario's camera takes them",
                                       size.width_px, size.height_px));
        return picture.clone();  // the array is Python's
      };
    const py::gil_scoped_release released;
    options.colors = colors_of(parts.scenario, options.perception);
    parts.run.emplace(parts.scenario, options);
  }

  std::optional<PyStep> step() {
    const auto mine = turn();
    if (!goes_on_) return std::nullopt;
    SteppedRun& run = *goes_on_->run;
    PyStep step;
    try {
      const py::gil_scoped_release released;
      run.step();
      step.now = run.so_far().steps.back();
      const std::vector<FrameRecord>& frames = run.so_far().frames;
      const auto arrived = std::find_if(frames.rbegin(), frames.rend(), [&](const FrameRecord& frame) {
        return frame.arrived_s <= step.now.time_s;
      });
      if (arrived != frames.rend()) step.frame = *arrived;
    } catch (...) {
      end();
      throw;
    }
    if (run.over()) end();
    return step;
  }

  void stop() {
    const auto mine = turn();
    if (goes_on_) end();
  }

  bool over() const { return !goes_on_; }
  const std::string& summary_json() const { return result(summary_json_); }
  const std::string& log_csv() const { return result(log_csv_); }
  const std::string& tracks_csv() const { return result(tracks_csv_); }

 private:
  struct Parts {
    Scenario scenario;
    RunOptions options;
    py::object law, robot, camera;
    std::optional<SteppedRun> run;
  };
  /// One step at a time, whoever asks: another thread or a law of the run. Under the interpreter's lock.
  std::shared_ptr<void> turn() {
    if (std::exchange(busy_, true)) throw Refusal("the run is in a step already");
    return {nullptr, [this](void*) { busy_ = false; }};
  }
  const std::string& result(const std::string& text) const {
    if (goes_on_) throw Refusal("the run goes on: step it to its end, or stop it");
    return text;
  }
  void end() {
    {
      const py::gil_scoped_release released;
      const RunRecord run = goes_on_->run->finish();
      summary_json_ = ballservo::summary_json(run.summary, run.timing).dump();
      log_csv_ = ballservo::log_csv(run.steps);
      tracks_csv_ = run.tracks_csv;
    }
    goes_on_.reset();
  }

  std::unique_ptr<Parts> goes_on_;  // until it is over
  bool busy_ = false;
  std::string summary_json_, log_csv_, tracks_csv_;
};

std::unique_ptr<PyRun> simulate(const Scenario& scenario, const std::string& perception,
                                const py::object& law, const py::object& robot, const py::object& camera,
                                const py::object& on_step) {
  auto run = std::make_unique<PyRun>(scenario, perception, law, robot, camera);
  while (const auto step = run->step()) {
    if (!on_step.is_none()) on_step(*step);
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
  return run;
}

Eigen::Vector2d array_of(const Twist2& twist) { return {twist.v_mps, twist.w_radps}; }
std::optional<Eigen::Vector3d> array_of(const std::optional<OutlineEllipse>& outline) {
  return outline ? std::optional(array_of(*outline)) : std::nullopt;
}
/// A part of what was measured.
template <class T>
std::optional<T> where_measured(const FrameRecord& frame, const T& value) {
  return frame.measurement.state == TrackState::none ? std::nullopt : std::optional(value);
}

}  // namespace

void add_driving(py::module_& module) {
  py::class_<FrameRecord>(module, "Frame",
                          "A camera frame: what was measured of the target in it, and the truth.")
      .def_readonly("frame", &FrameRecord::frame, "Its number, from 0.")
      .def_readonly("time_s", &FrameRecord::time_s, "Of the middle of the exposure.")
      .def_readonly("arrived_s", &FrameRecord::arrived_s, "When the controller heard of it.")
      .def_property_readonly(
          "state", [](const FrameRecord& f) { return track_state_name(f.measurement.state); },
          "tentative, confirmed or coasting (predicted, not seen); none without a ball")
      .def_property_readonly(
          "p_m", [](const FrameRecord& f) { return where_measured(f, f.measurement.p_CB); },
          "The ball's centre in the camera frame, m, (3,); None without a ball.")
      .def_property_readonly(
          "covariance_m2",
          [](const FrameRecord& f) { return where_measured(f, f.measurement.covariance_m2); },
          "Of p_m, (3, 3).")
      .def_property_readonly(
          "outline_px", [](const FrameRecord& f) { return array_of(f.measured); },
          "The outline's ellipse in the picture: centre x, y; geometric mean of the semi-axes; None where "
          "there is none.")
      .def_property_readonly(
          "true_p_m", [](const FrameRecord& f) { return f.truth_p_CB; },
          "As p_m, the truth; None where the ball is not before the camera.")
      .def_property_readonly(
          "true_outline_px", [](const FrameRecord& f) { return array_of(f.truth); },
          "As outline_px, the truth.")
      .def_readonly("visible_fraction", &FrameRecord::visible_fraction,
                    "Of the ball's disc in the picture, 0 to 1.")
      .def_property_readonly(
          "pan_rad", [](const FrameRecord& f) { return f.measurement.pan_rad; },
          "How far the camera was turned to the left.");

  py::class_<PyStep>(module, "Step", "A control step: the truth, and what the controller did.")
      .def_property_readonly(
          "time_s", [](const PyStep& s) { return s.now.time_s; }, "Simulated.")
      .def_property_readonly(
          "pose", [](const PyStep& s) { return array_of(s.now.pose); },
          "The robot's in the world: x_m, y_m, yaw_rad.")
      .def_property_readonly(
          "twist", [](const PyStep& s) { return array_of(s.now.twist); }, "v_mps, w_radps")
      .def_property_readonly(
          "command", [](const PyStep& s) { return array_of(s.now.control.command); }, "v_mps, w_radps")
      .def_property_readonly(
          "pan_rad", [](const PyStep& s) { return s.now.pan.angle_rad; },
          "How far the camera is turned to the left, now.")
      .def_property_readonly(
          "state", [](const PyStep& s) { return control_state_name(s.now.control.state); },
          "The controller's, in a word.")
      .def_property_readonly(
          "p_WB", [](const PyStep& s) { return s.now.p_WB; }, "The ball's centre in the world, m, (3,).")
      .def_property_readonly(
          "range_error_m", [](const PyStep& s) { return s.now.range_error_m; },
          "Of the axle's distance from the ball on the floor, less that of the goal.")
      .def_property_readonly(
          "bearing_rad", [](const PyStep& s) { return s.now.bearing_rad; },
          "Of the ball in the robot frame, to the left.")
      .def_readonly("frame", &PyStep::frame,
                    "The newest camera frame that the controller has heard of; None before the first.");
  py::class_<PyRun>(module, "Run",
                    R"(A closed-loop run, step by step: what simulate drives to its end, with its arguments.

    run = ballservo.Run(scenario)
    for step in run:
        print(step.time_s, step.pose, step.command, step.state)
    print(run.summary["outcome"])

What law, robot or camera raise ends the run and comes out of the step. Its results are there once it is over.)")
      .def(py::init<const Scenario&, const std::string&, py::object, py::object, py::object>(),
           py::arg("scenario"), py::arg("perception") = "geometric", py::kw_only(),
           py::arg("law") = py::none(), py::arg("robot") = py::none(), py::arg("camera") = py::none())
      .def(
          "step", &PyRun::step,
          "Does the next control step, with the camera frames that are due before it; None: the run is over.")
      .def("__iter__", [](const py::object& run) { return run; })
      .def("__next__",
           [](PyRun& run) {
             if (auto step = run.step()) return *step;
             throw py::stop_iteration();
           })
      .def("stop", &PyRun::stop, "Ends the run here: its summary says interrupted.")
      .def_property_readonly("over", &PyRun::over, "Whether it is.")
      .def_property_readonly(
          "summary", [](const PyRun& r) { return python_of(r.summary_json()); }, "As summary.json.")
      .def_property_readonly("log_csv", &PyRun::log_csv, "As log.csv: one row a control step.")
      .def_property_readonly("tracks_csv", &PyRun::tracks_csv, "As tracks.csv.")
      .def_property_readonly(
          "log", [](const PyRun& r) { return columns_of(r.log_csv()); },
          "log.csv as an array a column, by its name; NaN where a cell is empty.")
      .def_property_readonly(
          "tracks", [](const PyRun& r) { return columns_of(r.tracks_csv()); }, "The same of tracks.csv.");
  module.def("simulate", &simulate, py::arg("scenario"), py::arg("perception") = "geometric", py::kw_only(),
             py::arg("law") = py::none(), py::arg("robot") = py::none(), py::arg("camera") = py::none(),
             py::arg("on_step") = py::none(),
             R"(Drives a scenario to its end; perception image, geometric or truth.

law(p_CB, v_CB) -> (v_mps, w_radps), or None where there is no answer: instead of the scenario's law.
    p_CB: the ball's centre in the frame of the camera looking straight ahead, m, (3,); v_CB: its velocity over ground in its axes, m/s.
robot: what is driven instead of the scenario's drive. robot.command(v_mps, w_radps) is told to it;
    robot.advance(time_s) -> (x_m, y_m, yaw_rad, v_mps, w_radps) moves it on to a time not before the last,
    the first being 0: its true pose in the world and its speeds.
camera(X_WC, time_s) -> bgr: takes the pictures instead of the renderer, for perception image.
    X_WC: the camera's pose in the world, (4, 4); bgr: uint8 (height, width, 3) of the camera's size.
on_step(step): called after each control step.

What they raise ends the run and comes out of this call.)");
}

}  // namespace ballservo
