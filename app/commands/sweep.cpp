// ballservo sweep: many closed-loop runs of a scenario; ballservo sweep merge: the parts of one, joined.
#include "app/sweep/sweep.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <opencv2/core/utility.hpp>

#include "app/commands/command.hpp"
#include "app/commands/scenario_options.hpp"
#include "app/io/interrupt.hpp"
#include "app/io/progress.hpp"
#include "app/report/draw_pages.hpp"
#include "app/sweep/sweep_report.hpp"
#include "app/sweep/sweep_statistics.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/options.hpp"

namespace ballservo {
namespace {

constexpr int max_trials = 1000000;

struct SweepCommandOptions {
  CommonOptions common;
  std::filesystem::path scenario, output, against;
  std::vector<std::string> sets;
  std::string perception = "geometric", shard = "1/1";
  int trials = 0;
  bool resume = false;
};

struct MergeOptions {
  CommonOptions common;
  std::vector<std::filesystem::path> folders;
  std::filesystem::path output, against;
};

/// The other sweep's folder and what it holds; nothing where none was named.
std::optional<Sweep> read_other(const std::filesystem::path& folder) {
  if (folder.empty()) return std::nullopt;
  return read_sweep(folder);
}

void say(const Sweep& sweep, const SweepComparison* against, const std::filesystem::path& folder,
         bool quiet) {
  const SweepCounts n = count_trials(sweep.trials);
  const ConfidenceInterval ci = clopper_pearson_ci95(n.reached, n.feasible());
  fmt::print("{} of {} reached, {} collisions\n", n.reached, n.feasible(), n.collisions);
  if (quiet) return;
  fmt::print(stderr, "ballservo: success 95 % interval {:.2f} to {:.2f} %, {} infeasible: {}\n", ci.low * 100,
             ci.high * 100, n.infeasible, folder.string());
  if (against == nullptr) return;
  if (against->reached.pairs() == 0) {
    spdlog::warn("{} has none of this sweep's feasible seeds: nothing to compare", against->other);
    return;
  }
  const ConfidenceInterval d = matched_difference_ci95(against->reached);
  fmt::print(stderr,
             "ballservo: success less that of {}: {:+.2f} % (95 % interval {:+.2f} to {:+.2f} %), {} pairs\n",
             against->other, against->reached.difference() * 100, d.low * 100, d.high * 100,
             against->reached.pairs());
  if (against->other_worlds > 0) {
    spdlog::warn("in {} pairs the seed drew other values in {}: those worlds differ", against->other_worlds,
                 against->other);
  }
}

/// The results of a sweep or of a part, from its records.
struct SweepResults {
  Sweep sweep;
  std::optional<SweepComparison> against;
  nlohmann::ordered_json summary;
  std::map<std::string, std::string> files;
};

SweepResults results_of(const nlohmann::json& description, const std::vector<TrialRecord>& records,
                        const Shard& shard, bool interrupted, const std::optional<Sweep>& other,
                        const std::string& other_name) {
  SweepFiles files = sweep_files(description, records);
  SweepResults results;
  results.sweep = {description, parse_trials(files.trials_csv, "trials.csv"), files.traces_jsonl};
  if (other) results.against = compare_sweeps(results.sweep, *other, other_name);
  const SweepComparison* against = results.against ? &*results.against : nullptr;
  results.summary = sweep_summary_json(results.sweep, shard, interrupted, against);
  results.files["trials.csv"] = std::move(files.trials_csv);
  results.files["traces.jsonl"] = std::move(files.traces_jsonl);
  results.files["summary.json"] = results.summary.dump(2) + "\n";
  results.files[report_json_name] = report_text(sweep_report(results.sweep, against));
  return results;
}

void write(const SweepResults& results, WorkFolder& folder, bool finished,
           const std::filesystem::path& output, bool quiet) {
  WorkResults files = folder.begin_results();
  for (const auto& [name, contents] : results.files) files.write(name, contents);
  draw_page_or_warn(files.path(), output.string(), quiet);
  folder.commit_results(std::move(files), finished);
}

void check(const SweepCommandOptions& options) {
  FaultList faults;
  if (options.scenario.empty()) faults.add("SCENARIO", "nothing", "a scenario file");
  if (options.output.empty()) faults.add("-o", "nothing", "a folder for the results");
  if (options.trials == 0) faults.add("--trials", "nothing", "how many runs");
  faults.collect([&] { parse_shard(options.shard); });
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
  sweep.shard = parse_shard(options.shard);
  sweep.threads = options.common.threads;
  const nlohmann::json description = sweep_description(sweep);
  const std::string gain = description.at("gain_warning");
  if (!gain.empty()) spdlog::warn(gain);
  const std::optional<Sweep> other = read_other(options.against);
  WorkFolder folder(options.output, {description, sweep.shard}, options.resume, options.common.overwrite());
  const bool finished_before = folder.already_finished();
  std::vector<TrialRecord> records;
  if (finished_before) {
    spdlog::info("{} is finished already", options.output.string());
    records = read_sweep_records({description, {{options.output, sweep.shard}}});
  } else {
    std::optional<Progress> bar;
    records = run_sweep(
        sweep, description, folder.journal(), [] { return !interrupt_requested(); },
        [&](long done, long total) {
          if (!bar) bar.emplace("trials", total, options.common.quiet);
          bar->step(done);
        });
  }
  long mine = 0;
  for (long k = 0; k < sweep.trials; ++k) mine += sweep.shard.holds(static_cast<std::size_t>(k)) ? 1 : 0;
  const bool interrupted = static_cast<long>(records.size()) < mine;
  const SweepResults results =
      results_of(description, records, sweep.shard, interrupted, other, options.against.string());
  // A finished folder keeps the comparison it has, unless another is asked for.
  if (!finished_before || other) write(results, folder, !interrupted, options.output, options.common.quiet);
  write_json_results(options.common, nlohmann::json(results.summary));
  say(results.sweep, results.against ? &*results.against : nullptr, options.output, options.common.quiet);
  if (interrupted) {
    fmt::print(stderr, "ballservo: interrupted after {} of {} trials; --resume goes on\n", records.size(),
               mine);
  }
  return interrupted ? exit_interrupted : exit_done;
}

int run_merge(const MergeOptions& options) {
  const MergeableShards shards = read_shards(options.folders);
  const std::optional<Sweep> other = read_other(options.against);
  const std::vector<TrialRecord> records = read_sweep_records(shards);
  WorkFolder folder(options.output, {shards.description, {}}, false, options.common.overwrite());
  const SweepResults results =
      results_of(shards.description, records, {}, false, other, options.against.string());
  write(results, folder, true, options.output, options.common.quiet);
  write_json_results(options.common, nlohmann::json(results.summary));
  say(results.sweep, results.against ? &*results.against : nullptr, options.output, options.common.quiet);
  return exit_done;
}

void add_merge_command(CLI::App& sweep, Action& action) {
  auto options = std::make_shared<MergeOptions>();
  CLI::App* command = sweep.add_subcommand("merge", "Join the parts of a sweep (--shard) into one");
  command->footer(
      "Example:\n"
      "  ballservo sweep merge part_1 part_2 part_3 part_4 -o whole\n"
      "\n"
      "The result is what one run without --shard would have written, byte for byte. Parts of different "
      "sweeps "
      "are\n"
      "refused, missing ones named. A whole sweep may be given alone, to compare it --against another.");
  command->add_option("DIR", options->folders, "Folders of the parts, in any order")->required();
  command->add_option("-o,--output", options->output, "Folder for the results")->required()->type_name("DIR");
  command->add_option("--against", options->against, "Folder of another sweep to compare with, seed by seed")
      ->type_name("DIR");
  add_keys_flag(*command, "scenario", [] { return scenario_keys(); });
  add_common_options(*command, options->common);
  command->callback([options, &action] { action = [options] { return run_merge(*options); }; });
}

}  // namespace

void add_sweep_command(CLI::App& program, Action& action) {
  auto options = std::make_shared<SweepCommandOptions>();
  CLI::App* command = program.add_subcommand("sweep", "Run a scenario many times, a seed each, and count");
  command->footer(
      "Examples:\n"
      "  ballservo sweep data/scenarios/static_ball.yaml -o sweep --trials 300\n"
      "  ballservo sweep data/scenarios/static_ball.yaml -o visp --trials 300 --set law.name=visp --against "
      "sweep\n"
      "\n"
      "Trial k has seed --seed + k. Writes trials.csv (one row a trial), summary.json (rates with 95 % "
      "intervals,\n"
      "failures by cause), report.html, and traces.jsonl (the ways, which the report draws). The results are "
      "the\n"
      "same bytes at any number of threads, however the work was split, killed and resumed:\n"
      "\n"
      "  ballservo sweep S.yaml -o part_2 --trials 3000 --shard 2/4     the second of four parts\n"
      "  ballservo sweep merge part_1 part_2 part_3 part_4 -o whole\n"
      "  ballservo sweep S.yaml -o sweep --trials 3000 --resume         goes on where it was killed\n"
      "\n"
      "Exit: 0 done (whatever was found), 2 bad input, 130 interrupted (what was finished is written; "
      "--resume).");
  command->add_option("SCENARIO", options->scenario, "Scenario (YAML); required")->type_name("SCENARIO");
  command->add_option("-o,--output", options->output, "Folder for the results; required")->type_name("DIR");
  add_integer_option(*command, "--trials", options->trials, 1, max_trials,
                     "How many runs, over all parts; required");
  command->add_option("--shard", options->shard, "Run only part I of N (I from 1)")
      ->type_name("I/N")
      ->capture_default_str();
  command->add_flag("--resume", options->resume, "Go on with what an earlier run left in the folder");
  add_set_option(*command, options->sets);
  add_perception_option(*command, options->perception);
  command->add_option("--against", options->against, "Folder of another sweep to compare with, seed by seed")
      ->type_name("DIR");
  add_keys_flag(*command, "scenario", [] { return scenario_keys(); });
  add_common_options(*command, options->common);
  add_merge_command(*command, action);
  command->callback([options, command, &action] {
    if (!command->get_subcommands().empty()) return;
    action = [options] { return run_sweep_command(*options); };
  });
}

}  // namespace ballservo
