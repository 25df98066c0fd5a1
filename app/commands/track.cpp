// ballservo track: balls followed through videos and folders of pictures.
#include <fmt/format.h>

#include <map>
#include <memory>

#include "app/commands/ball_options.hpp"
#include "app/commands/command.hpp"
#include "app/commands/left_out_warning.hpp"
#include "app/io/ball_rows.hpp"
#include "app/io/display_window.hpp"
#include "app/io/image_source.hpp"
#include "app/io/interrupt.hpp"
#include "app/io/progress.hpp"
#include "app/io/video_writer.hpp"
#include "app/report/overlay.hpp"
#include "app/report/picture.hpp"
#include "app/report/stage_pictures.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "perception/tracking/tracker.hpp"

namespace ballservo {
namespace {

struct TrackOptions {
  CommonOptions common;
  BallOptions balls;
  std::vector<std::string> sources;
  double fps = 30;
  bool fixed_colors = false, display = false;
  std::filesystem::path output, video, stages;
};

constexpr int pictures_between_stages = 30;

struct TrackTotals {
  long pictures = 0, with_ball = 0, seen = 0, coasting = 0;
  int tracks = 0;
};

cv::Scalar state_color(TrackState state) {
  switch (state) {
    case TrackState::tentative:
      return {0, 220, 255};
    case TrackState::confirmed:
      return {255, 0, 255};
    case TrackState::coasting:
    case TrackState::none:
      break;
  }
  return {200, 200, 200};
}

void draw_tracks(cv::Mat& picture, const std::vector<Track>& tracks, const Detector& detector) {
  for (const Track& track : tracks) {
    const std::string& name = detector.colors().name_of(track.color_class);
    std::string label = fmt::format("{} {} {}", track.id, name, track_state_name(track.state));
    if (track.ball.position) label += fmt::format(" {:.3f} m", track.ball.position->p_C.norm());
    draw_ball(picture, detector.rays().camera(), track.ball, label, state_color(track.state));
  }
}

void check_same_size(const ImageSize& size, const ImageSize& first, const Frame& frame) {
  if (size == first) return;
  throw InputError(frame.source, fmt::format("{} x {} pixels", size.width_px, size.height_px),
                   fmt::format("{} x {}, as the pictures before it", first.width_px, first.height_px));
}

int run_track(const TrackOptions& options) {
  if (!(options.fps > 0 && options.fps <= 10000)) {
    throw InputError("--fps", number_text(options.fps), "a number above 0 and up to 10000 (Hz)");
  }
  check_not_an_input(options.output, options.balls, options.sources);
  check_not_an_input(options.video, options.balls, options.sources);
  check_not_a_source_folder(options.stages, options.sources);
  std::optional<DisplayWindow> window;
  if (options.display) window.emplace("ballservo track");
  const DetectorFactory factory(options.balls, options.common.seed, options.common.threads);
  warn_of_repeated_names(options.sources);
  auto sequences = open_sources(options.sources, options.fps, options.common.max_pixels);
  std::optional<OutputFile> csv_file;
  std::optional<VideoFile> video;
  std::optional<OutputFolder> stages_folder;
  if (!options.output.empty()) csv_file.emplace(options.output, options.common.overwrite());
  if (!options.video.empty()) {
    if (sequences.size() > 1)
      throw InputError("--video", fmt::format("{} sequences", sequences.size()),
                       "one sequence for one video");
    video.emplace(options.video, options.common.overwrite(), options.fps);
  }
  if (!options.stages.empty()) stages_folder.emplace(options.stages, options.common.overwrite());

  TrackerOptions tracker_options;
  tracker_options.fixed_colors = options.fixed_colors;
  std::string csv = ball_rows_header();
  TrackTotals totals;
  long total = 0;
  for (const auto& sequence : sequences) total += sequence->length();
  Progress progress("track", total, options.common.quiet);
  LeftOutWarning left_out;
  bool interrupted = false, window_closed = false;
  for (const auto& sequence : sequences) {
    std::optional<Tracker> tracker;
    int last_id = 0;
    long index = 0;
    while (const auto frame = sequence->next()) {
      interrupted = window_closed || interrupt_requested();
      if (interrupted) break;
      const ImageSize size{frame->bgr.cols, frame->bgr.rows};
      if (!tracker) tracker.emplace(factory.make(size, frame->source), tracker_options);
      check_same_size(size, tracker->detector().rays().size(), *frame);
      const bool staged = stages_folder && index % pictures_between_stages == 0;
      DetectionStages stages;
      const std::vector<Track>& tracks =
          tracker->update(frame->bgr, frame->time_s, staged ? &stages : nullptr);
      left_out.add(tracker->left_out(), frame->source, frame->index);
      bool with_ball = false;
      for (const Track& track : tracks) {
        const std::string& name = factory.colors().name_of(track.color_class);
        csv += ball_row(
            {frame->source, frame->index, frame->time_s, track.id, name, track_state_name(track.state)},
            factory.with_total_covariance(track.ball));
        const bool seen = track.state != TrackState::coasting;
        with_ball |= seen;
        (seen ? totals.seen : totals.coasting) += 1;
        last_id = std::max(last_id, track.id);
      }
      totals.with_ball += with_ball ? 1 : 0;
      if (video || window) {
        cv::Mat picture = frame->bgr.clone();
        draw_tracks(picture, tracks, tracker->detector());
        if (video) video->write(picture);
        window_closed = window && !window->show(picture);
      }
      if (staged) {
        write_image(stages_folder->path() /
                        fmt::format("{}_{:06}_stages.png",
                                    std::filesystem::path(sequence->name()).stem().string(), index),
                    labelled_grid(stage_pictures(frame->bgr, stages, tracker->detector()), 3));
      }
      ++index;
      progress.step(++totals.pictures);
    }
    totals.tracks += last_id;
    if (interrupted) break;
    warn_of_missing_pictures(*sequence, index);
  }
  left_out.say();
  if (stages_folder) stages_folder->commit();
  if (video) video->commit();
  if (totals.seen == 0 && !interrupted) {
    throw Refusal(
        fmt::format("no ball in any of {} pictures; --stages DIR shows where it gets lost", totals.pictures));
  }
  if (csv_file) {
    csv_file->write(csv);
    csv_file->commit();
  } else {
    fmt::print("{}", csv);
  }
  write_json_results(options.common, {{"pictures", totals.pictures},
                                      {"pictures_with_ball", totals.with_ball},
                                      {"tracks", totals.tracks},
                                      {"rows_seen", totals.seen},
                                      {"rows_coasting", totals.coasting},
                                      {"interrupted", interrupted}});
  if (csv_file && !options.common.quiet) {
    fmt::print("{}{} of {} pictures with a ball, {} track{}: {}\n", interrupted ? "interrupted; " : "",
               totals.with_ball, totals.pictures, totals.tracks, totals.tracks == 1 ? "" : "s",
               options.output.string());
  }
  return interrupted ? exit_interrupted : exit_done;
}

}  // namespace

void add_track_command(CLI::App& program, Action& action) {
  auto options = std::make_shared<TrackOptions>();
  CLI::App* command =
      program.add_subcommand("track", "Follow balls through videos, folders of pictures or a camera");
  command->footer(
      "Example:\n"
      "  ballservo track throw.mp4 --colors my.colors --camera camera.yaml --diameter 0.07 -o tracks.csv "
      "--video throw_tracked.mp4\n"
      "\n"
      "Each video, folder or camera is a sequence of its own; single image files together form one, in the "
      "order given.\n"
      "The colours follow the light, slow or sudden, by what changes on balls that are being tracked; "
      "--fixed-colors\nlooks with the colours as they were taught, whatever the light does.\n"
      "Row states: tentative and confirmed claim a ball in this picture, coasting rows are predictions.\n"
      "Exit: 0 saw at least one ball, 1 saw none, 2 bad input.");
  command->add_option("SOURCE", options->sources, "Video files, folders of images, image files, or camera:N")
      ->required();
  add_ball_options(*command, options->balls);
  command->add_flag("--fixed-colors", options->fixed_colors, "Do not let the colours follow the light");
  command->add_option("--fps", options->fps, "Times pictures that carry no time of their own (Hz)")
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "Rows of all tracks (CSV)")->type_name("FILE.csv");
  command
      ->add_option("--video", options->video,
                   "The pictures with the tracks drawn: .mp4 (H.264) or .mkv (exact)")
      ->type_name("FILE");
  command
      ->add_option("--stages", options->stages,
                   fmt::format("A picture of all stages for every {}th picture", pictures_between_stages))
      ->type_name("DIR");
  command->add_flag(
      "--display", options->display,
      "Shows the pictures with the tracks drawn as they are followed; q, Esc or closing the window ends");
  add_common_options(*command, options->common);
  command->callback([options, &action] { action = [options] { return run_track(*options); }; });
}

}  // namespace ballservo
