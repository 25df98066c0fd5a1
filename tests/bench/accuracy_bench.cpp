// How accurate: ours and the peers on the same frames, condition by condition, against exact truth.
//
//   build/release/tests/bench/accuracy_bench -o accuracy                  the table, 200 frames a condition
//   build/release/tests/bench/accuracy_bench --conditions base,clutter --frames 50
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <opencv2/core/utility.hpp>
#include <optional>

#include "app/commands/command.hpp"
#include "app/io/progress.hpp"
#include "calibration/base/fault.hpp"
#include "tests/bench/accuracy_report.hpp"

namespace ballservo::bench {
namespace {

struct Settings {
  std::uint64_t seed = 2;
  int frames = 200;
  bool sweeps = false, force = false, quiet = false;
  std::vector<std::string> conditions;
  std::filesystem::path output;
};

std::vector<const AccuracyCondition*> chosen(const Settings& settings) {
  std::vector<const AccuracyCondition*> list;
  std::string names;
  for (const AccuracyCondition& condition : accuracy_conditions()) {
    if (settings.conditions.empty() && (condition.sweep.empty() || settings.sweeps))
      list.push_back(&condition);
    if (condition.sweep.empty()) names += (names.empty() ? "" : ", ") + condition.name;
  }
  FaultList faults;
  for (const std::string& name : settings.conditions) {
    const std::size_t before = list.size();
    for (const AccuracyCondition& condition : accuracy_conditions()) {
      const bool is_named = condition.name == name || (!name.empty() && condition.sweep == name);
      if (is_named) list.push_back(&condition);
    }
    if (list.size() == before) faults.add("--conditions", name, "a sweep's name, or one of " + names);
  }
  faults.throw_if_any();
  return list;
}

// Sweeps draw many points from few frames each; false balls are rare and need many.
int frames_of(const AccuracyCondition& condition, int frames) {
  if (!condition.sweep.empty()) return std::max(1, frames / 4);
  return condition.neighbour == Neighbour::no_ball ? 5 * frames : frames;
}

int run(const Settings& settings, const std::string& command) {
  const std::vector<const AccuracyCondition*> conditions = chosen(settings);
  std::optional<OutputFolder> folder;
  if (!settings.output.empty())
    folder.emplace(settings.output, settings.force ? Overwrite::allow : Overwrite::refuse);
  long total = 0, done = 0;
  for (const AccuracyCondition* condition : conditions) total += frames_of(*condition, settings.frames);
  std::vector<ConditionScores> all;
  {
    Progress progress("accuracy", total, settings.quiet);
    for (const AccuracyCondition* condition : conditions) {
      all.push_back(score_condition(*condition, settings.seed, frames_of(*condition, settings.frames),
                                    [&] { progress.step(++done); }));
    }
  }
  fmt::print("{}", accuracy_table_heading());
  for (const ConditionScores& scores : all) fmt::print("{}", accuracy_table(scores));
  if (folder) {
    folder->write("accuracy.csv", accuracy_csv(all));
    folder->write("frames.csv", accuracy_frames_csv(all));
    if (const std::string svg = accuracy_sweeps_svg(all); !svg.empty()) folder->write("sweeps.svg", svg);
    folder->write("report.html", accuracy_report_html(all, command));
    folder->commit();
  }
  return exit_done;
}

}  // namespace
}  // namespace ballservo::bench

int main(int argc, char** argv) {
  using namespace ballservo;
  CLI::App program("Accuracy of ours and the peers on the same pictures, against exact truth",
                   "accuracy_bench");
  program.footer(
      "Example: accuracy_bench --conditions base,occluded_30 --frames 50 -o accuracy\n"
      "prints one table and writes accuracy.csv, frames.csv and report.html into the folder.\n"
      "Conditions without a ball get five times the frames, sweeps (distance_m, hidden, blur_px, noise, "
      "angle_deg) a quarter; their plots are in sweeps.svg too.");
  bench::Settings settings;
  program.add_option("--seed", settings.seed, "seed of the scenes (default 2)");
  add_integer_option(program, "--frames", settings.frames, 1, 1000000, "frames a condition (default 200)");
  program.add_option("--conditions", settings.conditions, "these conditions and sweeps only")->delimiter(',');
  program.add_flag("--sweeps", settings.sweeps, "the sweeps too, for the plots");
  program.add_option("-o,--output", settings.output, "folder for the results");
  program.add_flag("--force", settings.force, "replace outputs that exist");
  program.add_flag("--quiet", settings.quiet, "no progress");
  std::string command = "accuracy_bench";
  for (int i = 1; i < argc; ++i) command += std::string(" ") + argv[i];
  try {
    program.parse(argc, argv);
    cv::setNumThreads(1);
    return bench::run(settings, command);
  } catch (const CLI::ParseError& error) {
    const int code = program.exit(error);
    return code == 0 ? exit_done : exit_bad_input;
  } catch (const InputError& error) {
    for (const Fault& fault : error.faults())
      fmt::print(stderr, "accuracy_bench: error: {}\n", to_text(fault));
    return exit_bad_input;
  }
}
