// Calibrations, sweeps and comparisons, as the commands do them.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/commands/ball_options.hpp"
#include "app/commands/calibrate_camera.hpp"
#include "app/comparison/comparison.hpp"
#include "app/comparison/pictures/picture_files.hpp"
#include "app/comparison/pictures/plan_pictures.hpp"
#include "app/python/bindings.hpp"
#include "app/sweep/grid.hpp"
#include "app/sweep/sweep_statistics.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/output.hpp"

namespace ballservo {
namespace {

/// A journal of its own for a job that nobody resumes.
struct Notes {
  TemporaryFolder folder;
  Journal journal{folder.path() / "notes", "python", [](auto&&...) { return true; }};
};

struct FinishedCalibration {
  KnownCamera camera;
  std::string summary_json;
};

/// Puts a source where it belongs.
void add_source(CalibrateCameraOptions& options, const py::handle& source, const std::string& name) {
  if (py::isinstance<py::array>(source)) {
    options.stills.push_back(picture_of(py::reinterpret_borrow<py::array>(source), name, true));
  } else {
    try {
      options.sources.push_back(source.cast<Path>().string());
    } catch (const py::cast_error&) {
      throw InputError(name, py::repr(py::type::of(source)).cast<std::string>(),
                       "a file's name, or an array of its pixels");
    }
  }
}

FinishedCalibration calibrate(const py::object& sources, const std::string& board, double square_m,
                              const std::string& model, const std::string& format, int threads) {
  FaultList faults;
  check_range(faults, "threads", threads, 0, max_threads);
  faults.throw_if_any();
  const bool listed = py::isinstance<py::sequence>(sources) && !py::isinstance<py::str>(sources) &&
                      !py::isinstance<py::array>(sources);
  if (!listed)
    throw InputError("sources", py::repr(py::type::of(sources)).cast<std::string>(),
                     "a list of files, or of pictures");
  CalibrateCameraOptions options;
  const auto given = sources.cast<std::vector<py::object>>();
  for (std::size_t k = 0; k < given.size(); ++k)
    faults.collect([&] { add_source(options, given[k], fmt::format("picture {}", k + 1)); });
  faults.throw_if_any();
  if (options.stills.empty() == options.sources.empty())
    throw InputError("sources", given.empty() ? "none" : "files and arrays", "a list of files, or of arrays");
  return hearing_ctrl_c([&] {
    options.board_text = board;
    options.square_m = square_m;
    options.model = model;
    options.common.threads = threads;
    options.common.quiet = true;
    const CameraCalibration done = calibrate_camera(options, camera_file_format(format, ""));
    return FinishedCalibration{{done.result.camera, done.result.covariance.parameters},
                               results_json(done).dump()};
  });
}

/// As --vary takes it: "law.gain_per_s=0.5,1,2".
std::string vary_text(const py::handle& key, const py::handle& values) {
  const py::object dumps = py::module_::import("json").attr("dumps");
  const py::object item = py::module_::import("operator").attr("methodcaller")("item");
  std::string text = py::str(key).cast<std::string>() + "=";
  try {
    if (py::isinstance<py::str>(values)) throw py::type_error("a word is no list");
    for (const py::handle value : values)
      text += (text.back() == '=' ? "" : ",") +
              py::str(py::isinstance<py::str>(value) ? value : dumps(value, py::arg("default") = item))
                  .cast<std::string>();
  } catch (const std::exception&) {
    throw InputError("vary: " + py::str(key).cast<std::string>(), py::repr(values).cast<std::string>(),
                     "a list of values, each as a scenario has it");
  }
  return text;
}

struct FinishedSweep {
  std::string summary_json, trials_csv, grid_csv;
};

FinishedSweep sweep(const Path& scenario, long trials, const py::dict& vary,
                    const std::vector<std::string>& sets, const std::string& perception, std::uint64_t seed,
                    int threads) {
  SweepOptions options;
  options.scenario = scenario;
  options.sets = sets;
  options.perception = parse_perception_level(perception);
  options.first_seed = seed;
  options.trials = trials;
  options.threads = threads;
  FaultList faults;
  check_range(faults, "trials", static_cast<double>(trials), 1, SweepOptions::max_trials);
  check_range(faults, "threads", threads, 0, max_threads);
  faults.throw_if_any();
  std::vector<std::string> varied;
  for (const auto& [key, values] : vary) varied.push_back(vary_text(key, values));
  return hearing_ctrl_c([&]() -> FinishedSweep {
    const auto [works, job] = plan_sweeps(options, varied);
    Notes notes;
    const std::vector<Sweep> done = run_sweeps(
        works, notes.journal, [] { return !interrupt_requested(); }, [](long, long) {});
    throw_if_interrupted();
    if (!is_grid(job))
      return {sweep_summary_json(done.front(), {}, false, nullptr).dump(), done.front().trials_csv, ""};
    return {grid_summary_json(job, done, {}, false).dump(), grid_trials_csv(done), grid_csv(job, done)};
  });
}

/// The tables by their names.
std::map<std::string, py::object> compare(const std::optional<Path>& plan_file, std::uint64_t seed,
                                          int threads, const std::optional<Path>& images,
                                          const std::optional<Path>& truth, const Path& colors,
                                          const Path& camera, double diameter, const std::string& start) {
  FaultList faults;
  check_range(faults, "threads", threads, 0, max_threads);
  if (plan_file.has_value() == images.has_value() || images.has_value() != truth.has_value())
    faults.add("plan, images, truth",
               plan_file ? "a plan and more"
               : images  ? "no truth"
               : truth   ? "no images"
                         : "none of them",
               "a plan, or images and truth");
  check_range(faults, "diameter", diameter, 0, 10);
  if (start != "vote" && start != "truth") faults.add("start", start, "vote or truth");
  faults.throw_if_any();
  const auto tables = hearing_ctrl_c([&] {
    ComparisonPlan plan;  // the source looks at it
    if (plan_file) plan = read_comparison_plan(*plan_file);
    plan.seed += seed;
    std::unique_ptr<PictureSource> source;
    if (plan_file) {
      source = std::make_unique<PlanPictures>(plan);
    } else {
      PictureFilesOptions options{*images,          *truth, colors.string(), camera.string(), diameter,
                                  start == "truth", seed};
      for (const FitMethod& method : fit_methods()) plan.methods.push_back(&method);
      source = std::make_unique<PictureFiles>(options);
    }
    const std::vector<ComparisonUnit> units = comparison_units(source->conditions());
    Notes notes;
    run_units(*source, plan.methods, units, notes.journal, threads, [](long) { throw_if_interrupted(); });
    std::map<std::string, std::string> files;
    collect_results(source->conditions(), plan.methods, units, notes.journal, plan.seed,
                    [&](const std::string& name, std::string_view rows) { files[name] += rows; });
    return files;
  });
  std::map<std::string, py::object> columns;
  for (const auto& [name, text] : tables)
    if (const Path file = name; file.extension() == ".csv") columns[file.stem().string()] = columns_of(text);
  return columns;
}

}  // namespace

void add_studies(py::module_& module) {
  py::class_<FinishedCalibration>(module, "CameraCalibration", "A camera from pictures of a board.")
      .def_readonly("camera", &FinishedCalibration::camera, "With its covariance.")
      .def_property_readonly(
          "summary", [](const FinishedCalibration& c) { return python_of(c.summary_json); },
          "As `calibrate camera --json`: errors (px), pictures used and not, models tried, warnings, "
          "advice.");
  module.def("calibrate_camera", &calibrate, py::arg("sources"), py::arg("board"), py::arg("square_m"),
             py::arg("model") = "auto", py::arg("format") = "ros", py::arg("threads") = 0,
             "A camera from pictures, folders of them or videos of a board, as `ballservo calibrate camera`. "
             "sources: their files; or the pictures themselves, uint8 (height, width, 3), blue green red, or "
             "(height, width), which the summary names picture 1 and so on. "
             "board chessboard:9x6 (inner corners), circles:6x6 or acircles:4x11; model auto is the simplest "
             "that files of the format (visp, ros, opencv, kalibr) hold and that does.");
  py::class_<FinishedSweep>(module, "Sweep", "Runs of a scenario, one a seed.")
      .def_property_readonly(
          "summary", [](const FinishedSweep& s) { return python_of(s.summary_json); }, "As summary.json.")
      .def_property_readonly(
          "trials", [](const FinishedSweep& s) { return columns_of(s.trials_csv); },
          "trials.csv as an array a column: a trial a row.")
      .def_property_readonly(
          "grid",
          [](const FinishedSweep& s) { return s.grid_csv.empty() ? py::none() : columns_of(s.grid_csv); },
          "grid.csv as an array a column, a cell a row, the last key's values changing fastest; None for "
          "one scenario without vary.");
  module.def(
      "sweep", &sweep, py::arg("scenario"), py::arg("trials"), py::arg("vary") = py::dict(),
      py::arg("sets") = std::vector<std::string>{}, py::arg("perception") = "geometric", py::arg("seed") = 0,
      py::arg("threads") = 0,
      "Runs the file of a scenario, or of a suite, many times, trial k with seed + k, as `ballservo sweep`; "
      "vary={\"law.gain_per_s\": [0.5, 1, 2]} for every combination of values, "
      "the last key's changing fastest.");
  module.def(
      "compare", &compare, py::arg("plan") = py::none(), py::arg("seed") = 0, py::arg("threads") = 0,
      py::kw_only(), py::arg("images") = py::none(), py::arg("truth") = py::none(), py::arg("colors") = "",
      py::arg("camera") = "", py::arg("diameter") = 0.0, py::arg("start") = "vote",
      "Runs every estimator on the pictures of a plan's file, or on those of the folder `images`, whose "
      "balls the table `truth` tells, as `ballservo compare`: its tables by name (compare, fits, frames, "
      "pairs, tests ...), each an array a column. colors, camera: files; diameter in m, 0: not known; "
      "start of the fits: vote (needs colors) or truth.");
}

}  // namespace ballservo
