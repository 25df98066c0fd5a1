// ballservo calibrate camera: a camera file from pictures of a board, and how far it can be trusted.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>
#include <thread>

#include "app/commands/command.hpp"
#include "app/io/image_source.hpp"
#include "app/io/interrupt.hpp"
#include "app/io/progress.hpp"
#include "calibration/camera/board_calibration.hpp"
#include "calibration/camera/board_detector.hpp"
#include "calibration/camera/camera_covariance.hpp"
#include "calibration/camera/camera_file.hpp"
#include "calibration/files/fault.hpp"

namespace ballservo {
namespace {

namespace fs = std::filesystem;

struct CalibrateCameraOptions {
  CommonOptions common;
  std::vector<std::string> sources;
  std::string board_text;
  double square_m = std::nan("");
  std::string model = "auto";
  fs::path output;
  std::string format;
  fs::path overlay;
};

/// What became of one picture.
struct Picture {
  fs::path file;
  std::optional<ImageSize> size;  ///< from the header; nothing where only the decoder can tell
  std::optional<BoardView> view;
  std::string rejected;  ///< why it is not used; empty for those that are
  std::exception_ptr error;
};

std::string size_text(ImageSize size) { return fmt::format("{}x{}", size.width_px, size.height_px); }

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

/// The sizes of all pictures before any is decoded; every file that cannot be read is a fault.
std::vector<Picture> list_pictures(const std::vector<std::string>& sources) {
  std::vector<Picture> pictures;
  FaultList faults;
  for (const fs::path& file : image_files(sources)) {
    Picture& picture = pictures.emplace_back();
    picture.file = file;
    try {
      picture.size = image_size_from_header(read_file_bytes(file, std::size_t{1} << 30));
    } catch (const InputError& error) {
      for (const Fault& fault : error.faults()) faults.add(fault.place, fault.found, fault.allowed);
    }
  }
  faults.throw_if_any();
  return pictures;
}

/// The size that most pictures have, the first such one; it is the camera's. Pictures one or two pixels off
/// are set aside; larger differences mean that the pictures are of different cameras.
ImageSize common_size(std::vector<Picture>& pictures) {
  std::map<std::pair<int, int>, int> counts;
  ImageSize common;
  int most = 0;
  for (const Picture& picture : pictures)
    if (picture.size) ++counts[{picture.size->width_px, picture.size->height_px}];
  for (const Picture& picture : pictures) {
    if (!picture.size) continue;
    const int count = counts[{picture.size->width_px, picture.size->height_px}];
    if (count > most) most = count, common = *picture.size;
  }
  FaultList faults;
  for (Picture& picture : pictures) {
    if (!picture.size || *picture.size == common) continue;
    const int off = std::max(std::abs(picture.size->width_px - common.width_px),
                             std::abs(picture.size->height_px - common.height_px));
    if (off > 2)
      faults.add(picture.file.string(), "a picture of " + size_text(*picture.size),
                 "one of " + size_text(common) + ", as most have: all pictures come from one camera");
    else
      picture.rejected =
          fmt::format("its size is {}, that of the others {}", size_text(*picture.size), size_text(common));
  }
  faults.throw_if_any();
  return common;
}

void find_board_in(Picture& picture, const Board& board, double max_pixels) {
  try {
    const cv::Mat image = read_color_image(picture.file, max_pixels);
    picture.size = ImageSize{image.cols, image.rows};
    picture.view = find_board(image, board);
    if (!picture.view) picture.rejected = "the board was not found in it, or is cut off by its border";
  } catch (...) {
    picture.error = std::current_exception();
  }
}

/// Looks for the board in all pictures, several at a time; what is found does not depend on how many.
void find_boards(std::vector<Picture>& pictures, const Board& board, const CommonOptions& common) {
  Progress progress("looking for the board", static_cast<long>(pictures.size()), common.quiet);
  std::mutex progress_mutex;
  long done = 0;
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    while (!interrupt_requested()) {
      const std::size_t i = next++;
      if (i >= pictures.size()) return;
      if (pictures[i].rejected.empty()) find_board_in(pictures[i], board, common.max_pixels);
      const std::lock_guard<std::mutex> lock(progress_mutex);
      progress.step(++done);
    }
  };
  const std::size_t wanted = common.threads > 0 ? static_cast<std::size_t>(common.threads)
                                                : std::max(1u, std::thread::hardware_concurrency());
  std::vector<std::thread> workers;
  for (std::size_t i = 1; i < std::min(wanted, pictures.size()); ++i) workers.emplace_back(work);
  work();
  for (std::thread& worker : workers) worker.join();
  throw_if_interrupted();
  FaultList faults;
  for (const Picture& picture : pictures) {
    try {
      if (picture.error) std::rethrow_exception(picture.error);
    } catch (const InputError& error) {
      for (const Fault& fault : error.faults()) faults.add(fault.place, fault.found, fault.allowed);
    }
  }
  faults.throw_if_any();
}

/// The corners as found, joined in their order, and their residuals 50 times enlarged.
cv::Mat draw_board(const Picture& picture, const BoardView& residuals_px, double max_pixels) {
  constexpr double enlarged = 50;
  constexpr int shift = 4, one_px = 1 << shift;
  cv::Mat image = read_color_image(picture.file, max_pixels);
  const auto at = [](const Eigen::Vector2d& p) {
    return cv::Point(static_cast<int>(std::lround(p.x() * one_px)),
                     static_cast<int>(std::lround(p.y() * one_px)));
  };
  for (std::size_t i = 0; i < picture.view->size(); ++i) {
    const Eigen::Vector2d& corner = (*picture.view)[i];
    if (i > 0)
      cv::line(image, at((*picture.view)[i - 1]), at(corner), cv::Scalar(200, 160, 0), 1, cv::LINE_AA, shift);
    cv::circle(image, at(corner), 4 * one_px, cv::Scalar(0, 220, 0), 1, cv::LINE_AA, shift);
    // A corner far off would need an arrow beyond any picture.
    const Eigen::Vector2d tip = corner + (enlarged * residuals_px[i]).cwiseMax(-2000).cwiseMin(2000);
    cv::line(image, at(corner), at(tip), cv::Scalar(0, 0, 255), 1, cv::LINE_AA, shift);
  }
  cv::circle(image, at(picture.view->front()), 8 * one_px, cv::Scalar(0, 220, 220), 2, cv::LINE_AA, shift);
  return image;
}

void write_overlays(OutputFolder& folder, const std::vector<const Picture*>& used,
                    const BoardCalibration& result, double max_pixels) {
  std::set<std::string> taken;
  for (std::size_t i = 0; i < used.size(); ++i) {
    throw_if_interrupted();
    std::string stem = used[i]->file.stem().string();
    if (!taken.insert(stem).second) taken.insert(stem += fmt::format("_{}", i + 1));
    write_image(folder.path() / (stem + ".png"), draw_board(*used[i], result.residuals_px[i], max_pixels));
  }
  folder.commit();
}

nlohmann::json results_json(const std::vector<Picture>& pictures, const std::vector<const Picture*>& used,
                            const BoardCalibration& result) {
  const CameraParameters& p = result.camera.parameters();
  nlohmann::json json{{"rms_px", result.rms_px},
                      {"held_out_rms_px", result.held_out_rms_px},
                      {"images", pictures.size()},
                      {"used", used.size()},
                      {"rejected", nlohmann::json::array()},
                      {"per_image", nlohmann::json::array()},
                      {"models_tried", nlohmann::json::array()},
                      {"warnings", result.warnings},
                      {"model", lens_model_name(p.model)},
                      {"image_width_px", p.size.width_px},
                      {"image_height_px", p.size.height_px},
                      {"fx_px", p.fx_px},
                      {"fy_px", p.fy_px},
                      {"cx_px", p.cx_px},
                      {"cy_px", p.cy_px},
                      {"ball_sigma_mm", result.ball_sigma_mm.value_or(std::nan(""))}};
  json["coefficients"] =
      std::vector<double>(p.coefficients.begin(), p.coefficients.begin() + coefficient_count(p.model));
  const auto names = parameter_names(p.model);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    json["sigma"][names[i]] = std::sqrt(result.covariance(at, at));
  }
  for (const Picture& picture : pictures)
    if (!picture.rejected.empty())
      json["rejected"].push_back({{"file", picture.file.string()}, {"reason", picture.rejected}});
  for (std::size_t i = 0; i < used.size(); ++i)
    json["per_image"].push_back({{"file", used[i]->file.string()}, {"rms_px", result.view_rms_px[i]}});
  for (const ModelTrial& trial : result.trials)
    json["models_tried"].push_back({{"model", lens_model_name(trial.model)},
                                    {"rms_px", trial.rms_px},
                                    {"held_out_rms_px", trial.held_out_rms_px},
                                    {"covers_picture", trial.covers_picture}});
  return json;
}

