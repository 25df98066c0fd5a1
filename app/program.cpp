// The program: parses the command line, runs one command, and turns how it ended into an exit code.
#include <fmt/format.h>
#include <glog/logging.h>
#include <spdlog/sinks/ansicolor_sink.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <regex>
#include <utility>
#include <vector>

#include "app/commands/command.hpp"
#include "app/io/interrupt.hpp"
#include "app/io/messages.hpp"
#include "calibration/base/fault.hpp"

namespace {

using namespace ballservo;

constexpr const char* description =
    "ballservo: a robot sees a coloured ball, places it in 3-D and drives to it.\n"
    "Results are files or stdout, messages go to stderr. Exit codes: 0 done, 1 the answer is no,\n"
    "2 bad usage or input, 3 a fault of the program, 130 interrupted.";

/// Sends what libraries print on std::cout to stderr: stdout holds results alone, which the commands print
/// with print_result.
class CoutOnStderr {
 public:
  CoutOnStderr() : saved_(std::cout.rdbuf(std::cerr.rdbuf())) {}
  ~CoutOnStderr() { std::cout.rdbuf(saved_); }
  CoutOnStderr(const CoutOnStderr&) = delete;
  CoutOnStderr& operator=(const CoutOnStderr&) = delete;

 private:
  std::streambuf* saved_;
};

void add_commands(CLI::App& program, Action& action) {
  CLI::App& calibrate =
      *program.add_subcommand("calibrate", "Learn a camera or the colours of balls from pictures");
  calibrate.require_subcommand(1);
  add_calibrate_board_command(calibrate, action);
  add_calibrate_camera_command(calibrate, action);
  add_calibrate_diff_command(calibrate, action);
  add_calibrate_radius_command(calibrate, action);
  add_calibrate_colors_command(calibrate, action);
  add_detect_command(program, action);
  add_track_command(program, action);
  add_live_command(program, action);
  add_render_command(program, action);
  add_servo_command(program, action);
  add_sweep_command(program, action);
  add_compare_command(program, action);
  add_report_command(program, action);
}

void set_up_messages() {
  // Not where assertions and sanitizers speak there.
#if defined(NDEBUG) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  keep_stderr_for_messages();
#endif
  using Sink = spdlog::sinks::ansicolor_sink<spdlog::details::console_mutex>;
  auto sink = std::make_shared<Sink>(message_stream(), spdlog::color_mode::automatic);
  spdlog::set_default_logger(std::make_shared<spdlog::logger>("ballservo", std::move(sink)));
  spdlog::set_pattern("%n: %l: %v");
  // Ceres tells through glog of steps that it then retries.
  FLAGS_minloglevel = google::GLOG_FATAL;
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_ERROR);
}

int show(const InputError& error) {
  constexpr std::size_t most = 100;
  std::size_t shown = 0;
  for (const Fault& fault : error.faults()) {
    if (shown++ == most) {
      print_message("ballservo: error: and {} more\n", error.faults().size() - most);
      break;
    }
    print_message("ballservo: error: {}\n", to_text(fault));
  }
  return exit_bad_input;
}

bool is_of_memory(const std::exception& error) {
  const auto* const of_opencv = dynamic_cast<const cv::Exception*>(&error);
  return dynamic_cast<const std::bad_alloc*>(&error) || (of_opencv && of_opencv->code == cv::Error::StsNoMem);
}

const CLI::App& chosen_command(const CLI::App& program) {
  const CLI::App* app = &program;
  while (!app->get_subcommands().empty()) app = app->get_subcommands().front();
  return *app;
}

/// The word that stands where a command should, with those that might; empty where none does.
std::string unknown_command(const CLI::App& app) {
  if (app.get_require_subcommand_min() == 0 || app.remaining().empty()) return {};
  std::string names;
  for (const CLI::App* const command : app.get_subcommands([](const CLI::App*) { return true; }))
    names += (names.empty() ? "" : ", ") + command->get_name();
  return to_text({"command", app.remaining().front(), names});
}

