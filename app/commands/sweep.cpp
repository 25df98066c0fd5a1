// ballservo sweep: many closed-loop runs of a scenario; ballservo sweep merge: the parts of one, joined.
#include "app/sweep/sweep.hpp"

#include <spdlog/spdlog.h>

#include <opencv2/core/utility.hpp>

#include "app/commands/command.hpp"
#include "app/commands/work_options.hpp"
#include "app/io/interrupt.hpp"
#include "app/io/progress.hpp"
#include "app/report/draw_pages.hpp"
#include "app/sweep/grid.hpp"
#include "app/sweep/sweep_statistics.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/options.hpp"

namespace ballservo {
namespace {

struct SweepCommandOptions {
  CommonOptions common;
  WorkOptions work;
  std::filesystem::path scenario, against;
  std::vector<std::string> sets, vary;
  std::string perception = "geometric";
  int trials = 0;
};

/// The other sweep's folder and what it holds; nothing where none was named.
std::optional<Sweep> read_other(const std::filesystem::path& folder, const nlohmann::json& description) {
  if (folder.empty()) return std::nullopt;
  std::vector<Sweep> sweeps = read_sweeps(folder);
  if (is_grid(description) || sweeps.size() > 1)
    throw InputError("--against " + folder.string(), "a grid", "a sweep of one scenario without --vary");
  return std::move(sweeps.front());
}

void say(const nlohmann::ordered_json& summary, const std::filesystem::path& folder, bool quiet) {
  const long reached = summary["reached"], infeasible = summary["infeasible"],
             feasible = summary["trials"].get<long>() - infeasible;
  const auto percent = [](const nlohmann::ordered_json& share) { return 100 * share.get<double>(); };
  print_result("{} of {} reached, {} collisions\n", reached, feasible, summary["collisions"].get<long>());
  if (quiet) return;
  if (feasible == 0)
    print_message("ballservo: no world of the {} can be, so nothing is known of success: {}\n", infeasible,
                  folder.string());
  else
    print_message("ballservo: success 95 % interval {:.2f} to {:.2f} %, {} infeasible: {}\n",
                  percent(summary["success_ci95"][0]), percent(summary["success_ci95"][1]), infeasible,
                  folder.string());
  if (!summary.contains("against")) return;
  const nlohmann::ordered_json &against = summary["against"], &success = against["success"];
  const std::string other = against["other"];
  const long pairs = success["pairs"], other_worlds = against["pairs_with_other_worlds"];
  if (pairs == 0) {
    spdlog::warn("{} has none of this sweep's feasible seeds: nothing to compare", other);
    return;
  }
  print_message(
      "ballservo: success less that of {}: {:+.2f} % (95 % interval {:+.2f} to {:+.2f} %), {} pairs\n", other,
      percent(success["difference"]), percent(success["difference_ci95"][0]),
      percent(success["difference_ci95"][1]), pairs);
  if (other_worlds > 0)
    spdlog::warn("in {} pairs the seed drew other values in {}: those worlds differ", other_worlds, other);
}

/// What has become of a sweep, of a grid's cells, or of a part of them, with the sweep that it is compared
/// with.
struct SweepOutcome {
  const nlohmann::json& description;
  const std::vector<Sweep>& sweeps;
  Shard shard;
  bool interrupted = false;
  const std::optional<Sweep>& other;
  std::filesystem::path other_name;
};

/// Writes the results into `folder`, unless that is null, and says what they are.
void finish_sweep(const SweepOutcome& outcome, const CommonOptions& common,
                  const std::filesystem::path& output, WorkFolder* folder) {
  const auto& [description, sweeps, shard, interrupted, other, other_name] = outcome;
  const bool grid = is_grid(description);
  const Sweep& sweep = sweeps.front();
  nlohmann::ordered_json against;
  if (other) against = compare_sweeps(sweep, *other, other_name.string());
  const nlohmann::ordered_json summary = grid ? grid_summary_json(description, sweeps, shard, interrupted)
                                              : sweep_summary_json(sweep, shard, interrupted, against);
  if (folder) {
    folder->write("trials.csv", grid ? grid_trials_csv(sweeps) : sweep.trials_csv);
    if (grid)
      folder->write("grid.csv", grid_csv(description, sweeps));
    else
      folder->write("traces.jsonl", sweep.traces_jsonl);
    folder->write("summary.json", summary.dump(2) + "\n");
    folder->write(report_json_name,
                  report_text(grid ? grid_report(description) : sweep_report(sweep, other)));
    draw_page_or_warn(folder->staging(), output.string(), common.quiet);
    if (interrupted) {
      folder->commit_unfinished();
    } else {
      common.files->commit();
      folder->commit_finished();
    }
  }
  write_json_results(common, nlohmann::json(summary));
  if (!grid) return say(summary, output, common.quiet);
  print_result("{}", grid_table(summary));
  if (!common.quiet)
    print_message("ballservo: {}: {}\n", counted(static_cast<long>(sweeps.size()), "cell"), output.string());
}

void check(const SweepCommandOptions& options) {
  FaultList faults;
  if (options.scenario.empty()) faults.add("SCENARIO", "nothing", "a scenario's or suite's file");
  if (options.work.output.empty()) faults.add("-o", "nothing", "a folder for the results");
  if (options.trials == 0) faults.add("--trials", "nothing", "how many runs");
  faults.collect([&] { parse_shard(options.work.shard); });
  faults.collect([&] { parse_perception_level(options.perception); });
  faults.throw_if_any();
}

int run_sweep_command(const SweepCommandOptions& options) {
  check(options);
  cv::setNumThreads(1);  // the cores are shared among trials
  SweepOptions sweep;
  sweep.scenario = options.scenario;
  sweep.sets = options.sets;
  sweep.perception = parse_perception_level(options.perception);
  sweep.first_seed = options.common.seed;
  sweep.trials = options.trials;
  sweep.shard = parse_shard(options.work.shard);
  sweep.threads = options.common.threads;
  const int pictures = sweep.perception == PerceptionLevel::image ? threads_of(options.common) : 0;
  sweep.admit = [&options, pictures](const Scenario& scenario) { admit(scenario, options.common, pictures); };
  const auto [works, description] = plan_sweeps(sweep, options.vary);
  const std::string gain = works.front().description.at("gain_warning");
  if (!gain.empty() && !is_grid(description)) spdlog::warn(gain);
  const std::optional<Sweep> other = read_other(options.against, description);
  WorkFolder folder(options.work.output, {description, sweep.shard}, options.work.resume,
                    options.common.overwrite(options.work.output), trials_of(works));
  const bool finished_before = folder.already_finished();
  const std::size_t mine = works.size() * seeds_of(sweep).size();
  if (!finished_before && folder.journal().size() > mine)
    throw InputError("--trials", fmt::format("{} where {} are done", mine, folder.journal().size()),
                     "no fewer than are done, another folder, or --force to begin anew");
  std::vector<Sweep> results;
  if (finished_before) {
    spdlog::info("{} is finished already", options.work.output.string());
    results = read_sweeps(options.work.output);
  } else {
    if (folder.has_grown()) note_results(options.work.output, works, folder.journal());
    std::optional<Progress> bar;
    results = run_sweeps(
        works, folder.journal(), [] { return !interrupt_requested(); },
        [&](long done, long total) {
          if (!bar) bar.emplace("trials", total, options.common.quiet);
          bar->step(done);
        });
  }
  std::size_t done = 0;
  for (const Sweep& result : results) done += result.trials.size();
  const bool interrupted = done < mine;
  // A finished folder keeps the comparison it has, unless another is asked for.
  finish_sweep({description, results, sweep.shard, interrupted, other, options.against}, options.common,
               options.work.output, finished_before && !other ? nullptr : &folder);
  if (!interrupted) return exit_done;
  print_message("ballservo: interrupted after {} of {} trials; --resume goes on\n", done, mine);
  return exit_interrupted;
}

int run_sweep_merge(const MergeOptions& options) {
  const MergeableShards shards = read_shards(options.folders);
  const std::optional<Sweep> other = read_other(options.against, shards.description);
  const std::vector<Sweep> sweeps = read_sweeps(shards);
  // A merge is written at once and resumed by nobody: there are no notes of it.
  WorkFolder folder(options.output, {shards.description, {}}, false, options.common.overwrite(options.output),
                    [](auto&&...) { return false; });
  finish_sweep({shards.description, sweeps, {}, false, other, options.against}, options.common,
               options.output, &folder);
  return exit_done;
}

}  // namespace

void add_sweep_command(CLI::App& program, Action& action) {
  const auto [command, options] = add_command<SweepCommandOptions>(
      program, action, "sweep", "Run scenarios many times, a seed each, and count", run_sweep_command);
  command.footer(R"(Examples:
  ballservo sweep data/scenarios/static_ball.yaml -o sweep --trials 300
  ballservo sweep data/scenarios/static_ball.yaml -o visp --trials 300 --set law.name=visp --against sweep

Trial k has seed --seed + k. Writes trials.csv (one row a trial), summary.json (rates with 95 % intervals,
failures by cause), report.html, and traces.jsonl (the ways, which the report draws). The results are the
same bytes at any number of threads, however the work was split, killed and resumed:

  ballservo sweep S.yaml -o part_2 --trials 3000 --shard 2/4     the second of four parts
  ballservo sweep merge part_1 part_2 part_3 part_4 -o whole
  ballservo sweep S.yaml -o sweep --trials 3000 --resume         goes on where it was killed

--vary KEY=V1,V2,... runs the trials for every value of a scenario's key, given twice for every pair of values, and
so on; all cells run the same seeds. grid.csv has a row a cell, and the page a curve or a map:

  ballservo sweep S.yaml -o grid --trials 100 --vary law.gain_per_s=0.5,1,2 --vary camera.latency_s=0.033,0.1

A suite is a file that names scenarios, by their paths from it: `scenarios: [door.yaml, corner.yaml]`. It runs as a
grid of them, with or without --vary; stdout is a table with a row a scenario and value:

  ballservo sweep data/suites/hard.yaml -o hard --trials 100
  ballservo sweep data/suites/hard.yaml -o laws --trials 100 --vary law.name=cone,visp --vary avoidance.type=full,none

Exit: 0 done (whatever was found), 2 bad input, 130 interrupted (what was finished is written; --resume).)");
  add_typed_option(command, "SCENARIO", options.scenario, "SCENARIO",
                   "Scenario, or suite of them (YAML); required");
  add_work_options(command, options.work);
  add_integer_option(command, "--trials", options.trials, 1, SweepOptions::max_trials,
                     "How many runs, over all parts; required");
  add_set_option(command, options.sets);
  add_typed_option(command, "--vary", options.vary, "KEY.PATH=V1,V2,...",
                   "Runs every value of a key of the scenario, e.g. law.name=cone,visp (may be repeated)")
      ->take_all()
      ->allow_extra_args(false);
  add_perception_option(command, options.perception);
  add_against_option(command, options.against);
  add_keys_flag(command, "scenario", [] { return scenario_keys(); });
  add_common_options(command, options.common);
  CLI::App* merge = add_merge_command(command, action, run_sweep_merge, true);
  merge->description("Join the parts of a sweep (--shard) into one");
  merge->footer(R"(Example:
  ballservo sweep merge part_1 part_2 part_3 part_4 -o whole

The result is what one run without --shard would have written, byte for byte. Parts of different sweeps are
refused, missing ones named. A whole sweep may be given alone, to compare it --against another.)");
}

}  // namespace ballservo