void print_summary(const std::vector<Picture>& pictures, const std::vector<const Picture*>& used,
                   const BoardCalibration& result, const CalibrateCameraOptions& options) {
  const CameraParameters& p = result.camera.parameters();
  fmt::print("board found in {} of {} pictures of {}\n", used.size(), pictures.size(), size_text(p.size));
  for (std::size_t i = 0; i < used.size(); ++i)
    fmt::print("  {}: RMS {:.3f} px\n", used[i]->file.string(), result.view_rms_px[i]);
  for (const Picture& picture : pictures)
    if (!picture.rejected.empty())
      fmt::print("  {}: not used, {}\n", picture.file.string(), picture.rejected);
  if (result.trials.size() > 1)
    for (const ModelTrial& trial : result.trials)
      fmt::print("model {}: RMS {:.3f} px, on boards held out {:.3f} px{}\n", lens_model_name(trial.model),
                 trial.rms_px, trial.held_out_rms_px,
                 trial.model == p.model ? " (chosen)"
                 : trial.covers_picture ? ""
                                        : " (folds over inside the picture)");
  fmt::print("lens model {}\n", lens_model_name(p.model));
  const auto names = parameter_names(p.model);
  const Eigen::VectorXd values = parameter_vector(p);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    fmt::print("  {} = {:.6g} +- {:.2g}\n", names[i], values(at), std::sqrt(result.covariance(at, at)));
  }
  fmt::print("RMS over all corners {:.4f} px, on boards held out {:.4f} px\n", result.rms_px,
             result.held_out_rms_px);
  if (result.ball_sigma_mm)
    fmt::print(
        "this calibration's own uncertainty moves a 70 mm ball at 1 m by {:.2f} mm (1 sigma) where it is "
        "worst in "
        "the picture\n",
        *result.ball_sigma_mm);
  fmt::print("written: {}\n", fs::absolute(options.output).string());
}

