// ballservo live: a page in the browser on what a camera or a recording shows.
#include <fmt/format.h>

#include <cmath>

#include "app/commands/ball_options.hpp"
#include "app/commands/command.hpp"
#include "app/commands/work_options.hpp"
#include "app/experiment/run_log.hpp"
#include "app/io/interrupt.hpp"
#include "app/live/footage_session.hpp"
#include "app/live/live_server.hpp"
#include "app/live/scenario_session.hpp"
#include "app/report/draw_pages.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/boards/board.hpp"

namespace ballservo {
namespace {

struct LiveOptions {
  CommonOptions common;
  BallOptions balls;
  FootageOptions footage;
  LiveServerOptions server;
  std::vector<std::string> sets;
  std::string perception = "image", board;
  double square_m = std::nan("");
};

bool is_scenario(const std::string& source) {
  const std::string extension = std::filesystem::path(source).extension();
  return extension == ".yaml" || extension == ".yml";
}

/// Serves the page while the session runs, and says what came of it.
template <typename Session>
int serve(const LiveOptions& options, LiveExchange& exchange, Session& session, const char* count,
          long (Session::*counted)() const) {
  {
    const LiveServer server(options.server, exchange);
    print_result("{}\n", server.url());
    session.run();
  }
  write_json_results(options.common, {{count, (session.*counted)()}, {"interrupted", interrupt_requested()}});
  return interrupt_requested() ? exit_interrupted : exit_done;
}

/// Each run into a folder of its own: the one that was named, and others beside it.
void keep_run(const LiveOptions& options, const Scenario& scenario, const RunRecord& run,
              const Touches& touches, long number) {
  const std::filesystem::path& first = options.footage.record;
  OutputFolder folder(number > 1 ? unused_path(first) : first,
                      number > 1 ? Overwrite::refuse : options.common.overwrite(first));
  write_run(folder, run, scenario, options.perception);
  Scenario touched = scenario;
  for (const Touch& touch : touches.list) touch_scenario(touch, scenario, touched);
  folder.write(report_json_name, report_text(run_report(run, touched, options.perception, folder)));
  folder.write("touches.yaml", touches_yaml(touches));
  folder.commit();
}

int run_scenario(const LiveOptions& options) {
  const BallOptions& balls = options.balls;
  const FootageOptions& footage = options.footage;
  FaultList faults;
  for (const auto& [option, given] : {std::pair("--colors", !balls.colors.empty()),
                                      {"--camera", !balls.camera.empty()},
                                      {"--fov", !balls.fov.empty()},
                                      {"--diameter", !balls.diameter.empty()},
                                      {"--last", footage.last_s > 0},
                                      {"--output", !footage.colors_output.empty()},
                                      {"--stream", !footage.stream.empty()},
                                      {"--board", !options.board.empty()},
                                      {"--square", !std::isnan(options.square_m)},
                                      {"--save-camera", !footage.camera_output.empty()}})
    if (given) faults.add(option, "with a scenario", "none: a scenario names its own, --set sets it");
  faults.throw_if_any();
  const PerceptionLevel level = parse_perception_level(options.perception);
  const Scenario scenario = load_scenario(options.footage.source, options.sets, options.common.seed);
  admit(scenario, options.common, 1);
  ScenarioSessionOptions session_options{level, colors_of(scenario, level), {}};
  if (!options.footage.record.empty()) {
    session_options.keep = [&, number = 0L](const RunRecord& run, const Touches& touches) mutable {
      keep_run(options, scenario, run, touches, ++number);
    };
  }
  LiveExchange exchange;
  ScenarioSession session(scenario, session_options, exchange);
  return serve(options, exchange, session, "runs", &ScenarioSession::runs);
}

int run_live(LiveOptions& options) {
  FootageOptions& footage = options.footage;
  if (is_scenario(footage.source)) return run_scenario(options);
  if (!options.sets.empty())
    throw InputError("--set", "with a source that is no scenario", "a scenario (YAML)");
  footage.max_pixels = options.common.max_pixels;
  if (!footage.colors_output.empty())
    footage.overwrite_colors = options.common.overwrite(footage.colors_output);
  if (!footage.camera_output.empty())
    footage.overwrite_camera = options.common.overwrite(footage.camera_output);
  if (!options.board.empty()) footage.board = options.board;
  if (!std::isnan(options.square_m)) footage.square_m = options.square_m;
  parse_board(footage.board, footage.square_m > 0 ? footage.square_m : 1);  // said now, if it is none
  if (!footage.record.empty()) footage.overwrite_recording = options.common.overwrite(footage.record);
  if (!(footage.last_s >= 0 && footage.last_s <= 600))
    throw InputError("--last", fmt::format("{}", footage.last_s), "0 to 600 (s)");
  if (footage.last_s > 0 && footage.record.empty())
    throw InputError("--last", "without --record", "--record DIR, where they are written");
  if (footage.stream == standard_output && options.common.json == standard_output)
    throw InputError("--json", "stdout, where the stream goes", "the name of a file");
  LiveExchange exchange;
  FootageSession session(footage, DetectorFactory(options.balls, options.common), exchange);
  return serve(options, exchange, session, "pictures", &FootageSession::pictures);
}

}  // namespace

void add_live_command(CLI::App& program, Action& action) {
  const auto [command, options] = add_command<LiveOptions>(
      program, action, "live",
      "A page in the browser: teach colours by clicking, follow balls, see why; touch a run", run_live);
  options.balls.taught = false;
  command.footer(R"(Examples:
  ballservo live camera:0 -o my.colors
  ballservo live camera:0 --board chessboard:9x6 --square 0.025 --diameter 0.07 --save-camera camera.yaml
  ballservo live throw.mp4 --colors my.colors --camera camera.yaml --diameter 0.07 --record throw
  ballservo live data/scenarios/obstacles.yaml --perception geometric --record touched

Prints the page's address, and serves it until Ctrl-C (130) or the page's End (0). Click on a ball to teach its
colour; with Teach off, a click says why something is no ball. A video runs at its own pace, and again.
A camera's exposure, gain, white balance and focus are set, and held as they are, in the page; Save keeps them with
the colours, and --colors sets the camera so again. What it did not obey is said.
Calibrate fits the camera from a board that is held before it, as `calibrate camera` does: a picture is taken by itself
once the board is still, the page says where to hold it next, and Save camera goes on with that camera.
Only this machine reaches the page, unless --listen names another address of it: then the page's address holds
a secret, and who knows it can do what the page can.
--record keeps every picture (PNG) with its time, and the tracks: the folder is a SOURCE for detect, track and
live, also after a kill. With --last 30 the page keeps what has just happened, after the fact.
A scenario runs at the wall's pace: drag its ball, its obstacles and the robot, change law, gain, latency, noise, light
and avoidance. --record keeps each run with what was done to it: servo --touches, with the same --set, --seed and
--perception, does it again: the same log.csv and tracks.csv, to the last byte.)");
  command
      .add_option("SOURCE", options.footage.source,
                  "A video, a folder of images or a recording, an image, camera:N, or a scenario (YAML)")
      ->required();
  add_ball_options(command, options.balls);
  command.add_flag("--fixed-colors", options.footage.fixed_colors, "Do not let the colours follow the light");
  add_number_option(command, "--fps", options.footage.fps, fps_range(),
                    "Times pictures that carry no time of their own (default 30 Hz)");
  add_integer_option(command, "--port", options.server.port, 0, 65535,
                     "The page's port (default 0: any free one)");
  add_typed_option(command, "--listen", options.server.address, "ADDRESS",
                   "The page's IP address; 0.0.0.0: all that this machine has")
      ->capture_default_str();
  add_output_option(command, "-o,--output", options.footage.colors_output, "FILE.colors",
                    "Where the page's Save writes the colours; without it, it downloads them");
  add_typed_option(command, "--board", options.board, "BOARD",
                   "The board that the page proposes to calibrate with: chessboard:9x6, circles:6x6 ...");
  add_number_option(command, "--square", options.square_m, NumberRange::above(0, "m"),
                    "Side of its squares, or distance of its circles, in metres");
  add_output_option(command, "--save-camera", options.footage.camera_output, "FILE",
                    "Where the page's Save camera writes (.xml: ViSP, .yaml: ROS); without it, it downloads");
  add_output_option(command, "--record", options.footage.record, "DIR",
                    "Keep pictures, times and tracks here; what is recorded after that in DIR_2, DIR_3 ..., "
                    "whichever is free");
  add_typed_option(
      command, "--last", options.footage.last_s, "SECONDS",
      "Records nothing until the page asks for it, and keeps the last SECONDS at hand (256 MB at most)");
  add_typed_option(command, "--stream", options.footage.stream, "-|udp:HOST:PORT",
                   "Sends the tracks as `track` does; with - the address is printed on stderr");
  add_set_option(command, options.sets);
  add_perception_option(command, options.perception);
  add_common_options(command, options.common);
}

}  // namespace ballservo
