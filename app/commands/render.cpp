// ballservo render: pictures of a scenario with exact truth.
#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <set>

#include "app/commands/command.hpp"
#include "app/commands/work_options.hpp"
#include "app/experiment/simulated_camera.hpp"
#include "app/io/interrupt.hpp"
#include "app/io/progress.hpp"
#include "app/io/recording.hpp"
#include "app/report/picture.hpp"
#include "app/scenario/scenario.hpp"
#include "calibration/base/csv_table.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/camera/files/camera_file.hpp"
#include "servo/simulation/rendering/truth.hpp"

namespace ballservo {
namespace {

struct RenderOptions {
  CommonOptions common;
  std::string scenario;
  std::filesystem::path output;
  std::vector<std::string> sets;
  int frames = 30;
};

std::string truth_header() { return fmt::format("source,{}\n", fmt::join(truth_columns(), ",")); }

std::string truth_row(const std::string& source, const BallTruth& truth, double time_s) {
  const auto outline =
      truth.outline.value_or(OutlineEllipse{Eigen::Vector2d::Constant(std::nan("")), std::nan("")});
  return csv_row(source, 0, truth.name, truth.class_name, outline.center_px.x(), outline.center_px.y(),
                 outline.radius_px, truth.p_CB.x(), truth.p_CB.y(), truth.p_CB.z(), truth.visible_fraction,
                 time_s);
}

/// The pictures that the truth of an earlier run names; none where there is no such file. A user's own truth
/// may stand there too: what is not called as we call pictures is the user's.
std::set<std::string> pictures_in(const std::filesystem::path& truth) {
  std::set<std::string> names;
  std::ifstream stream(truth);
  std::string row;
  const bool of_render = std::getline(stream, row) && !row.empty() && truth_header().rfind(row, 0) == 0;
  if (!of_render) return names;
  while (std::getline(stream, row)) {
    if (row.rfind("frame_", 0) == 0) names.insert(row.substr(0, row.find(',')));
  }
  return names;
}

/// The camera beside the pictures, in the format that its model and the others' tools like best.
void write_camera(const OutputFolder& folder, const Camera& camera) {
  const bool visp = camera.parameters().model == LensModel::visp;
  const std::string name = visp ? "camera.xml" : "camera.yaml";
  folder.write(name, camera_file_text(camera, camera_file_format("", name), "camera"));
}

int run_render(const RenderOptions& options) {
  const Scenario scenario = load_scenario(options.scenario, options.sets, options.common.seed);
  admit(scenario, options.common, 1);
  OutputFolder folder(options.output, options.common.overwrite(options.output));
  folder.supersede([earlier = pictures_in(options.output / "truth.csv")](const std::string& name) {
    return earlier.count(name) > 0;
  });
  SimulatedCamera camera(scenario, true, [&scenario](double time_s) {
    return RobotTruth{time_s, scenario.robot.pose, {}};
  });
  write_camera(folder, scenario.camera.camera);

  std::string rows = truth_header();
  Progress progress("pictures", options.frames, options.common.quiet);
  int pictures = 0;
  SteppedClock clock;
  while (camera.next_frame() < options.frames && !interrupt_requested()) {
    const auto frame = camera.take(clock, camera.next_start_s() + scenario.camera.exposure_s);
    progress.step(camera.next_frame());
    if (!frame) continue;
    const std::string source = fmt::format("frame_{:04}.png", frame->number);
    folder.write(source, picture_bytes(frame->bgr, ".png"));
    for (const BallTruth& truth : ball_truth(scenario.camera.camera, scenario.world, camera.truth().view))
      rows += truth_row(source, truth, frame->time_s);
    ++pictures;
  }
  const bool interrupted = camera.next_frame() < options.frames;
  if (pictures == 0 && !interrupted)
    throw Refusal(fmt::format("no picture: camera.faults drop all {} frames", options.frames));
  folder.write("truth.csv", rows);
  options.common.files->commit(folder);
  write_json_results(options.common, {{"pictures", pictures},
                                      {"balls", scenario.world.balls.size()},
                                      {"scenario", nlohmann::json::parse(scenario.resolved_json)},
                                      {"seed", options.common.seed},
                                      {"interrupted", interrupted}});
  if (!options.common.quiet) {
    print_result("{}, truth.csv and the camera: {}{}\n", counted(pictures, "picture"),
                 options.output.string(), interrupted ? " (interrupted)" : "");
  }
  return interrupted ? exit_interrupted : exit_done;
}

}  // namespace

void add_render_command(CLI::App& program, Action& action) {
  const auto [command, options] = add_command<RenderOptions>(
      program, action, "render", "Render pictures of a scenario, with exact truth", run_render);
  command.footer(R"(Example:
  ballservo render data/scenarios/static_ball.yaml -o pictures --frames 10

The robot stands at its start; frames follow each other at the camera's rate, and balls move by
their own motion. They are the frames of servo with the same seed as long as its robot stands:
camera.faults darken them, or drop some, which leaves gaps in the numbers.
DIR holds frame_0000.png and so on, truth.csv (a row for each ball and picture) and the camera's
file (camera.yaml; camera.xml for a ViSP model).)");
  command.add_option("SCENARIO", options.scenario, "A scenario (YAML)")->required();
  add_output_option(command, "-o,--output", options.output, "DIR", "Folder for the pictures")->required();
  add_integer_option(command, "--frames", options.frames, 1, 1000000, "How many frames (default 30)");
  add_set_option(command, options.sets);
  add_common_options(command, options.common);
}

}  // namespace ballservo
