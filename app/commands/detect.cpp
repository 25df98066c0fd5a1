// ballservo detect: the balls in pictures.
#include <fmt/format.h>

#include <map>
#include <memory>
#include <set>

#include "app/commands/ball_options.hpp"
#include "app/commands/command.hpp"
#include "app/commands/left_out_warning.hpp"
#include "app/io/ball_rows.hpp"
#include "app/io/image_source.hpp"
#include "app/io/interrupt.hpp"
#include "app/io/progress.hpp"
#include "app/report/overlay.hpp"
#include "app/report/picture.hpp"
#include "app/report/stage_pictures.hpp"
#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

struct DetectOptions {
  CommonOptions common;
  BallOptions balls;
  std::vector<std::string> sources;
  std::filesystem::path output, overlay, stages;
};

// A name for what belongs to one frame: "img.png" -> "img", frame 12 of "a.mp4" -> "a_000012".
std::string frame_name(const Frame& frame, bool of_video) {
  const std::string stem = std::filesystem::path(frame.source).stem().string();
  return of_video ? fmt::format("{}_{:06}", stem, frame.index) : stem;
}

int run_detect(const DetectOptions& options) {
  check_not_an_input(options.output, options.balls, options.sources);
  check_not_a_source_folder(options.overlay, options.sources);
  check_not_a_source_folder(options.stages, options.sources);
  const DetectorFactory factory(options.balls, options.common.seed, options.common.threads);
  warn_of_repeated_names(options.sources);
  auto sequences = open_sources(options.sources, 30, options.common.max_pixels);
  std::optional<OutputFile> csv_file;
  std::optional<OutputFolder> overlay_folder, stages_folder;
  if (!options.output.empty()) csv_file.emplace(options.output, options.common.overwrite());
  if (!options.overlay.empty()) overlay_folder.emplace(options.overlay, options.common.overwrite());
  if (!options.stages.empty()) stages_folder.emplace(options.stages, options.common.overwrite());

  std::string csv = ball_rows_header();
  nlohmann::json results = {{"pictures", nlohmann::json::array()}};
  std::map<std::pair<int, int>, Detector> detectors;  // by picture size
  std::set<std::string> used_names;
  long pictures = 0, balls_found = 0, total = 0;
  for (const auto& sequence : sequences) total += sequence->length();
  Progress progress("detect", total, options.common.quiet);
  LeftOutWarning left_out;
  bool interrupted = false;
  for (const auto& sequence : sequences) {
    for (auto& [size, detector] : detectors) detector.forget_response();
    const long before = pictures;
    while (const auto frame = sequence->next()) {
      interrupted = interrupt_requested();
      if (interrupted) break;
      const ImageSize size{frame->bgr.cols, frame->bgr.rows};
      auto found = detectors.find({size.width_px, size.height_px});
      if (found == detectors.end()) {
        found = detectors
                    .emplace(std::make_pair(size.width_px, size.height_px), factory.make(size, frame->source))
                    .first;
      }
      Detector& detector = found->second;
      DetectionStages stages;
      const std::vector<BallObservation>& balls =
          detector.detect(frame->bgr, {}, stages_folder ? &stages : nullptr);
      left_out.add(detector.left_out(), frame->source, frame->index);
      nlohmann::json listed = nlohmann::json::array();
      for (const BallObservation& ball : balls) {
        const std::string& name = factory.colors().name_of(ball.color_class);
        csv += ball_row({frame->source, frame->index, frame->time_s, {}, name, "detected"},
                        factory.with_total_covariance(ball));
        listed.push_back({{"class", name},
                          {"quality", ball.quality},
                          {"cx_px", ball.outline.center_px.x()},
                          {"cy_px", ball.outline.center_px.y()},
                          {"r_px", ball.outline.radius_px}});
        if (ball.position) {
          const Eigen::Vector3d& p = ball.position->p_C;
          listed.back().update({{"x_m", p.x()}, {"y_m", p.y()}, {"z_m", p.z()}});
        }
      }
      results["pictures"].push_back({{"source", frame->source}, {"frame", frame->index}, {"balls", listed}});
      const std::string name = unused_name(
          used_names, frame_name(*frame, sequence->length() != 1 && frame->source == sequence->name()));
      if (overlay_folder) {
        cv::Mat picture = frame->bgr.clone();
        for (const BallObservation& ball : balls) {
          const std::string& class_name = factory.colors().name_of(ball.color_class);
          const std::string label =
              ball.position ? fmt::format("{} {:.3f} m", class_name, ball.position->p_C.norm()) : class_name;
          draw_ball(picture, detector.rays().camera(), ball, label, {255, 0, 255});
        }
        write_image(overlay_folder->path() / (name + ".png"), picture);
      }
      if (stages_folder) {
        write_image(stages_folder->path() / (name + "_stages.png"),
                    labelled_grid(stage_pictures(frame->bgr, stages, detector), 3));
      }
      balls_found += static_cast<long>(balls.size());
      progress.step(++pictures);
    }
    if (interrupted) break;
    warn_of_missing_pictures(*sequence, pictures - before);
  }
  left_out.say();
  if (overlay_folder) overlay_folder->commit();
  if (stages_folder) stages_folder->commit();
  if (balls_found == 0 && !interrupted) {
    throw Refusal(fmt::format(
        "no ball in {} picture{}; to see why, add --stages DIR and look where the colour gets lost: if "
        "already in 'classified', "
        "learn the colours from a picture of this light; if in 'refined', the outline is hidden or not round",
        pictures, pictures == 1 ? "" : "s"));
  }
  results["interrupted"] = interrupted;
  if (csv_file) {
    csv_file->write(csv);
    csv_file->commit();
  } else {
    fmt::print("{}", csv);
  }
  write_json_results(options.common, results);
  if (csv_file && !options.common.quiet) {
    fmt::print("{}{} ball{} in {} picture{}: {}\n", interrupted ? "interrupted; " : "", balls_found,
               balls_found == 1 ? "" : "s", pictures, pictures == 1 ? "" : "s", options.output.string());
  }
  return interrupted ? exit_interrupted : exit_done;
}

}  // namespace

void add_detect_command(CLI::App& program, Action& action) {
  auto options = std::make_shared<DetectOptions>();
  CLI::App* command = program.add_subcommand("detect", "Find the balls in pictures");
  command->footer(
      "Example:\n"
      "  ballservo detect left.png right.png --colors my.colors --camera camera.yaml --diameter 0.07 -o "
      "detections.csv --overlay found/\n"
      "\n"
      "Without -o the rows go to stdout. Without --camera or --diameter the columns in metres stay empty.\n"
      "Exit: 0 found at least one ball, 1 found none, 2 bad input.");
  command
      ->add_option("SOURCE", options->sources, "Image files, a folder of images, a video file, or camera:N")
      ->required();
  add_ball_options(*command, options->balls);
  command->add_option("-o,--output", options->output, "Rows of all balls (CSV)")->type_name("FILE.csv");
  command->add_option("--overlay", options->overlay, "The pictures with what was found drawn into them")
      ->type_name("DIR");
  command->add_option("--stages", options->stages, "One picture of all stages for each picture")
      ->type_name("DIR");
  add_common_options(*command, options->common);
  command->callback([options, &action] { action = [options] { return run_detect(*options); }; });
}

}  // namespace ballservo
