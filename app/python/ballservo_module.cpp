// What `import ballservo` brings: the library's parts over numpy arrays.
#include <fmt/format.h>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/commands/ball_options.hpp"
#include "app/commands/command.hpp"
#include "app/experiment/run_log.hpp"
#include "app/experiment/runner.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/camera/files/camera_file.hpp"
#include "calibration/color/color_file.hpp"
#include "calibration/teaching/learn_colors.hpp"
#include "perception/segmentation/classification.hpp"
#include "perception/tracking/tracker.hpp"

namespace py = pybind11;

namespace ballservo {
namespace {

using Points3 = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// The picture where it lies. A view that OpenCV cannot look at is refused: nothing is copied unasked.
cv::Mat picture_of(const py::array& bgr) {
  const bool pixels = bgr.dtype().kind() == 'u' && bgr.itemsize() == 1 && bgr.ndim() == 3 &&
                      bgr.shape(2) == 3 && bgr.shape(0) > 0 && bgr.shape(1) > 0 && bgr.shape(0) <= 65536 &&
                      bgr.shape(1) <= 65536;
  if (!pixels)
    throw InputError("bgr",
                     py::str("an array of {} {}").format(bgr.dtype(), bgr.attr("shape")).cast<std::string>(),
                     "uint8 of shape (height, width, 3), in the order blue, green, red");
  const py::ssize_t row = 3 * bgr.shape(1);
  if (bgr.strides(2) != 1 || bgr.strides(1) != 3 || (bgr.shape(0) > 1 && bgr.strides(0) < row))
    throw InputError(
        "bgr", py::str("strides of {} bytes").format(bgr.attr("strides")).cast<std::string>(),
        "rows of pixels side by side, from the top down; numpy.ascontiguousarray(bgr) copies such "
        "a view");
  return cv::Mat(static_cast<int>(bgr.shape(0)), static_cast<int>(bgr.shape(1)), CV_8UC3,
                 const_cast<void*>(bgr.data()),
                 static_cast<std::size_t>(bgr.shape(0) > 1 ? bgr.strides(0) : row));
}

void check_columns(const Points3& points, int columns, const char* name) {
  if (points.ndim() != 2 || points.shape(1) != columns)
    throw InputError(name, py::str("an array of shape {}").format(points.attr("shape")).cast<std::string>(),
                     "shape (N, " + std::to_string(columns) + ")");
}

/// Row by row; NaN where there is no answer.
template <int In, int Out, class Function>
py::array_t<double> each_row(const Points3& points, const char* name, Function&& function) {
  check_columns(points, In, name);
  py::array_t<double> result({points.shape(0), py::ssize_t{Out}});
  const double* const in = points.data();
  double* const out = result.mutable_data();
  const py::ssize_t count = points.shape(0);
  const py::gil_scoped_release released;
  for (py::ssize_t i = 0; i < count; ++i) {
    const auto answer = function(Eigen::Map<const Eigen::Matrix<double, In, 1>>(in + In * i));
    Eigen::Map<Eigen::Matrix<double, Out, 1>> row(out + Out * i);
    if (answer)
      row = *answer;
    else
      row.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  return result;
}

/// A ball in a picture, with its class's name.
struct SeenBall {
  int track_id = 0;  // 0: of a detection
  std::string color_class, state;
  BallObservation seen;
};

/// The options of the command line, and one thread at a time.
class Looks {
 public:
  Looks(std::string colors, std::string camera, const std::string& diameter, std::string fit,
        std::string response, std::uint64_t seed)
      : factory_(
            checked({std::move(colors), std::move(camera), diameter, std::move(fit), std::move(response)}),
            common(seed)) {}

 protected:
  SeenBall ball(const BallObservation& seen, ClassIndex color_class, std::string_view state,
                int track_id) const {
    return {track_id, factory_.colors().name_of(color_class), std::string(state),
            factory_.with_total_covariance(seen)};
  }
  DetectorFactory factory_;
  std::mutex mutex_;

 private:
  static BallOptions checked(BallOptions options) {
    if (options.camera.empty() != options.diameter.empty())
      throw InputError("camera, diameter", "one of them", "both, for positions in 3-D, or neither");
    for (const auto& [name, value, allowed] :
         {std::tuple("fit", options.fit, std::vector<std::string>{"sphere", "paper"}),
          std::tuple("response", options.response, std::vector<std::string>{"auto", "linear", "srgb"})})
      if (std::find(allowed.begin(), allowed.end(), value) == allowed.end())
        throw InputError(name, value, fmt::format("{}", fmt::join(allowed, ", ")));
    return options;
  }
  static CommonOptions common(std::uint64_t seed) {
    CommonOptions options;
    options.seed = seed;
    return options;
  }
};

class PyDetector : public Looks {
 public:
  using Looks::Looks;
  std::vector<SeenBall> detect(const py::array& bgr) {
    const cv::Mat picture = picture_of(bgr);
    const py::gil_scoped_release released;
    const std::lock_guard lock(mutex_);
    const std::pair key(picture.cols, picture.rows);
    auto found = detectors_.find(key);
    if (found == detectors_.end())
      found = detectors_.emplace(key, factory_.make({picture.cols, picture.rows}, "bgr")).first;
    found->second.doubt_response();
    std::vector<SeenBall> balls;
    for (const BallObservation& seen : found->second.detect(picture))
      balls.push_back(ball(seen, seen.color_class, "detected", 0));
    return balls;
  }

 private:
  std::map<std::pair<int, int>, Detector> detectors_;
};

class PyTracker : public Looks {
 public:
  PyTracker(std::string colors, std::string camera, const std::string& diameter, std::string fit,
            std::string response, std::uint64_t seed, bool fixed_colors)
      : Looks(std::move(colors), std::move(camera), diameter, std::move(fit), std::move(response), seed) {
    options_.fixed_colors = fixed_colors;
  }
  std::vector<SeenBall> update(const py::array& bgr, double time_s) {
    const cv::Mat picture = picture_of(bgr);
    if (!std::isfinite(time_s)) throw InputError("time_s", number_text(time_s), "a finite number (s)");
    const py::gil_scoped_release released;
    const std::lock_guard lock(mutex_);
    if (!tracker_) tracker_.emplace(factory_.make({picture.cols, picture.rows}, "bgr"), options_);
    std::vector<SeenBall> balls;
    for (const Track& track : tracker_->update(picture, time_s))
      balls.push_back(ball(track.ball, track.color_class, track_state_name(track.state), track.id));
    return balls;
  }

 private:
  TrackerOptions options_;
  std::optional<Tracker> tracker_;
};

/// A class of each name from its pictures; under no name, one of every round colour.
std::shared_ptr<ColorTable> learn(const std::map<std::string, std::vector<py::array>>& pictures) {
  std::vector<ColorPicture> seen;
  std::vector<ClassRequest> requests;
  for (const auto& [name, arrays] : pictures) {
    requests.push_back({name, {}, std::nullopt});
    for (const py::array& bgr : arrays) {
      requests.back().pictures.push_back(seen.size());
      seen.push_back(
          {fmt::format("picture {} of {}", requests.back().pictures.size(), name), picture_of(bgr)});
    }
    if (arrays.empty()) throw InputError(name, "no pictures", "at least one");
  }
  if (seen.empty()) throw InputError("pictures", "none", "at least one");
  const py::gil_scoped_release released;
  return std::make_shared<ColorTable>(pictures.size() == 1 && requests.front().name.empty()
                                          ? learn_colors(seen).table
                                          : learn_classes(seen, requests).table);
}

py::object python_of(const std::string& json) { return py::module_::import("json").attr("loads")(json); }

struct FinishedRun {
  std::string summary_json, log_csv, tracks_csv;
};

FinishedRun simulate(const Scenario& scenario, const std::string& perception) {
  const py::gil_scoped_release released;
  RunOptions options;
  options.perception = parse_perception_level(perception);
  options.seed = scenario.seed;
  options.colors = colors_of(scenario, options.perception);
  options.go_on = [](double) {
    const py::gil_scoped_acquire held;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    return true;
  };
  const RunRecord run = run_closed_loop(scenario, options);
  return {summary_json(run.summary, run.timing).dump(), log_csv(run.steps), run.tracks_csv};
}

}  // namespace

PYBIND11_MODULE(_ballservo, module) {
  module.doc() =
      "The library's parts over numpy arrays. Metres, seconds, radians and pixels; camera frame x right, y "
      "down, z forward.";
  py::register_exception<InputError>(module, "InputError", PyExc_ValueError).attr("__doc__") =
      "Bad input: every fault, one a line, with its place, what was found and what is allowed.";
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Refusal& refusal) {
      PyErr_SetString(PyExc_RuntimeError, refusal.what());
    }
  });

  py::class_<Camera>(module, "Camera", "A calibrated camera. Immutable.")
      .def_static("load", &read_camera, py::arg("file"), "Reads FILE, or FILE:NAME where it holds several.")
      .def(
          "save",
          [](const Camera& camera, const std::string& file, const std::string& format, bool overwrite) {
            write_file(file, camera_file_text(camera, camera_file_format(format, file), "camera"),
                       overwrite ? Overwrite::allow : Overwrite::refuse);
          },
          py::arg("file"), py::arg("format") = "", py::arg("overwrite") = false,
          "Writes a file; format visp, ros, opencv or kalibr (empty: by the extension).")
      .def(
          "project",
          [](const Camera& camera, const Points3& p_C) {
            return each_row<3, 2>(p_C, "p_C", [&](const Eigen::Vector3d& p) { return camera.project(p); });
          },
          py::arg("p_C"),
          "Points (N, 3) of the camera frame, m -> pixels (N, 2); NaN where one does not appear.")
      .def(
          "unproject",
          [](const Camera& camera, const Points3& pixel_px) {
            return each_row<2, 3>(pixel_px, "pixel_px",
                                  [&](const Eigen::Vector2d& p) { return camera.unproject(p); });
          },
          py::arg("pixel_px"),
          "Pixels (N, 2) -> unit rays (N, 3) of the camera frame; NaN where none reaches one.")
      .def_property_readonly(
          "model", [](const Camera& c) { return std::string(lens_model_name(c.parameters().model)); })
      .def_property_readonly(
          "size_px", [](const Camera& c) { return std::pair(c.size().width_px, c.size().height_px); },
          "(width, height)");

  py::class_<ColorTable, std::shared_ptr<ColorTable>>(module, "Colors", "Learnt colours of balls.")
      .def_static(
          "load", [](const std::string& file) { return std::make_shared<ColorTable>(read_color_file(file)); },
          py::arg("file"))
      .def(
          "save",
          [](const ColorTable& colors, const std::string& file, bool overwrite) {
            write_file(file, color_file_bytes(colors), overwrite ? Overwrite::allow : Overwrite::refuse);
          },
          py::arg("file"), py::arg("overwrite") = false)
      .def_static(
          "learn", &learn, py::arg("pictures"),
          "Pictures of each class by its name, {\"red\": [bgr, ...]}; under \"\" alone every round colour "
          "becomes a class. RuntimeError where nothing can be learnt.")
      .def_property_readonly("classes",
                             [](const ColorTable& colors) {
                               std::vector<std::string> names;
                               for (const ColorClass& each : colors.classes) names.push_back(each.name);
                               return names;
                             })
      .def(
          "classify",
          [](const ColorTable& colors, const py::array& bgr) {
            const cv::Mat picture = picture_of(bgr);
            py::array_t<std::uint8_t> classes({bgr.shape(0), bgr.shape(1)});
            cv::Mat numbers(picture.size(), CV_8UC1, classes.mutable_data());
            const py::gil_scoped_release released;
            for (int y = 0; y < picture.rows; ++y)
              for (int x = 0; x < picture.cols; ++x) {
                const cv::Vec3b& p = picture.at<cv::Vec3b>(y, x);
                numbers.at<std::uint8_t>(y, x) = colors.classify(p[0], p[1], p[2]);
              }
            return classes;
          },
          py::arg("bgr"), "Class numbers (height, width), uint8: 0 none, k for classes[k - 1].");

  py::class_<SeenBall>(module, "Ball", "A ball in a picture.")
      .def_property_readonly(
          "track_id",
          [](const SeenBall& b) { return b.track_id > 0 ? std::optional(b.track_id) : std::nullopt; },
          "The ball's identity, from 1; None of a detection.")
      .def_readonly("color_class", &SeenBall::color_class)
      .def_readonly("state", &SeenBall::state, "detected; of a track tentative, confirmed or coasting")
      .def_property_readonly(
          "quality", [](const SeenBall& b) { return b.seen.quality; }, "0 to 1")
      .def_property_readonly(
          "outline_px",
          [](const SeenBall& b) {
            const auto& o = b.seen.outline;
            return Eigen::Vector3d(o.center_px.x(), o.center_px.y(), o.radius_px);
          },
          "The outline's ellipse in the picture: centre x, y; geometric mean of the semi-axes.")
      .def_property_readonly(
          "p_m",
          [](const SeenBall& b) {
            return b.seen.position ? std::optional(b.seen.position->p_C) : std::nullopt;
          },
          "The centre (3,) in the camera frame; None without camera and diameter.")
      .def_property_readonly(
          "covariance_m2",
          [](const SeenBall& b) {
            return b.seen.position ? std::optional(b.seen.position->covariance_m2) : std::nullopt;
          },
          "Of p_m (3, 3); None where that is.");

  py::class_<PyDetector>(
      module, "Detector",
      "Finds balls in single pictures, as `ballservo detect` does in the taught light. Threads "
      "take turns with one; two work side by side.")
      .def(py::init<std::string, std::string, std::string, std::string, std::string, std::uint64_t>(),
           py::arg("colors"), py::arg("camera") = "", py::arg("diameter") = "", py::arg("fit") = "sphere",
           py::arg("response") = "auto", py::arg("seed") = 0,
           "Files and words as the command line takes them: diameter is METRES[+-SIGMA] or NAME=METRES,...")
      .def("detect", &PyDetector::detect, py::arg("bgr"),
           "The balls in a picture, uint8 (height, width, 3), best first.");
  py::class_<PyTracker>(module, "Tracker",
                        "Follows balls from picture to picture, as `ballservo track` does.")
      .def(py::init<std::string, std::string, std::string, std::string, std::string, std::uint64_t, bool>(),
           py::arg("colors"), py::arg("camera") = "", py::arg("diameter") = "", py::arg("fit") = "sphere",
           py::arg("response") = "auto", py::arg("seed") = 0, py::arg("fixed_colors") = false)
      .def("update", &PyTracker::update, py::arg("bgr"), py::arg("time_s"),
           "The tracks in the picture taken at time_s, in order of track_id; a time that does not advance is "
           "ignored.");

  py::class_<Scenario>(module, "Scenario", "A scenario as one seed has it.")
      .def(py::init([](const std::string& file, const std::vector<std::string>& sets, std::uint64_t seed) {
             return load_scenario(file, sets, seed);
           }),
           py::arg("file"), py::arg("sets") = std::vector<std::string>{}, py::arg("seed") = 0,
           "sets: \"key.path=value\" each")
      .def_property_readonly(
          "document", [](const Scenario& s) { return python_of(s.resolved_json); },
          "What stands in it, after sets and what the seed drew.")
      .def_readonly("seed", &Scenario::seed);
  py::class_<FinishedRun>(module, "Run", "A closed-loop run.")
      .def_property_readonly(
          "summary", [](const FinishedRun& r) { return python_of(r.summary_json); }, "As summary.json.")
      .def_readonly("log_csv", &FinishedRun::log_csv, "As log.csv: one row a control step.")
      .def_readonly("tracks_csv", &FinishedRun::tracks_csv, "As tracks.csv.");
  module.def("simulate", &simulate, py::arg("scenario"), py::arg("perception") = "geometric",
             "Drives a scenario to its end; perception image, geometric or truth.");
}

}  // namespace ballservo
