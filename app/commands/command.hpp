// What the commands share. Each command is one file with one `add_..._command` that describes its options and
// hands main what to run.
#pragma once

#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "app/io/messages.hpp"
#include "app/io/run_files.hpp"
#include "calibration/base/output.hpp"
#include "calibration/base/strict_yaml.hpp"
#include "calibration/pictures/image_file.hpp"

namespace ballservo {

struct OptionRow;

/// The program's exit codes.
enum ExitCode : int {
  exit_done = 0,
  exit_answer_is_no = 1,
  exit_bad_input = 2,
  exit_our_fault = 3,
  exit_interrupted = 130
};

inline constexpr int max_threads = 1024;

/// The options that every command has.
struct CommonOptions {
  std::filesystem::path json;  ///< empty: no JSON
  bool quiet = false;
  bool force = false;
  std::uint64_t seed = 0;
  int threads = 0;                                  ///< 0: as many as the machine has
  std::shared_ptr<tbb::global_control> processors;  ///< keeps to `threads` while it lives
  double max_pixels = default_max_pixels;

  std::shared_ptr<RunFiles> files = std::make_shared<RunFiles>();

  /// Of an output that an option names; what else a command would write is its mistake (std::logic_error).
  Overwrite overwrite(const std::filesystem::path& output) const {
    files->require(output);
    return force ? Overwrite::allow : Overwrite::refuse;
  }
};

/// Adds an option that names an output, in the help's group of that name: such are kept apart from each other
/// and from all inputs, which are the positionals and the options whose type says FILE, DIR, IMAGE or VIDEO.
/// `type`: FILE.csv may be `-` as --json may, others not.
CLI::Option* add_output_option(CLI::App& command, const std::string& name, std::filesystem::path& value,
                               const std::string& type, const std::string& help);

/// Adds --json, --quiet, --force, --seed, --threads, --max-pixels to a command.
void add_common_options(CLI::App& command, CommonOptions& options);

/// An option that holds a number, read without regard to the locale ("010" is ten, "nan" and "0x10" are
/// refused), and checked against its range.
CLI::Option* add_number_option(CLI::App& command, const std::string& name, double& value,
                               const NumberRange& range, const std::string& help);
CLI::Option* add_integer_option(CLI::App& command, const std::string& name, int& value, int low, int high,
                                const std::string& help);

/// `--keys`: prints every key of a `file` ("scenario"), and ends the program.
void add_keys_flag(CLI::App& command, const std::string& file, std::vector<OptionRow> (*keys)());

/// The parts of a text between separators; where there is none, the text itself.
std::vector<std::string> split(const std::string& text, char separator);

/// "1 picture", "2 pictures".
std::string counted(long count, const std::string& thing);

/// A name that is in `used` from now on and was not before: `name`, or it with the first of _2, _3 ... that
/// is free. Pictures of one name in different folders must not overwrite each other's results.
std::string unused_name(std::set<std::string>& used, const std::string& name);

/// What main runs once the command line is parsed; returns an exit code, throws InputError, Refusal or
/// Interrupted.
using Action = std::function<int()>;

/// An option whose help names its type.
template <class Value>
CLI::Option* add_typed_option(CLI::App& command, const std::string& name, Value& value,
                              const std::string& type, const std::string& help) {
  return command.add_option(name, value, help)->type_name(type);
}

/// Before any work every output whose name is taken, or whose folder cannot be written, is a fault: all are
/// said. A folder that holds an unfinished job is left to the job's own command.
void check_outputs(const CLI::App& command, const CommonOptions& options);

/// Adds a command that runs `run` on its options, unless one of its own commands was asked for.
template <class Options, class Run>
std::pair<CLI::App&, Options&> add_command(CLI::App& parent, Action& action, const std::string& name,
                                           const std::string& what, Run run) {
  const auto options = std::make_shared<Options>();
  CLI::App* const command = parent.add_subcommand(name, what);
  command->callback([=, &action] {
    if (!command->get_subcommands().empty()) return;
    action = [=] {
      check_outputs(*command, options->common);
      return run(*options);
    };
  });
  return {*command, *options};
}

/// Writes `results` at `options.json`, if that was asked for (two-space indentation, keys sorted, NaN as
/// null).
void write_json_results(const CommonOptions& options, const nlohmann::json& results);

void add_calibrate_board_command(CLI::App& calibrate, Action& action);
void add_calibrate_camera_command(CLI::App& calibrate, Action& action);
void add_calibrate_diff_command(CLI::App& calibrate, Action& action);
void add_calibrate_radius_command(CLI::App& calibrate, Action& action);
void add_calibrate_colors_command(CLI::App& calibrate, Action& action);
void add_detect_command(CLI::App& program, Action& action);
void add_track_command(CLI::App& program, Action& action);
void add_live_command(CLI::App& program, Action& action);
void add_render_command(CLI::App& program, Action& action);
void add_servo_command(CLI::App& program, Action& action);
void add_sweep_command(CLI::App& program, Action& action);
void add_compare_command(CLI::App& program, Action& action);
void add_report_command(CLI::App& program, Action& action);

}  // namespace ballservo
