// What the commands share. Each command is one file with one `add_..._command` that describes its options and
// hands main what to run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "calibration/files/image_file.hpp"
#include "calibration/files/output.hpp"

namespace ballservo {

/// The program's exit codes.
enum ExitCode : int { exit_done = 0, exit_answer_is_no = 1, exit_bad_input = 2, exit_our_fault = 3, exit_interrupted = 130 };

/// The options that every command has.
struct CommonOptions {
  std::filesystem::path json;  ///< empty: no JSON
  bool quiet = false;
  bool force = false;
  std::uint64_t seed = 0;
  int threads = 0;             ///< 0: as many as the machine has
  double max_pixels = default_max_pixels;

  Overwrite overwrite() const { return force ? Overwrite::allow : Overwrite::refuse; }
};

/// Adds --json, --quiet, --force, --seed, --threads, --max-pixels to a command.
void add_common_options(CLI::App& command, CommonOptions& options);

/// What main runs once the command line is parsed; returns an exit code, throws InputError, Refusal or Interrupted.
using Action = std::function<int()>;

/// Writes `results` at `options.json`, if that was asked for (two-space indentation, keys sorted, NaN as null).
void write_json_results(const CommonOptions& options, const nlohmann::json& results);

void add_calibrate_camera_command(CLI::App& calibrate, Action& action);
void add_calibrate_colors_command(CLI::App& calibrate, Action& action);
void add_detect_command(CLI::App& program, Action& action);
void add_track_command(CLI::App& program, Action& action);
void add_render_command(CLI::App& program, Action& action);
void add_servo_command(CLI::App& program, Action& action);
void add_compare_command(CLI::App& program, Action& action);

}  // namespace ballservo
