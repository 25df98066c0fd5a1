// ballservo calibrate camera: a camera file from pictures of a board, and how far it can be trusted.
#include "app/commands/calibrate_camera.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "app/commands/command.hpp"
#include "app/io/board_pictures.hpp"
#include "app/io/interrupt.hpp"
#include "app/report/draw_pages.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/boards/board_calibration.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "calibration/camera/files/camera_file.hpp"

namespace ballservo {
namespace {

/// The candidates among which `--model` chooses; InputError for a model that the format does not hold.
std::vector<LensModel> models_of(const std::string& name, const CameraFileFormat& format) {
  if (name == "auto") return format.models;
  const auto model = lens_model_from_name(name);
  std::string names = "auto";
  for (const LensModel known : all_lens_models) names += fmt::format(", {}", lens_model_name(known));
  if (!model) throw InputError("--model", name, "one of " + names);
  if (std::find(format.models.begin(), format.models.end(), *model) == format.models.end()) {
    std::string held;
    for (const LensModel known : format.models)
      held += fmt::format("{}{}", held.empty() ? "" : ", ", lens_model_name(known));
    throw InputError("--model", name, fmt::format("what {} holds: {}", format.title, held));
  }
  return {*model};
}

std::size_t corners_set_aside(const BoardCalibration& result) {
  std::size_t count = 0;
  for (const CornerResiduals& corners : result.corners)
    count += static_cast<std::size_t>(std::count(corners.set_aside.begin(), corners.set_aside.end(), true));
  return count;
}

void print_boards(const CameraCalibration& calibration) {
  const auto& [pictures, used, views, result] = calibration;
  print_result("board found in {} of {} pictures of {}x{}\n", used.size(), pictures.all.size(),
               pictures.size.width_px, pictures.size.height_px);
  for (std::size_t i = 0; i < used.size(); ++i)
    print_result("  {}: RMS {:.3f} px{}{}\n", used[i]->name(), result.corners[i].rms_px(),
                 used[i]->remark.empty() ? "" : "; ", used[i]->remark);
  for (const BoardPicture& picture : pictures.all)
    if (!picture.rejected.empty()) print_result("  {}: not used, {}\n", picture.name(), picture.rejected);
}

void print_camera(const BoardCalibration& result) {
  const CameraParameters& p = result.camera.parameters();
  if (result.trials.size() > 1)
    for (const LensCandidate& trial : result.trials)
      print_result("model {}: RMS {}, on boards held out {}{}\n", lens_model_name(trial.model()),
                   pixels_text(trial.adjustment.rms_px), pixels_text(trial.held_out_rms_px()),
                   trial.model() == p.model ? " (chosen)"
                   : trial.usable           ? ""
                                            : " (not usable over the whole picture)");
  print_result("lens model {}\n", lens_model_name(p.model));
  const auto names = parameter_names(p.model);
  const Eigen::VectorXd values = parameter_vector(p);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    print_result("  {} = {:.6g} +- {:.2g}\n", names[i], values(at),
                 std::sqrt(result.covariance.parameters(at, at)));
  }
  const std::size_t aside = corners_set_aside(result);
  print_result("RMS over all corners{} {:.4f} px, on boards held out {}\n",
               aside > 0 ? fmt::format(" but {} set aside", aside) : "", result.rms_px,
               pixels_text(result.held_out_rms_px));
  print_result("corners lie in {:.0f} % of the picture\n", 100 * result.coverage);
  if (result.ball_sigma_mm)
    print_result(
        "this calibration's own uncertainty moves a 70 mm ball at 1 m by {:.2f} mm (1 sigma) where it is "
        "worst in the picture{}\n",
        *result.ball_sigma_mm,
        result.covered_ball_sigma_mm
            ? fmt::format(", typically by {:.2f} mm where boards were", *result.covered_ball_sigma_mm)
            : "");
  for (const std::string& advice : calibration_advice(result)) print_result("next: {}\n", advice);
}

int run_calibrate_camera(const CalibrateCameraOptions& options) {
  constexpr double large_square_m = 0.5;
  if (options.square_m > large_square_m)
    spdlog::warn("--square {:g}: a square of {:g} m? The unit is metres", options.square_m, options.square_m);
  const CameraFileFormat& format = camera_file_format(options.format, options.output);
  const Overwrite overwrite = options.common.overwrite(options.output);
  OutputFile camera_file(options.output, overwrite);
  OutputFile covariance_file(options.output.string() + ".covariance.json", overwrite);
  std::optional<OutputFolder> report;
  if (!options.report.empty()) report.emplace(options.report, options.common.overwrite(options.report));

  const CameraCalibration calibration = calibrate_camera(options, format);
  const BoardCalibration& result = calibration.result;
  throw_if_interrupted();

  camera_file.write(camera_file_text(result.camera, format, options.output.stem().string()));
  covariance_file.write(camera_covariance_text(result.camera, result.covariance.parameters));
  if (report)
    write_report(*report, camera_report(calibration, options.common.max_pixels, *report),
                 options.common.quiet);
  options.common.files->commit(camera_file, covariance_file, report);
  write_json_results(options.common, results_json(calibration));
  for (const std::string& warning : result.warnings) spdlog::warn("{}", warning);
  if (options.common.quiet) return exit_done;
  print_boards(calibration);
  print_camera(result);
  print_result("written: {}\n", std::filesystem::absolute(options.output).string());
  if (report)
    print_result("report: {}\n", (std::filesystem::absolute(options.report) / "report.html").string());
  return exit_done;
}

}  // namespace

