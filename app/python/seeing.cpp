// Cameras, colours, and what finds balls.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <tuple>
#include <variant>

#include "app/commands/ball_options.hpp"
#include "app/commands/command.hpp"
#include "app/python/bindings.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/camera/files/camera_file.hpp"
#include "calibration/color/color_file.hpp"
#include "calibration/teaching/class_report.hpp"
#include "calibration/teaching/learn_colors.hpp"
#include "perception/tracking/tracker.hpp"

namespace ballservo {
namespace {

using Points3 = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Row by row; NaN where there is no answer.
template <int In, int Out, class Function>
py::array_t<double> each_row(const Points3& points, const char* name, Function&& function) {
  if (points.ndim() != 2 || points.shape(1) != In)
    throw InputError(name, py::str("an array of shape {}").format(points.attr("shape")).cast<std::string>(),
                     "shape (N, " + std::to_string(In) + ")");
  py::array_t<double> result({points.shape(0), py::ssize_t{Out}});
  const Eigen::Map<const Eigen::Matrix<double, In, Eigen::Dynamic>> in(points.data(), In, points.shape(0));
  Eigen::Map<Eigen::Matrix<double, Out, Eigen::Dynamic>> out(result.mutable_data(), Out, in.cols());
  const py::gil_scoped_release released;
  out.setConstant(std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index i = 0; i < in.cols(); ++i)
    if (const auto answer = function(in.col(i))) out.col(i) = *answer;
  return result;
}

/// A ball in a picture, with its class's name.
struct SeenBall {
  int track_id = 0;  // 0: of a detection
  std::string color_class, state;
  BallObservation seen;
};

using GivenColors = std::variant<std::shared_ptr<ColorTable>, Path>;
using GivenCamera = std::optional<std::variant<Path, KnownCamera>>;

/// What finds balls, by the options of the command line.
DetectorFactory factory_of(const GivenColors& colors, const GivenCamera& camera, const py::object& diameter,
                           const std::string& fit, const std::string& response, std::uint64_t seed) {
  BallOptions options;
  if (const auto* file = std::get_if<Path>(&colors))
    options.colors = file->string();
  else
    options.color_table = std::get<0>(colors);
  if (const auto* file = camera ? std::get_if<Path>(&*camera) : nullptr)
    options.camera = file->string();
  else if (camera)
    options.known_camera = std::get<KnownCamera>(*camera);
  if (!diameter.is_none()) options.diameter = py::str(diameter);
  options.fit = fit;
  options.response = response;
  if (options.has_camera() == options.diameter.empty())
    throw InputError("camera, diameter", "one of them", "both, for positions in 3-D, or neither");
  for (const auto& [name, value, allowed] :
       {std::tuple("fit", fit, std::vector<std::string>{"sphere", "paper"}),
        std::tuple("response", response, std::vector<std::string>{"auto", "linear", "srgb"})})
    if (std::find(allowed.begin(), allowed.end(), value) == allowed.end())
      throw InputError(name, value, fmt::format("{}", fmt::join(allowed, ", ")));
  CommonOptions common;
  common.seed = seed;
  return DetectorFactory(options, common);
}

SeenBall seen_ball(const DetectorFactory& factory, const BallObservation& seen, ClassIndex color_class,
                   std::string_view state, int track_id) {
  return {track_id, factory.colors().name_of(color_class), std::string(state),
          factory.with_total_covariance(seen)};
}

/// One thread at a time.
class PyDetector {
 public:
  explicit PyDetector(DetectorFactory factory) : factory_(std::move(factory)) {}
  std::vector<SeenBall> detect(const py::array& bgr) {
    const cv::Mat picture = picture_of(bgr);
    const py::gil_scoped_release released;
    const std::lock_guard lock(mutex_);
    const std::pair key(picture.cols, picture.rows);
    auto found = detectors_.find(key);
    if (found == detectors_.end())
      found =
          detectors_.emplace(key, factory_.make({picture.cols, picture.rows}, "bgr", {true, false})).first;
    found->second.forget_response();
    std::vector<SeenBall> balls;
    for (const BallObservation& seen : found->second.detect(picture))
      balls.push_back(seen_ball(factory_, seen, seen.color_class, "detected", 0));
    return balls;
  }

 private:
  DetectorFactory factory_;
  std::mutex mutex_;
  std::map<std::pair<int, int>, Detector> detectors_;
};

/// One thread at a time.
class PyTracker {
 public:
  PyTracker(DetectorFactory factory, bool fixed_colors) : factory_(std::move(factory)) {
    options_.fixed_colors = fixed_colors;
  }
  std::vector<SeenBall> update(const py::array& bgr, double time_s) {
    const cv::Mat picture = picture_of(bgr);
    if (!std::isfinite(time_s)) throw InputError("time_s", fmt::format("{}", time_s), "a finite number (s)");
    const py::gil_scoped_release released;
    const std::lock_guard lock(mutex_);
    if (!tracker_) tracker_.emplace(factory_.make({picture.cols, picture.rows}, "bgr"), options_);
    std::vector<SeenBall> balls;
    for (const Track& track : tracker_->update(picture, time_s))
      balls.push_back(
          seen_ball(factory_, track.ball, track.color_class, track_state_name(track.state), track.id));
    return balls;
  }