int calibrate_camera(const CalibrateCameraOptions& options) {
  const Board board = parse_board(options.board_text, options.square_m);
  const CameraFileFormat& format = camera_file_format(options.format, options.output);
  BoardCalibrationOptions calibration_options;
  calibration_options.models = models_of(options.model, format);
  const Overwrite overwrite = options.common.overwrite();
  OutputFile camera_file(options.output, overwrite);
  OutputFile covariance_file(options.output.string() + ".covariance.json", overwrite);
  std::optional<OutputFolder> overlay;
  if (!options.overlay.empty()) overlay.emplace(options.overlay, overwrite);

  std::vector<Picture> pictures = list_pictures(options.sources);
  common_size(pictures);
  find_boards(pictures, board, options.common);
  const ImageSize size = common_size(pictures);
  std::vector<const Picture*> used;
  std::vector<BoardView> views;
  for (Picture& picture : pictures) {
    if (!picture.view || !picture.rejected.empty()) continue;
    used.push_back(&picture);
    views.push_back(*picture.view);
  }
  if (used.empty())
    throw Refusal(fmt::format(
        "The board {} was not found in any picture ({} looked at). Are {} its inner corners (or circle "
        "centres)? "
        "Is the whole board in each picture, with a white margin around it, sharp and evenly lit?",
        options.board_text, pictures.size(), options.board_text.substr(options.board_text.find(':') + 1)));
  const BoardCalibration result = calibrate_from_boards(board, size, views, calibration_options);
  throw_if_interrupted();

  camera_file.write(camera_file_text(result.camera, format, options.output.stem().string()));
  covariance_file.write(camera_covariance_text(result.camera, result.covariance));
  if (overlay) write_overlays(*overlay, used, result, options.common.max_pixels);
  camera_file.commit();
  covariance_file.commit();
  write_json_results(options.common, results_json(pictures, used, result));
  for (const std::string& warning : result.warnings) spdlog::warn("{}", warning);
  if (!options.common.quiet) print_summary(pictures, used, result, options);
  return exit_done;
}

}  // namespace

void add_calibrate_camera_command(CLI::App& calibrate, Action& action) {
  CLI::App& command = *calibrate.add_subcommand("camera", "Calibrate a camera from pictures of a flat board");
  const auto options = std::make_shared<CalibrateCameraOptions>();
  command.add_option("source", options->sources, "Pictures of the board, or folders of pictures")
      ->required()
      ->type_name("SOURCE...");
  command
      .add_option("--board", options->board_text,
                  "chessboard:9x6 (inner corners), circles:6x6 or acircles:4x11 (centres)")
      ->required()
      ->type_name("BOARD");
  add_number_option(command, "--square", options->square_m, NumberRange::above(0, "m"),
                    "Side of a square, or distance of circles, in metres")
      ->required();
  command
      .add_option(
          "--model", options->model,
          "Lens model: auto (default: the simplest that predicts boards it has not seen as well as any, "
          "among those that the file format holds), pinhole, visp, brown, brown8, kannala_brandt")
      ->type_name("MODEL");
  command.add_option("-o,--output", options->output, "Camera file: .xml is ViSP's, .yaml ROS'")
      ->required()
      ->type_name("FILE");
  command.add_option("--format", options->format, "Format of the camera file, whatever its name: visp, ros, opencv, kalibr")
      ->type_name("FORMAT");
  command
      .add_option(
          "--overlay", options->overlay,
          "Draw the corners found and their residuals (50 times enlarged) into pictures in this folder")
      ->type_name("DIR");
  add_common_options(command, options->common);
  command.footer(
      "Beside FILE, FILE.covariance.json says how well the parameters are known.\n"
      "Example:\n"
      "  ballservo calibrate camera left01.jpg left02.jpg left03.jpg --board chessboard:9x6 --square 0.025 --model brown -o "
      "left.yaml");
  command.callback([&action, options] { action = [options] { return calibrate_camera(*options); }; });
}

}  // namespace ballservo
