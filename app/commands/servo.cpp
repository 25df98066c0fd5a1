// ballservo servo: one closed-loop run of a scenario.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <memory>

#include "app/commands/ball_search.hpp"
#include "app/commands/command.hpp"
#include "app/commands/work_options.hpp"
#include "app/experiment/run_log.hpp"
#include "app/experiment/run_video.hpp"
#include "app/experiment/runner.hpp"
#include "app/experiment/touches.hpp"
#include "app/io/interrupt.hpp"
#include "app/io/progress.hpp"
#include "app/io/video_writer.hpp"
#include "app/report/draw_pages.hpp"
#include "app/scenario/feasibility.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/options.hpp"
#include "calibration/base/statistics.hpp"

namespace ballservo {
namespace {

struct ServoOptions {
  CommonOptions common;
  std::filesystem::path scenario, output, touches;
  std::vector<std::string> sets;
  std::string perception = "image";
  bool video = false, teach = false, realtime = false;
  std::string peer, serve;
  double deadline_s = 1;
};

/// Where the target comes within the run, seen from above.
Eigen::AlignedBox2d ball_floor(const Scenario& scenario) {
  constexpr double step_s = 0.1;
  Eigen::AlignedBox2d floor;
  for (double time_s = 0; time_s <= scenario.duration_s; time_s += step_s)
    floor.extend(scenario.target_ball().p_WB(time_s).head<2>());
  return floor;
}

/// The run's film: the camera's picture on the left, the room from above on the right; slow where the robot
/// moves close to something.
class Film {
 public:
  Film(const std::filesystem::path& file, const Scenario& scenario)
      : video_(file, Overwrite::allow, scenario.camera.rate_hz),
        top_view_(scenario.world, scenario.robot.footprint, scenario.robot.pose, ball_floor(scenario),
                  scenario.target_distance_m, scenario.camera.camera.size().height_px,
                  scenario.robot.sonar.value_or(SonarOptions{}).beam) {}

  void add(const cv::Mat& picture, const RunRecord& run, const std::vector<SonarFiring>& firings) {
    const cv::Mat both = side_by_side(picture, top_view_.draw(run.steps, firings));
    const StepRecord* now = run.steps.empty() ? nullptr : &run.steps.back();
    const bool tight = now != nullptr && now->clearance_m < tight_m && std::abs(now->twist.v_mps) > 0.02;
    for (int k = 0; k < (tight ? slow_down : 1); ++k) video_.write(both);
  }
  void finish() { video_.commit(); }