/// Levenshtein's distance: letters to change, add or take away.
std::size_t letters_apart(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j)
      diagonal = std::exchange(row[j + 1],
                               std::min({diagonal + (a[i] == b[j] ? 0 : 1), row[j] + 1, row[j + 1] + 1}));
  }
  return row.back();
}

/// The first option that the command does not know, with the one that may have been meant; or else the words
/// that it cannot use, in the order given; empty where all can be used.
std::string unknown_words(const CLI::App& app) {
  constexpr std::size_t near_letters = 2;
  for (const std::string& word : app.remaining()) {
    if (word.size() < 2 || word.front() != '-') continue;
    std::string meant;
    std::size_t nearest = near_letters;
    for (const CLI::Option* const option : app.get_options()) {
      for (const std::string& name : option->get_lnames()) {
        const std::size_t apart = letters_apart(word.substr(0, word.find('=')), "--" + name);
        if (apart > nearest) continue;
        meant = (apart == nearest && !meant.empty() ? meant + " or --" : "--") + name;
        nearest = apart;
      }
    }
    return word + ": no such option" + (meant.empty() ? "" : "; did you mean " + meant + "?");
  }
  return app.remaining().empty() ? "" : fmt::format("not expected: {}", fmt::join(app.remaining(), " "));
}

/// Help and version go to stdout with 0; what is wrong with the command line goes to stderr with 2.
int show(const CLI::App& program, const CLI::ParseError& error) {
  const CLI::App& app = chosen_command(program);
  std::string unknown = unknown_command(app);
  if (unknown.empty() && error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success))
    return program.exit(error);
  if (unknown.empty()) unknown = unknown_words(app);
  if (unknown.empty() && error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ArgumentMismatch))
    unknown = std::regex_replace(error.what(), std::regex("At Most (.+) required but received (.+)"),
                                 "found $2 values; allowed: no more than $1");
  print_message("ballservo: error: {}\nRun with --help for more information.\n",
                unknown.empty() ? error.what() : unknown);
  return exit_bad_input;
}

int run(int argc, char** argv) {
  CLI::App program(description, "ballservo");
  program.set_version_flag("--version", "ballservo " BALLSERVO_VERSION);
  program.require_subcommand(1);
  program.footer(R"(Example:
  ballservo calibrate camera left01.jpg left02.jpg left03.jpg --board chessboard:9x6 --square 0.025 -o left.yaml)");
  Action action;
  add_commands(program, action);
  try {
    program.parse(argc, argv);
    const CoutOnStderr cout_on_stderr;
    const int code = action();
    return code == exit_done && interrupt_requested() ? exit_interrupted : code;  // its page was not drawn
  } catch (const CLI::ParseError& error) {
    return show(program, error);
  } catch (const InputError& error) {
    return show(error);
  } catch (const Refusal& refusal) {
    print_message("ballservo: {}\n", refusal.what());
    return exit_answer_is_no;
  } catch (const Interrupted& interrupted) {
    print_message("ballservo: {}\n", interrupted.what());
    return exit_interrupted;
  } catch (const std::filesystem::filesystem_error& error) {
    return show(
        InputError(error.path1().string(), error.code().message(), "a file or folder that can be used"));
  } catch (const std::exception& error) {
    if (is_of_memory(error))
      return show(InputError("memory", "less than this run needs", "smaller pictures, or fewer --threads"));
    print_message("ballservo: a fault of ours, please report it with the command line: {}\n", error.what());
  } catch (...) {
    print_message("ballservo: a fault of ours, please report it with the command line\n");
  }
  return exit_our_fault;
}

}  // namespace

/// What main calls once the libraries are loaded.
extern "C" int ballservo_main(int argc, char** argv) {
  // Before there is a second thread: what videos refer to is files.
  setenv("OPENCV_FFMPEG_CAPTURE_OPTIONS", "protocol_whitelist;file", 1);
  install_interrupt_handler();
  set_up_messages();
  const int code = run(argc, argv);
  if (!stdout_failed() || code != exit_done) return code;
  if (!stdout_reader_left())  // `ballservo servo --keys | head` is no mistake
    print_message("ballservo: error: {}\n",
                  to_text({"stdout", "a full disk or a closed stream", "a place that can be written"}));
  return exit_bad_input;
}