 private:
  DetectorFactory factory_;
  std::mutex mutex_;
  TrackerOptions options_;
  std::optional<Tracker> tracker_;
};

using Pictures = std::vector<py::array>;

Pictures pictures_of(const py::handle& value, const std::string& name) {
  try {
    return value.cast<Pictures>();
  } catch (const py::cast_error&) {
    throw InputError("pictures of " + name, py::repr(py::type::of(value)).cast<std::string>(),
                     "a list of pictures, uint8 (height, width, 3)");
  }
}

/// A class of each name from its pictures; under no name, one of every round colour.
std::shared_ptr<ColorTable> learn(const py::dict& pictures, const std::map<std::string, Eigen::Vector3d>& at,
                                  const Pictures& background) {
  std::vector<ColorPicture> seen, off;
  std::vector<ClassRequest> requests;
  const auto add = [](std::vector<ColorPicture>& to, const Pictures& arrays, const std::string& name) {
    for (std::size_t k = 0; k < arrays.size(); ++k)
      to.push_back({fmt::format("picture {} of {}", k + 1, name), picture_of(arrays[k])});
  };
  FaultList faults;
  for (const auto& [key, value] : pictures) {
    if (!py::isinstance<py::str>(key))
      throw InputError("pictures", py::repr(key).cast<std::string>(), "names of classes, str");
    const auto name = key.cast<std::string>();
    const Pictures arrays = pictures_of(value, name);
    ClassRequest& request = requests.emplace_back();
    request.name = name;
    for (std::size_t k = 0; k < arrays.size(); ++k) request.pictures.push_back(seen.size() + k);
    faults.collect([&] { add(seen, arrays, name); });
    if (arrays.empty()) faults.add(name, "no pictures", "at least one");
    if (const auto ball = at.find(name); ball != at.end())
      request.at = PointedBall{ball->second.head<2>(), ball->second.z()};
  }
  faults.collect([&] { add(off, background, "the background"); });
  for (const auto& ball : at)
    if (ball.first.empty() || !pictures.contains(ball.first.c_str()))
      faults.add("at", ball.first, "the name of a class of pictures");
  if (pictures.empty()) faults.add("pictures", "none", "at least one");
  if (pictures.size() > 1 && pictures.contains(""))
    faults.add("pictures", "a class without a name beside others", "names for all, or \"\" alone");
  faults.throw_if_any();
  std::vector<std::string> warnings;
  const LearntColors learnt = hearing_ctrl_c([&] {
    RegionSearchOptions search;
    search.before_each_test = throw_if_interrupted;
    LearntColors colors = requests.front().name.empty() ? learn_colors(seen, search, off)
                                                        : learn_classes(seen, requests, search, off);
    warnings = warnings_of(colors, report_classes(colors.table));
    return colors;
  });
  for (const std::string& warning : warnings)
    if (PyErr_WarnEx(PyExc_UserWarning, warning.c_str(), 1) != 0) throw py::error_already_set();
  return std::make_shared<ColorTable>(learnt.table);
}

}  // namespace

void add_seeing(py::module_& module) {
  py::class_<KnownCamera>(module, "Camera", "A calibrated camera. Immutable.")
      .def_static(
          "load", [](const Path& file) { return read_known_camera(file.string()); }, py::arg("file"),
          "Reads FILE, or FILE:NAME where it holds several, and FILE.covariance.json where that is.")
      .def(
          "save",
          [](const KnownCamera& known, const Path& file, const std::string& format, bool overwrite) {
            const Overwrite over = overwrite ? Overwrite::allow : Overwrite::refuse;
            const std::string text =
                camera_file_text(known.camera, camera_file_format(format, file), file.stem().string());
            if (known.covariance)
              write_file(covariance_file_name(file.string()),
                         camera_covariance_text(known.camera, *known.covariance), over);
            write_file(file, text, over);
          },
          py::arg("file"), py::arg("format") = "", py::arg("overwrite") = false,
          "Writes FILE, format visp, ros, opencv or kalibr (empty: by the extension), and "
          "FILE.covariance.json where the covariance is known.")
      .def(
          "project",
          [](const KnownCamera& known, const Points3& p_C) {
            return each_row<3, 2>(p_C, "p_C",
                                  [&](const Eigen::Vector3d& p) { return known.camera.project(p); });
          },
          py::arg("p_C"),
          "Points (N, 3) of the camera frame, m -> pixels (N, 2); NaN where one does not appear.")
      .def(
          "unproject",
          [](const KnownCamera& known, const Points3& pixel_px) {
            return each_row<2, 3>(pixel_px, "pixel_px",
                                  [&](const Eigen::Vector2d& p) { return known.camera.unproject(p); });
          },
          py::arg("pixel_px"),
          "Pixels (N, 2) -> unit rays (N, 3) of the camera frame; NaN where none reaches one.")
      .def_property_readonly(
          "model",
          [](const KnownCamera& c) { return std::string(lens_model_name(c.camera.parameters().model)); },
          "pinhole, visp, brown, brown8 or kannala_brandt")
      .def_property_readonly(
          "size_px",
          [](const KnownCamera& c) { return std::pair(c.camera.size().width_px, c.camera.size().height_px); },
          "(width, height)")
      .def_property_readonly(
          "parameters",
          [](const KnownCamera& c) {
            const Eigen::VectorXd values = parameter_vector(c.camera.parameters());
            py::dict parameters;
            Eigen::Index i = 0;
            for (const std::string& name : parameter_names(c.camera.parameters().model))
              parameters[name.c_str()] = values(i++);
            return parameters;
          },
          "fx_px, fy_px, cx_px, cy_px and the model's coefficients, by name.")
      .def_property_readonly(
          "covariance", [](const KnownCamera& c) { return c.covariance; },
          "Of the parameters in their order; None where it is not known.");

  py::class_<ColorTable, std::shared_ptr<ColorTable>>(module, "Colors", "Learnt colours of balls.")
      .def_static(
          "load", [](const Path& file) { return std::make_shared<ColorTable>(read_color_file(file)); },
          py::arg("file"), "Reads a colours file.")
      .def(
          "save",
          [](const ColorTable& colors, const Path& file, bool overwrite) {
            write_file(file, color_file_bytes(colors), overwrite ? Overwrite::allow : Overwrite::refuse);
          },
          py::arg("file"), py::arg("overwrite") = false, "Writes a colours file.")
      .def_static(
          "learn", &learn, py::arg("pictures"), py::arg("at") = std::map<std::string, Eigen::Vector3d>{},
          py::arg("background") = Pictures{},
          "Pictures of each class by its name, {\"red\": [bgr, ...]}; under \"\" alone every round colour "
          "becomes a class. at: {\"red\": (x, y, radius)}, px, the ball meant in the first picture of its "
          "class; background: pictures without a ball. What is doubtful is warned of; RuntimeError where "
          "nothing can be learnt.")
      .def_property_readonly("classes", &ColorTable::class_names,
                             "Their names; class k of `classify` is classes[k - 1].")
      .def(
          "classify",
          [](const ColorTable& colors, const py::array& bgr) {
            const cv::Mat picture = picture_of(bgr);
            py::array_t<std::uint8_t> classes({bgr.shape(0), bgr.shape(1)});
            std::uint8_t* const numbers = classes.mutable_data();
            const py::gil_scoped_release released;
            std::transform(picture.begin<cv::Vec3b>(), picture.end<cv::Vec3b>(), numbers,
                           [&](const cv::Vec3b& p) { return colors.classify(p[0], p[1], p[2]); });
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
          "outline_px", [](const SeenBall& b) { return array_of(b.seen.outline); },
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
      .def(py::init([](const GivenColors& colors, const GivenCamera& camera, const py::object& diameter,
                       const std::string& fit, const std::string& response, std::uint64_t seed) {
             return std::make_unique<PyDetector>(factory_of(colors, camera, diameter, fit, response, seed));
           }),
           py::arg("colors"), py::arg("camera") = py::none(), py::arg("diameter") = py::none(),
           py::arg("fit") = "sphere", py::arg("response") = "auto", py::arg("seed") = 0,
           "Colors and Camera, or their files; diameter as the command line takes it: METRES[+-SIGMA] or "
           "NAME=METRES,...; a number is metres.")
      .def("detect", &PyDetector::detect, py::arg("bgr"),
           "The balls in a picture, uint8 (height, width, 3), best first.");
  py::class_<PyTracker>(module, "Tracker",
                        "Follows balls from picture to picture, as `ballservo track` does.")
      .def(py::init([](const GivenColors& colors, const GivenCamera& camera, const py::object& diameter,
                       const std::string& fit, const std::string& response, std::uint64_t seed,
                       bool fixed_colors) {
             return std::make_unique<PyTracker>(factory_of(colors, camera, diameter, fit, response, seed),
                                                fixed_colors);
           }),
           py::arg("colors"), py::arg("camera") = py::none(), py::arg("diameter") = py::none(),
           py::arg("fit") = "sphere", py::arg("response") = "auto", py::arg("seed") = 0,
           py::arg("fixed_colors") = false)
      .def("update", &PyTracker::update, py::arg("bgr"), py::arg("time_s"),
           "The tracks in the picture taken at time_s, in order of track_id; a time that does not advance is "
           "ignored.");
}

}  // namespace ballservo
