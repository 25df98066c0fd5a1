// ballservo calibrate radius: a ball's diameter from pictures at known distances or beside a board.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include "app/commands/command.hpp"
#include "app/commands/work_options.hpp"
#include "app/io/image_source.hpp"
#include "app/io/interrupt.hpp"
#include "app/io/progress.hpp"
#include "calibration/ball/ball_radius.hpp"
#include "calibration/base/csv_table.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/boards/board_detector.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "calibration/camera/files/camera_file.hpp"
#include "calibration/color/color_file.hpp"
#include "perception/detector.hpp"

namespace ballservo {
namespace {

namespace fs = std::filesystem;

constexpr double largest_usual_radius_m = 0.5;

struct CalibrateRadiusOptions {
  CommonOptions common;
  std::vector<std::string> sources;
  std::string colors, camera, class_name;
  fs::path distances;
  std::string board_text;
  double square_m = std::nan(""), depth_m = 0;
};

struct Distance {
  double distance_m = 0, sigma_m = 0;
};

/// What became of one picture.
struct RadiusPicture {
  std::string source;
  std::optional<RadiusReading> reading;
  std::string class_name;  ///< the ball's
  std::string rejected;    ///< why it has none
  bool used = false;
};

/// The distances by picture name; InputError for a table that does not make sense.
std::map<std::string, Distance> read_distances(const fs::path& file) {
  const CsvTable table = read_csv(file, {"source", "distance_m"}, {"sigma_m"});
  std::map<std::string, Distance> distances;
  FaultList faults;
  const NumberRange range = NumberRange::within(1e-3, 1000, "m"), sigmas = NumberRange::within(0, 1000, "m");
  for (std::size_t k = 0; k < table.rows.size(); ++k) {
    const CsvRow row(table, k, faults);
    const std::string& source = row.text("source");
    if (source.empty()) row.fault("source", "nothing", "a picture's name without folders");
    if (row.text("distance_m").empty()) row.fault("distance_m", "nothing", range.to_text());
    const Distance distance{row.number("distance_m", range).value_or(0),
                            row.number("sigma_m", sigmas).value_or(0)};
    if (!distances.emplace(source, distance).second)
      row.fault("source", source + " a second time", "each picture once");
  }
  if (table.rows.empty()) faults.add(file.string(), "no rows", "a row for each picture");
  faults.throw_if_any();
  return distances;
}

/// What all pictures share.
struct Measurement {
  const CalibrateRadiusOptions& options;
  std::shared_ptr<const ColorTable> colors;
  Detector detector;
  RadiusReader reader;
  std::optional<Board> board;
  std::map<std::string, Distance> distances;
};

/// The ball of a picture, its radius taken for 1; into `picture` its class, or the reason where there is not
/// exactly one.
std::optional<UnitBall> unit_ball(Measurement& task, const cv::Mat& bgr, RadiusPicture& picture) {
  std::vector<const BallObservation*> balls;
  std::string names;
  std::set<ClassIndex> classes;
  const auto wanted = task.colors->find(task.options.class_name);
  const auto keep = [&](const std::vector<BallObservation>& found) {
    for (const BallObservation& ball : found) {
      if (!ball.position || (wanted && ball.color_class != *wanted)) continue;
      balls.push_back(&ball);
      names += (names.empty() ? "" : ", ") + task.colors->name_of(ball.color_class);
      classes.insert(ball.color_class);
    }
  };
  keep(task.detector.detect(bgr));
  if (balls.empty()) keep(task.detector.detect_thoroughly(bgr));
  if (balls.empty()) picture.rejected = "no ball in it";
  if (balls.size() > 1)
    picture.rejected = "several balls in it (" + names + "): " +
                       (classes.size() > 1 ? "--class NAME says which one is meant"
                                           : "leave the one to be measured in view");
  if (balls.size() != 1) return std::nullopt;
  picture.class_name = task.colors->name_of(balls.front()->color_class);
  return UnitBall{balls.front()->position->p_C, balls.front()->position->covariance_m2};
}

void read_picture(Measurement& task, const cv::Mat& bgr, RadiusPicture& picture) {
  const auto ball = unit_ball(task, bgr, picture);
  if (!ball) return;
  if (task.board) {
    const BoardFinding finding = find_board(bgr, *task.board);
    picture.rejected = finding.reason;
    if (!finding.view) return;
    picture.reading = task.reader.on_board(*ball, *finding.view, task.options.depth_m);
    if (!picture.reading) picture.rejected = "the ball cannot lie on the board's plane";
  } else {
    const Distance& distance = task.distances.at(picture.source);
    picture.reading = task.reader.at_distance(*ball, distance.distance_m, distance.sigma_m);
    if (!picture.reading) picture.rejected = "its outline leaves what the camera's model covers";
  }
}

Measurement set_up(const CalibrateRadiusOptions& options) {
  FaultList faults;
  std::shared_ptr<const ColorTable> colors;
  std::optional<Camera> camera;
  Eigen::MatrixXd covariance;
  std::optional<Board> board;
  std::map<std::string, Distance> distances;
  const bool by_board = !options.board_text.empty();
  if (by_board == !options.distances.empty())
    faults.add("calibrate radius",
               by_board ? "both --distances and --board" : "neither --distances nor --board", "one of them");
  faults.collect([&] { colors = std::make_shared<const ColorTable>(read_color_file(options.colors)); });
  faults.collect([&] {
    camera = read_camera(options.camera);
    admit_camera(options.camera, camera->size(), options.common, 1);
    covariance = read_camera_covariance(options.camera, *camera).value_or(Eigen::MatrixXd());
  });
  faults.collect([&] {
    if (by_board) board = parse_board(options.board_text, options.square_m);
  });
  faults.collect([&] {
    if (!options.distances.empty()) distances = read_distances(options.distances);
  });
  if (colors && !options.class_name.empty() && !colors->find(options.class_name))
    faults.add("--class", options.class_name, "a class of " + options.colors);
  faults.throw_if_any();
  DetectorOptions detector_options;
  detector_options.radii.assign(colors->classes.size(), BallRadius{1, 0});
  detector_options.seed = options.common.seed;
  Detector detector(std::make_shared<const RayTable>(*camera), colors, detector_options);
  return {
      options, colors, std::move(detector), RadiusReader(*camera, covariance), board, std::move(distances)};
}

/// Every picture must have its distance before the first is looked at.
void check_distances(const Measurement& task, const std::vector<fs::path>& files) {
  if (task.board) return;
  FaultList faults;
  for (const fs::path& file : files)
    if (!task.distances.count(file.filename().string()))
      faults.add(task.options.distances.string(), "no row for " + file.filename().string(),
                 "a row for each picture, named without folders");
  faults.throw_if_any();
}

std::vector<RadiusPicture> read_pictures(Measurement& task) {
  const std::vector<fs::path> files = image_files(task.options.sources);
  check_distances(task, files);
  std::vector<RadiusPicture> pictures;
  Progress progress("looking for the ball", static_cast<long>(files.size()), task.options.common.quiet);
  for (const fs::path& file : files) {
    throw_if_interrupted();
    RadiusPicture& picture = pictures.emplace_back();
    picture.source = file.filename().string();
    const cv::Mat bgr = read_color_image(file, task.options.common.max_pixels);
    check_camera_fits(task.detector.rays().camera(), {bgr.cols, bgr.rows}, task.options.camera);
    read_picture(task, bgr, picture);
    progress.step(static_cast<long>(pictures.size()));
  }
  return pictures;
}

void check_one_ball(const std::vector<RadiusPicture>& pictures) {
  const RadiusPicture* first = nullptr;
  for (const RadiusPicture& picture : pictures) {
    if (!picture.reading) continue;
    if (!first) first = &picture;
    if (picture.class_name != first->class_name)
      throw InputError("--class",
                       fmt::format("nothing, and {} shows the ball {}, {} the ball {}", first->source,
                                   first->class_name, picture.source, picture.class_name),
                       "the name of the one that is meant");
  }
}

RadiusEstimate estimate_from(std::vector<RadiusPicture>& pictures) {
  std::vector<RadiusReading> readings;
  std::vector<std::string> names;
  std::string reasons;
  for (const RadiusPicture& picture : pictures) {
    if (picture.reading) {
      readings.push_back(*picture.reading);
      names.push_back(picture.source);
    } else {
      reasons += fmt::format("\n  {}: {}", picture.source, picture.rejected);
    }
  }
  if (readings.empty()) throw Refusal("No picture tells the ball's diameter:" + reasons);
  const RadiusEstimate estimate = combine_radii(readings, names);
  std::size_t next = 0;
  for (RadiusPicture& picture : pictures) {
    if (!picture.reading) continue;
    picture.used = estimate.used[next++];
    if (!picture.used) picture.rejected = "it disagrees with the others";
  }
  return estimate;
}

nlohmann::json radius_json(const std::vector<RadiusPicture>& pictures, const RadiusEstimate& estimate,
                           long used) {
  nlohmann::json json{{"diameter_m", 2 * estimate.radius_m},
                      {"sigma_m", 2 * estimate.sigma_m},
                      {"chi2_per_dof", estimate.chi2_per_dof},
                      {"images", pictures.size()},
                      {"used", used},
                      {"pictures", nlohmann::json::array()}};
  for (const RadiusPicture& picture : pictures) {
    nlohmann::json row{{"source", picture.source}, {"used", picture.used}, {"reason", picture.rejected}};
    row["diameter_m"] = picture.reading ? nlohmann::json(2 * picture.reading->radius_m) : nullptr;
    row["sigma_m"] = picture.reading ? nlohmann::json(2 * picture.reading->sigma_m) : nullptr;
    json["pictures"].push_back(row);
  }
  return json;
}

void print_radius(const std::vector<RadiusPicture>& pictures, const RadiusEstimate& estimate, long used) {
  for (const RadiusPicture& picture : pictures) {
    if (picture.reading)
      print_result("  {}: {:.5f} +- {:.5f} m{}\n", picture.source, 2 * picture.reading->radius_m,
                   2 * picture.reading->sigma_m, picture.used ? "" : ", not used: " + picture.rejected);
    else
      print_result("  {}: not used, {}\n", picture.source, picture.rejected);
  }
  print_result("the ball's diameter, from {} of {} pictures: {:.5f} +- {:.5f} m\n", used, pictures.size(),
               2 * estimate.radius_m, 2 * estimate.sigma_m);
  if (used == 1) print_result("one picture alone: nothing contradicts it, and nothing confirms it\n");
  if (estimate.chi2_per_dof > 4)
    print_result(
        "the pictures scatter {:.1f} times more than their errors let expect; the sigma allows for it\n",
        std::sqrt(estimate.chi2_per_dof));
  print_result("for other commands: --diameter {:.5f}+-{:.5f}\n", 2 * estimate.radius_m,
               2 * estimate.sigma_m);
}

int calibrate_radius(const CalibrateRadiusOptions& options) {
  Measurement task = set_up(options);
  std::vector<RadiusPicture> pictures = read_pictures(task);
  check_one_ball(pictures);
  const RadiusEstimate estimate = estimate_from(pictures);
  if (estimate.radius_m > largest_usual_radius_m)
    spdlog::warn("a ball of {:.3g} m across? Distances and squares are in metres", 2 * estimate.radius_m);
  const long used = std::count_if(pictures.begin(), pictures.end(),
                                  [](const RadiusPicture& picture) { return picture.used; });
  write_json_results(options.common, radius_json(pictures, estimate, used));
  if (!options.common.quiet) print_radius(pictures, estimate, used);
  return exit_done;
}

}  // namespace

void add_calibrate_radius_command(CLI::App& calibrate, Action& action) {
  const auto [command, options] = add_command<CalibrateRadiusOptions>(
      calibrate, action, "radius",
      "Measure a ball's diameter in pictures at known distances, or on a board's plane", calibrate_radius);
  add_typed_option(command, "source", options.sources, "SOURCE...",
                   "Pictures of the ball, or folders of pictures; no videos, no camera:N")
      ->required();
  add_typed_option(command, "--colors", options.colors, "FILE",
                   "The colours file that `calibrate colors` wrote")
      ->required();
  add_typed_option(command, "--camera", options.camera, "FILE",
                   "The camera's file (FILE:NAME where it holds several)")
      ->required();
  add_typed_option(command, "--class", options.class_name, "NAME",
                   "The ball's class, where the pictures show several balls");
  add_typed_option(command, "--distances", options.distances, "FILE.csv",
                   "CSV source,distance_m[,sigma_m]: picture by picture (names without folders), how far the "
                   "ball's centre is from the camera's centre of projection, and how sure that is");
  add_typed_option(command, "--board", options.board_text, "BOARD",
                   "chessboard:9x6, circles:6x6 or acircles:4x11: the ball lies on this board");
  add_number_option(command, "--square", options.square_m, NumberRange::above(0, "m"),
                    "Side of the board's squares, or distance of its circles, in metres");
  add_number_option(
      command, "--thickness", options.depth_m, NumberRange::within(0, 1, "m"),
      "Of the board, in metres, where the ball lies beside it on the same table (default 0: on its face)");
  add_common_options(command, options.common);
  command.footer(
      R"(With --board: lay the board on a table, printed face up, and the ball on its white margin, or on the table
beside it (with --thickness where it is thicker than paper); all inner corners and the whole ball must be in
the picture. That the ball touches the plane of the board gives its size. Look down on it steeply, from
several sides. With --distances: the centre of projection lies inside the lens, about where its front looks
narrowest. The sigma holds the outlines', the distances' or corners' errors, the pictures' scatter, and the
camera's own where its .covariance.json is beside it; an error that all distances share it cannot know.
Exit: 0 measured, 1 no picture tells, or they contradict each other (all figures are shown), 2 bad input.
Examples:
  ballservo calibrate radius table/ --colors my.colors --camera camera.yaml --board chessboard:9x6 --square 0.025
  ballservo calibrate radius at_1m.png at_2m.png --colors my.colors --camera camera.yaml --distances tape.csv)");
}

}  // namespace ballservo
