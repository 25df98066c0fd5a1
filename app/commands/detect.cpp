// ballservo detect: the balls in pictures.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <tuple>

#include "app/commands/ball_search.hpp"
#include "app/report/overlay.hpp"
#include "app/report/picture.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/teaching/class_table.hpp"
#include "perception/tracking/light_search.hpp"

namespace ballservo {
namespace {

struct DetectOptions : BallSearchOptions {
  std::filesystem::path overlay;
};

// A name for what belongs to one frame: "img.png" -> "img", frame 12 of "a.mp4" -> "a_000012".
std::string frame_name(const Frame& frame, bool of_video) {
  const std::string stem = std::filesystem::path(frame.source).stem().string();
  return of_video ? fmt::format("{}_{:06}", stem, frame.index) : stem;
}

void draw_balls(cv::Mat& picture, const std::vector<BallObservation>& balls, const Detector& detector) {
  for (const BallObservation& ball : balls) {
    const std::string& name = detector.colors().name_of(ball.color_class);
    const std::string label =
        ball.position ? fmt::format("{} {:.3f} m", name, ball.position->p_C.norm()) : name;
    draw_ball(picture, detector.rays().camera(), ball, label, {255, 0, 255});
  }
}

nlohmann::json detection_json(const BallObservation& ball, const std::string& class_name) {
  nlohmann::json json = {{"class", class_name},
                         {"quality", ball.quality},
                         {"cx_px", ball.outline.center_px.x()},
                         {"cy_px", ball.outline.center_px.y()},
                         {"r_px", ball.outline.radius_px}};
  if (ball.position) {
    const Eigen::Vector3d& p = ball.position->p_C;
    json.update({{"x_m", p.x()}, {"y_m", p.y()}, {"z_m", p.z()}});
  }
  return json;
}

// Those of which a second look is so sure.
std::vector<BallObservation> sure_balls(Detector& detector, const cv::Mat& bgr,
                                        std::vector<BallObservation> balls, double least_log_odds) {
  const auto is_unsure = [&](const BallObservation& ball) {
    return detector.log_odds(bgr, ball) < least_log_odds;
  };
  balls.erase(std::remove_if(balls.begin(), balls.end(), is_unsure), balls.end());
  return balls;
}

// A detector, and what it looks for where that sees no ball: one before a ground of its own colours, and in
// another light than the taught one.
struct AnyLight {
  Detector detector;
  std::optional<LightSearch> other_lights;
  std::vector<BallObservation> balls;

  /// Fills `balls`. The light in which they were found, if it is another than the taught one.
  std::optional<AssumedLight> detect(const cv::Mat& bgr, DetectionStages* stages) {
    detector.set_light(LightCells::as_taught());
    balls = detector.detect(bgr, {}, stages);
    if (balls.empty()) balls = detector.detect_thoroughly(bgr, stages);
    if (balls.empty()) detect_before_own_ground(bgr, stages);
    if (!balls.empty()) return detect_in_their_light(bgr, stages);
    if (!other_lights) other_lights.emplace(detector);
    const std::optional<LightSearch::Found> found = other_lights->find(bgr);
    if (!found) return std::nullopt;
    detector.set_light(cells_in(found->light));
    balls = sure_balls(detector, bgr, detector.detect(bgr, {}, stages), found->least_log_odds);
    return balls.empty() ? std::nullopt : std::optional(found->light);
  }

  /// Balls may agree about another light. Where that shows them all and more, it is the picture's.
  std::optional<AssumedLight> detect_in_their_light(const cv::Mat& bgr, DetectionStages* stages) {
    const AssumedLight light{light_of_balls(bgr, balls, detector.colors())};
    if (light.is_taught()) return std::nullopt;
    DetectionStages seen;
    detector.set_light(cells_in(light));
    std::vector<BallObservation> found = sure_balls(
        detector, bgr, detector.detect(bgr, {}, stages ? &seen : nullptr), LightSearch::least_log_odds);
    const bool shows_all = std::all_of(balls.begin(), balls.end(), [&](const BallObservation& ball) {
      return std::any_of(found.begin(), found.end(),
                         [&](const auto& other) { return same_ball(ball, other); });
    });
    if (!shows_all || found.size() <= balls.size()) {
      detector.set_light(LightCells::as_taught());
      return std::nullopt;
    }
    balls = std::move(found);
    if (stages) *stages = std::move(seen);
    return light;
  }