 private:
  static constexpr double tight_m = 0.20;  // clearance
  static constexpr int slow_down = 3;
  VideoFile video_;
  TopView top_view_;
};

/// The command that repeats a run.
std::string command_again(const ServoOptions& options) {
  std::string command = servo_command(options.scenario.generic_string(), "again", options.common.seed,
                                      options.perception, options.sets);
  if (!options.touches.empty()) command += " --touches " + quoted(options.touches.generic_string());
  if (!options.peer.empty()) command += " --peer " + quoted(options.peer);
  if (!options.serve.empty()) command += " --serve " + quoted(options.serve);
  return command + (options.realtime ? " --realtime" : "");
}

int exit_code(Outcome outcome) {
  if (outcome == Outcome::reached) return exit_done;
  return outcome == Outcome::interrupted ? exit_interrupted : exit_answer_is_no;
}

int run_teach(const ServoOptions& options) {
  if (options.video) throw InputError("--video", "with --teach", "one of them: teaching writes one file");
  if (options.realtime)
    throw InputError("--realtime", "with --teach", "one of them: teaching drives nowhere");
  const PerceptionLevel level = parse_perception_level(options.perception);
  const Scenario scenario = load_scenario(options.scenario, options.sets, options.common.seed);
  admit(scenario, options.common, level == PerceptionLevel::image ? 1 : 0);
  OutputFile file(options.output, options.common.overwrite(options.output));
  TeachOptions teach;
  teach.perception = level;
  teach.colors = colors_of(scenario, level);
  Progress progress("frames", teach.frames, options.common.quiet);
  teach.progress = [&progress](int done) {
    throw_if_interrupted();
    progress.step(done);
  };
  const TaughtTarget target = teach_target(scenario, teach);
  file.write(taught_target_yaml(target));
  options.common.files->commit(file);
  const Eigen::Vector3d& c = target.center_over_radius;
  write_json_results(options.common, {{"ball", target.ball},
                                      {"center_over_radius", {c.x(), c.y(), c.z()}},
                                      {"sigma", {target.sigma.x(), target.sigma.y(), target.sigma.z()}},
                                      {"frames", target.frames},
                                      {"distance_m", target.distance_m}});
  if (!options.common.quiet) {
    print_message("ballservo: saw ball {} in {} frames at {:.4f} radii: {}\n", target.ball, target.frames,
                  c.norm(), options.output.string());
  }
  return exit_done;
}

/// What a run on the wall clock should say of how it kept its times; empty where all was well.
std::string lateness(const Scenario& scenario, const RunRecord& run) {
  if (!run.timing.realtime) return "";
  const RealtimeTiming& wall = *run.timing.realtime;
  const std::size_t frames = run.frames.size();
  if (wall.frames_skipped == 0 && 20 * static_cast<std::size_t>(wall.frames_late) <= frames) return "";
  return fmt::format(
      "this machine does not keep up with the camera's {:g} Hz: of {} frames {} came late (the median {:.0f} "
      "ms after its exposure) and {} were left out; the robot drove by what came. A lower camera.rate_hz, or "
      "--perception geometric, costs less",
      scenario.camera.rate_hz, frames + static_cast<std::size_t>(wall.frames_skipped), wall.frames_late,
      median(wall.frame_age_ms), wall.frames_skipped);
}

/// Throws InputError for what a run with a peer has not.
void check_peer(const ServoOptions& options) {
  const std::string with = options.peer.empty() ? "with --serve" : "with --peer";
  const auto refuse = [&](bool asked, const char* option) {
    if (asked) throw InputError(option, with, "one of them");
  };
  if (options.peer.empty() && options.serve.empty()) return;
  refuse(!options.peer.empty() && !options.serve.empty(), "--serve");
  refuse(options.teach, "--teach");
  refuse(options.realtime, "--realtime");
  refuse(!options.touches.empty(), "--touches");
  refuse(options.video && !options.peer.empty(), "--video");
  refuse(options.perception == "truth" && !options.peer.empty(), "--perception truth");
}

/// The line to a peer.
std::unique_ptr<LockstepSocket> make_socket(const ServoOptions& options, const Scenario& scenario) {
  const bool serves = !options.serve.empty();
  const ImageSize size = scenario.camera.camera.size();
  LockstepSocket::Options line;
  line.option = serves ? "--serve" : "--peer";
  line.address = serves ? options.serve : options.peer;
  line.deadline_s = options.deadline_s;
  // Pictures of a wrong size are told from silence, if they are not too large by far.
  line.most_bytes = std::max(most_header_bytes, 12u * static_cast<std::size_t>(size.width_px) *
                                                    static_cast<std::size_t>(size.height_px));
  auto socket = std::make_unique<LockstepSocket>(
      serves ? LockstepSocket::Side::robot : LockstepSocket::Side::controller, line);
  if (!options.common.quiet)
    print_message("ballservo: waiting for a {} at {}\n", serves ? "controller" : "robot", socket->address());
  return socket;
}

int run_servo(const ServoOptions& options) {
  check_peer(options);
  if (options.teach) return run_teach(options);
  if (options.video && options.realtime) {
    throw InputError("--video", "with --realtime",
                     "one of them: drawing a film would hold the camera up; in simulated time it does not");
  }
  const PerceptionLevel level = parse_perception_level(options.perception);
  if (!options.touches.empty() && options.realtime)
    throw InputError("--touches", "with --realtime",
                     "one of them: a run on the wall clock is never the same twice");
  Scenario scenario = load_scenario(options.scenario, options.sets, options.common.seed);
  admit(scenario, options.common, level == PerceptionLevel::image ? 1 : 0);
  RunOptions run_options;
  if (!options.touches.empty()) {
    const Touches touches = read_touches(options.touches, scenario);
    run_options.touch = replay(touches);
    scenario.duration_s = touches.duration_s(scenario);
  }
  std::unique_ptr<LockstepSocket> socket;
  if (!options.peer.empty() || !options.serve.empty()) socket = make_socket(options, scenario);
  if (!options.serve.empty()) {
    run_options.controller = socket.get();
    scenario.avoidance.type = AvoidanceOptions::Type::none;  // which is the controller's own affair
  }
  run_options.perception = level;
  run_options.colors = colors_of(scenario, level);
  const std::string gain = gain_warning(scenario);
  if (!gain.empty() && options.serve.empty()) spdlog::warn(gain);
  if (const std::string why = why_infeasible(scenario); !why.empty())
    spdlog::warn("the goal cannot be reached: {}", why);
  OutputFolder folder(options.output, options.common.overwrite(options.output));
  // A film, a page and key frames beside another run's log are that run's.
  const bool ran_before = std::filesystem::exists(options.output / "log.csv");
  folder.supersede([ran_before](const std::string& name) {
    return ran_before && (name == "video.mp4" || name == "report.html" || is_run_picture(name));
  });

  Progress progress(options.realtime ? "seconds" : "simulated seconds, at most",
                    std::lround(std::ceil(scenario.duration_s)), options.common.quiet);
  run_options.go_on = [&progress](double time_s) {
    progress.step(std::lround(time_s));
    return !interrupt_requested();
  };
  std::optional<Film> film;
  if (options.video) {
    film.emplace(folder.path() / "video.mp4", scenario);
    run_options.on_picture = [&film](const cv::Mat& picture, const RunRecord& run,
                                     const std::vector<SonarFiring>& firings) {
      film->add(picture, run, firings);
    };
  }

  const RunRecord run = !options.peer.empty() ? drive_peer(scenario, run_options, *socket)
                        : options.realtime    ? run_realtime(scenario, run_options)
                                              : run_closed_loop(scenario, run_options);
  if (socket && run.summary.outcome == Outcome::fault) spdlog::error(run.summary.outcome_text);
  if (const std::string late = lateness(scenario, run); !late.empty()) spdlog::warn(late);
  if (run.assumed_light) warn_of_other_light(light_text(*run.assumed_light));

  if (film) film->finish();
  const char* peer = !options.peer.empty() ? "robot" : !options.serve.empty() ? "controller" : "";
  write_run(folder, run, scenario, options.perception, peer);
  nlohmann::ordered_json report = run_report(run, scenario, options.perception, folder);
  if (!options.serve.empty()) report["law"] = "of a peer";
  report["command"] = command_again(options);
  write_report(folder, report, options.common.quiet);
  options.common.files->commit(folder);
  write_json_results(options.common, nlohmann::json(summary_json(run.summary, run.timing)));

  const RunSummary& s = run.summary;
  print_result("{}\n", outcome_name(s.outcome));
  if (!options.common.quiet || s.outcome != Outcome::reached) {
    const std::string errors =
        std::isfinite(s.range_error_m)
            ? fmt::format("range error {:.2f} mm, bearing error {:.3f} deg", s.range_error_m * 1e3,
                          s.bearing_error_rad * 57.29577951308232)
            : "the peer told no truth, so that its errors are not known";
    print_message("ballservo: {}; {}: {}\n", s.outcome_text, errors, options.output.string());
  }
  return exit_code(s.outcome);
}

}  // namespace

void add_servo_command(CLI::App& program, Action& action) {
  const auto [command, options] = add_command<ServoOptions>(
      program, action, "servo", "Drive a simulated robot to a ball that it sees, in closed loop", run_servo);
  command.footer(R"(Example:
  ballservo servo data/scenarios/static_ball.yaml -o run --video

Writes manifest.json, log.csv (one row a control step), tracks.csv (what was seen), summary.json,
report.html and, with --video, video.mp4. A run that reaches a resting ball ends half a second after
it has stood at the goal for a second. In rendered frames the ball is sought in other lights than the taught one, too, and
its colours follow the light; --set fixed_colors=true keeps them as taught.

  ballservo servo data/scenarios/static_ball.yaml --teach -o target.yaml
puts the robot at the goal, looks at the ball, and writes what it saw; with target: {ball: target, taught:
target.yaml} all laws drive to where that is seen again, whatever diameter and focal length are believed.
  ballservo servo data/scenarios/obstacles.yaml -o run --perception geometric --realtime
runs on the wall clock: camera, control and guard in threads of their own; the guard tells the drive to rest
where frames, sonars or the controller are silent. No two such runs are alike; summary.json says under timing.realtime
how old frames were and how regular the threads. With --perception image the frames are rendered on the way, as fast
as the machine can: what comes late is said.
  ballservo servo data/scenarios/obstacles.yaml -o run --perception geometric --touches touches.yaml
does again what was done to a run in the page of `ballservo live`, with the --perception, --set and --seed of that run:
the same log.csv and tracks.csv. Such a run ends when the file says, and has reached its ball as one has that moves.
  ballservo servo data/scenarios/static_ball.yaml -o run --perception geometric --peer tcp://127.0.0.1:5577
drives a robot that another program simulates or has: python3 app/examples/lockstep_robot.py is one.
  ballservo servo data/scenarios/static_ball.yaml -o run --perception geometric --serve tcp://127.0.0.1:5577
measures another program's controller in this scenario: python3 app/examples/lockstep_controller.py is one. It is
told pictures with --perception image, the ball with geometric. app/peer/README.md has the messages.
Exit: 0 the robot reached the ball, 1 it did not (the outcome says why), 2 bad input, 130 interrupted
(the run so far is written without a page, its outcome is interrupted; an earlier result stays instead).)");
  command.add_option("SCENARIO", options.scenario, "Scenario (YAML)")->required();
  add_output_option(command, "-o,--output", options.output, "DIR",
                    "Folder for the results; with --teach the file to write")
      ->required();
  command.add_flag("--teach", options.teach, "Stand at the goal, look, and write what is seen there");
  add_set_option(command, options.sets);
  add_perception_option(command, options.perception);
  command.add_flag("--video", options.video,
                   "Write video.mp4: camera view and top view side by side; three times as slow where the "
                   "robot moves within 0.2 m of something");
  command.add_flag("--realtime", options.realtime,
                   "On the wall clock, camera, control and guard in threads of their own");
  add_typed_option(command, "--peer", options.peer, "ADDRESS",
                   "Drive the robot that is served there: tcp://HOST:PORT");
  add_typed_option(command, "--serve", options.serve, "ADDRESS",
                   "Let a controller drive that comes there: tcp://127.0.0.1:PORT");
  add_number_option(command, "--deadline", options.deadline_s, NumberRange::within(0.001, 3600, "s"),
                    "A peer that is silent for so long ends the run (default 1)");
  add_typed_option(command, "--touches", options.touches, "FILE",
                   "What is done to the run while it goes on (YAML)");
  add_keys_flag(command, "scenario", [] { return scenario_keys(); });
  add_common_options(command, options.common);
}

}  // namespace ballservo
