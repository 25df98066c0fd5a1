// ballservo track: balls followed through videos and folders of pictures.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "app/commands/ball_search.hpp"
#include "app/io/display_window.hpp"
#include "app/io/track_stream.hpp"
#include "app/io/video_writer.hpp"
#include "app/report/overlay.hpp"
#include "calibration/base/fault.hpp"
#include "perception/tracking/tracker.hpp"

namespace ballservo {
namespace {

struct TrackOptions : BallSearchOptions {
  bool fixed_colors = false, display = false;
  std::filesystem::path video;
};

constexpr int pictures_between_stages = 30;

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

std::string line_of(const Frame& frame, std::vector<Track> tracks, const DetectorFactory& factory) {
  for (Track& track : tracks) track.ball = factory.with_total_covariance(track.ball);
  return stream_line(frame, tracks, factory.colors(), unix_time_s());
}

void check_same_size(const ImageSize& size, const ImageSize& first, const Frame& frame) {
  if (size == first) return;
  throw InputError(frame.source, fmt::format("{} x {} pixels", size.width_px, size.height_px),
                   fmt::format("{} x {}, as the pictures before it", first.width_px, first.height_px));
}

int run_track(const TrackOptions& options) {
  std::optional<DisplayWindow> window;
  if (options.display) window.emplace("ballservo track");
  BallSearch search(options, "track");
  std::optional<VideoFile> video;
  if (!options.video.empty()) {
    if (search.sequences() > 1)
      throw InputError("--video", fmt::format("{} sequences", search.sequences()),
                       "one sequence for one video");
    video.emplace(options.video, options.common.overwrite(options.video), options.fps);
  }
  std::optional<TrackStream> stream;
  if (options.stream) stream.emplace(*options.stream);
  TrackerOptions tracker_options;
  tracker_options.fixed_colors = options.fixed_colors;
  long pictures_with_ball = 0, rows_seen = 0, rows_coasting = 0, track_count = 0;
  nlohmann::json lights = nlohmann::json::array();
  search.each_sequence([&](FrameSequence& sequence) {
    std::optional<Tracker> tracker;
    int last_id = 0;
    const std::string stem = std::filesystem::path(sequence.name()).stem().string();
    for (long index = 0; const auto frame = search.next(sequence); ++index) {
      const ImageSize size{frame->bgr.cols, frame->bgr.rows};
      if (!tracker)
        tracker.emplace(search.factory().make(size, frame->source, {false, frame->coarse_chroma}),
                        tracker_options);
      check_same_size(size, tracker->detector().rays().size(), *frame);
      const bool staged = search.shows_stages() && index % pictures_between_stages == 0;
      DetectionStages stages;
      const std::vector<Track>& tracks =
          tracker->update(frame->bgr, frame->time_s, staged ? &stages : nullptr);
      if (stream && !stream->send(line_of(*frame, tracks, search.factory()))) search.stop();
      search.left_out(tracker->left_out(), *frame);
      bool with_ball = false;
      for (const Track& track : tracks) {
        search.add_row(*frame, track.id, track.color_class, track_state_name(track.state), track.ball);
        const bool seen = track.state != TrackState::coasting;
        with_ball |= seen;
        (seen ? rows_seen : rows_coasting) += 1;
        last_id = std::max(last_id, track.id);
      }
      pictures_with_ball += with_ball ? 1 : 0;
      if (video || window) {
        cv::Mat picture = frame->bgr.clone();
        draw_tracks(picture, tracks, tracker->detector());
        if (video) video->write(picture);
        const auto due_s = sequence.files().empty() ? std::nullopt : std::optional(frame->time_s);
        if (window && !window->show(picture, due_s)) search.stop();
      }
      if (staged)
        search.write_stages(fmt::format("{}_{:06}", stem, index), *frame, stages, tracker->detector());
    }
    track_count += last_id;
    if (const auto light = tracker ? tracker->assumed_light() : std::nullopt) {
      search.assumed_light(*light, sequence.name());
      lights.push_back(light_json(*light));
      lights.back()["source"] = sequence.name();
    }
  });
  if (stream && !stream->lost().empty()) spdlog::warn("{}: {}", *options.stream, stream->lost());
  search.end();
  options.common.files->commit(video);
  const long pictures = search.pictures();
  if (rows_seen == 0 && !search.interrupted()) throw search.no_ball("--stages DIR shows where it gets lost");
  return search.finish({{"pictures", pictures},
                        {"pictures_with_ball", pictures_with_ball},
                        {"tracks", track_count},
                        {"rows_seen", rows_seen},
                        {"rows_coasting", rows_coasting},
                        {"lights", lights}},
                       fmt::format("{} of {} pictures with a ball, {}", pictures_with_ball, pictures,
                                   counted(track_count, "track")));
}

}  // namespace

void add_track_command(CLI::App& program, Action& action) {
  const auto [command, options] = add_command<TrackOptions>(
      program, action, "track", "Follow balls through videos, folders of pictures or a camera", run_track);
  command.footer(R"(Example:
  ballservo track throw.mp4 --colors my.colors --camera camera.yaml --diameter 0.07 -o tracks.csv --video throw_tracked.mp4

Each video, folder or camera is a sequence of its own; single image files together form one, in the order given.
The colours follow the light, slow or sudden, by what changes on balls that are being tracked. While no ball is
known, one is sought in the lights that lamps and cameras make, too; which was assumed is said on stderr and, as
`lights`, in --json. --fixed-colors looks with the colours as they were taught, whatever the light does.
--stream sends a line of JSON for every picture as soon as it is followed (data/stream.schema.json):

  ballservo track camera:0 --colors my.colors --stream - | python3 app/examples/read_stream.py
  ballservo track camera:0 --colors my.colors -o tracks.csv --stream udp:127.0.0.1:9000

With --stream - stdout is the stream's: rows are written with -o FILE only, and a reader that goes ends the
work as Ctrl-C does. Datagrams wait for nobody and need no receiver.

Row states: tentative and confirmed claim a ball in this picture, coasting rows are predictions.
Exit: 0 saw at least one ball, 1 saw none, 2 bad input.)");
  add_ball_search_options(
      command, options, "Video files, folders of images, image files, or camera:N",
      "Rows of all tracks (CSV)",
      fmt::format("A picture of all stages for every {}th picture", pictures_between_stages));
  command.add_flag("--fixed-colors", options.fixed_colors, "Do not let the colours follow the light");
  add_number_option(command, "--fps", options.fps, fps_range(),
                    "Times pictures that carry no time of their own (default 30 Hz)");
  add_output_option(command, "--video", options.video, "FILE",
                    "The pictures with the tracks drawn: .mp4 (H.264) or .mkv (exact)");
  add_typed_option(
      command, "--stream", options.stream, "-|udp:HOST:PORT",
      "Sends the tracks as they are followed: a line of JSON a picture to stdout or a UDP socket");
  command.add_flag(
      "--display", options.display,
      "Shows the pictures with the tracks drawn, in their own size and at their own pace; q, Esc or closing "
      "the window ends");
  add_common_options(command, options.common);
}

}  // namespace ballservo