  void detect_before_own_ground(const cv::Mat& bgr, DetectionStages* stages) {
    constexpr double least_log_odds = 4;
    auto colors = before_own_ground(detector.colors(), bgr);
    if (!colors) return;
    Detector before = detector.with_colors(std::make_shared<const ColorTable>(*std::move(colors)));
    DetectionStages seen;
    DetectionStages* const shown = stages ? &seen : nullptr;
    balls = before.detect(bgr, {}, shown);
    if (balls.empty()) balls = before.detect_thoroughly(bgr, shown);
    balls = sure_balls(before, bgr, std::move(balls), least_log_odds);
    if (stages && !balls.empty()) *stages = std::move(seen);
  }
};

int run_detect(const DetectOptions& options) {
  BallSearch search(options, "detect");
  std::optional<OutputFolder> overlay_folder;
  if (!options.overlay.empty())
    overlay_folder.emplace(options.overlay, options.common.overwrite(options.overlay));
  nlohmann::json pictures = nlohmann::json::array();
  std::map<std::tuple<int, int, bool, bool>, AnyLight> detectors;  // by picture size and kind
  std::set<std::string> used_names;
  long balls_found = 0;
  search.each_sequence([&](FrameSequence& sequence) {
    while (const auto frame = search.next(sequence)) {
      const bool of_video = sequence.length() != 1 && frame->source == sequence.name();
      const ImageSize size{frame->bgr.cols, frame->bgr.rows};
      const PictureKind kind{!of_video, frame->coarse_chroma};
      const std::tuple key(size.width_px, size.height_px, kind.still, kind.coarse_chroma);
      auto found = detectors.find(key);
      if (found == detectors.end())
        found =
            detectors.emplace(key, AnyLight{search.factory().make(size, frame->source, kind), {}, {}}).first;
      AnyLight& looks = found->second;
      Detector& detector = looks.detector;
      if (!of_video || frame->index == 0) detector.forget_response();
      DetectionStages stages;
      const std::optional<AssumedLight> light =
          looks.detect(frame->bgr, search.shows_stages() ? &stages : nullptr);
      const std::vector<BallObservation>& balls = looks.balls;
      if (light) search.assumed_light(*light, fmt::format("{}, frame {}", frame->source, frame->index));
      search.left_out(detector.left_out(), *frame);
      nlohmann::json listed = nlohmann::json::array();
      for (const BallObservation& ball : balls) {
        search.add_row(*frame, {}, ball.color_class, "detected", ball);
        listed.push_back(detection_json(ball, detector.colors().name_of(ball.color_class)));
      }
      pictures.push_back({{"source", frame->source}, {"frame", frame->index}, {"balls", listed}});
      if (light) pictures.back()["light"] = light_json(*light);
      const std::string name = unused_name(used_names, frame_name(*frame, of_video));
      if (overlay_folder) {
        cv::Mat picture = frame->bgr.clone();
        draw_balls(picture, balls, detector);
        overlay_folder->write(name + ".png", picture_bytes(picture, ".png"));
      }
      if (search.shows_stages()) search.write_stages(name, *frame, stages, detector);
      balls_found += static_cast<long>(balls.size());
    }
  });
  search.end();
  options.common.files->commit(overlay_folder);
  if (balls_found == 0 && !search.interrupted())
    throw search.no_ball(fmt::format(
        "to see why, {}: if the ball's colour is lost in 'classified' already, learn the colours from "
        "a picture of this light; else 'estimate by votes' says of each circle why it is no ball",
        options.stages.empty() ? "add --stages DIR" : "look at " + options.stages.string()));
  return search.finish({{"pictures", pictures}},
                       counted(balls_found, "ball") + " in " + counted(search.pictures(), "picture"));
}

}  // namespace

void add_detect_command(CLI::App& program, Action& action) {
  const auto [command, options] =
      add_command<DetectOptions>(program, action, "detect", "Find the balls in pictures", run_detect);
  command.footer(R"(Example:
  ballservo detect left.png right.png --colors my.colors --camera camera.yaml --diameter 0.07 -o detections.csv --overlay found/

Each still is judged by itself, whatever else is asked with it; the frames of a video are one camera's.
Where no ball is seen and the ground has its colours, too, those that the ground has most of are left out.
Where the light in which the colours were taught shows no ball, one is sought in the lights that lamps and
cameras make; so are more, in a light that several balls agree about. Which was assumed is said on stderr
and, as `light`, in --json.
Without -o the rows go to stdout. Without --camera or --diameter the columns in metres stay empty.
Exit: 0 found at least one ball, 1 found none, 2 bad input.)");
  add_ball_search_options(command, options, "Image files, a folder of images, a video file, or camera:N",
                          "Rows of all balls (CSV)", "One picture of all stages for each picture");
  add_output_option(command, "--overlay", options.overlay, "DIR",
                    "The pictures with what was found drawn into them");
  add_common_options(command, options.common);
}

}  // namespace ballservo