CameraCalibration calibrate_camera(const CalibrateCameraOptions& options, const CameraFileFormat& format) {
  const Board board = parse_board(options.board_text, options.square_m);
  const std::vector<LensModel> models = models_of(options.model, format);
  const BoardSearch search{board, options.board_text, options.common.max_pixels, options.common.threads,
                           options.common.quiet};
  BoardPictures pictures =
      options.stills.empty() ? find_boards(options.sources, search) : find_boards(options.stills, search);
  std::vector<const BoardPicture*> used = pictures.used();
  std::vector<BoardView> views;
  for (const BoardPicture* picture : used) views.push_back(*picture->view);
  BoardCalibration result = calibrate_from_boards(pictures.size, views, models);
  return {std::move(pictures), std::move(used), std::move(views), std::move(result)};
}

nlohmann::json results_json(const CameraCalibration& calibration) {
  const auto& [pictures, used, views, result] = calibration;
  const CameraParameters& p = result.camera.parameters();
  nlohmann::json json{{"rms_px", result.rms_px},
                      {"held_out_rms_px", result.held_out_rms_px},
                      {"images", pictures.all.size()},
                      {"used", used.size()},
                      {"corners_set_aside", corners_set_aside(result)},
                      {"coverage", result.coverage},
                      {"noise_px", result.covariance.noise_px},
                      {"structure_px", result.structure_px.value_or(std::nan(""))},
                      {"focal_distance_correlation", result.covariance.focal_distance_correlation},
                      {"rejected", nlohmann::json::array()},
                      {"per_image", nlohmann::json::array()},
                      {"models_tried", nlohmann::json::array()},
                      {"warnings", result.warnings},
                      {"advice", calibration_advice(result)},
                      {"model", lens_model_name(p.model)},
                      {"image_width_px", p.size.width_px},
                      {"image_height_px", p.size.height_px},
                      {"fx_px", p.fx_px},
                      {"fy_px", p.fy_px},
                      {"cx_px", p.cx_px},
                      {"cy_px", p.cy_px},
                      {"ball_sigma_mm", result.ball_sigma_mm.value_or(std::nan(""))},
                      {"ball_sigma_covered_mm", result.covered_ball_sigma_mm.value_or(std::nan(""))}};
  json["coefficients"] =
      std::vector<double>(p.coefficients.begin(), p.coefficients.begin() + coefficient_count(p.model));
  const auto names = parameter_names(p.model);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    json["sigma"][names[i]] = std::sqrt(result.covariance.parameters(at, at));
  }
  for (const BoardPicture& picture : pictures.all)
    if (!picture.rejected.empty())
      json["rejected"].push_back({{"file", picture.name()}, {"reason", picture.rejected}});
  for (std::size_t i = 0; i < used.size(); ++i)
    json["per_image"].push_back({{"file", used[i]->name()},
                                 {"rms_px", result.corners[i].rms_px()},
                                 {"corners", views[i].size()},
                                 {"remark", used[i]->remark}});
  for (const LensCandidate& trial : result.trials)
    json["models_tried"].push_back({{"model", lens_model_name(trial.model())},
                                    {"rms_px", trial.adjustment.rms_px},
                                    {"held_out_rms_px", trial.held_out_rms_px()},
                                    {"usable", trial.usable}});
  return json;
}

void add_calibrate_camera_command(CLI::App& calibrate, Action& action) {
  const auto [command, options] = add_command<CalibrateCameraOptions>(
      calibrate, action, "camera", "Calibrate a camera from pictures of a flat board", run_calibrate_camera);
  add_typed_option(command, "source", options.sources, "SOURCE...",
                   "Pictures of the board, folders of them, videos of it, or camera:N")
      ->required();
  add_typed_option(command, "--board", options.board_text, "BOARD",
                   "chessboard:9x6 (inner corners), circles:6x6 or acircles:4x11 (centres)")
      ->required();
  add_number_option(command, "--square", options.square_m, NumberRange::above(0, "m"),
                    "Side of a square, or distance of circles, in metres")
      ->required();
  add_typed_option(
      command, "--model", options.model, "MODEL",
      "Lens model: auto (default: the simplest that predicts boards it has not seen as well as any, "
      "among those that the file format holds), pinhole, visp, brown, brown8, kannala_brandt");
  add_output_option(command, "-o,--output", options.output, "FILE", "Camera file: .xml is ViSP's, .yaml ROS'")
      ->required();
  add_typed_option(command, "--format", options.format, "FORMAT",
                   "Format of the camera file, whatever its name: visp, ros, opencv, kalibr");
  add_output_option(
      command, "--report", options.report, "DIR",
      "Write report.html into this folder: residuals, coverage, millimetres at the ball, what to do next");
  add_common_options(command, options.common);
  command.footer(R"(Beside FILE, FILE.covariance.json says how well the parameters are known.
Of a video or camera:N pictures are taken where the board stands elsewhere: move it, or the camera, to
different places; 40 of them, or two minutes of a camera, are enough.
Example:
  ballservo calibrate camera left01.jpg left02.jpg left03.jpg --board chessboard:9x6 --square 0.025 --model brown -o left.yaml)");
}

}  // namespace ballservo
