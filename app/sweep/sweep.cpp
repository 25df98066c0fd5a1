#include "app/sweep/sweep.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <sstream>

#include "app/experiment/runner.hpp"
#include "app/scenario/feasibility.hpp"
#include "app/sweep/grid.hpp"
#include "calibration/base/checksum.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/base/system_file.hpp"

namespace ballservo {
namespace {

constexpr long seeds_to_try = 100;
constexpr std::size_t max_trials_bytes = std::size_t{1} << 30, max_traces_bytes = std::size_t{4} << 30;

/// A seed's scenario, or why its world cannot be. Without anything that a seed draws there is nothing that
/// could be otherwise: then the faults are the scenario's own.
std::optional<Scenario> load_trial(const SweepOptions& options, std::uint64_t seed, std::string& why) {
  try {
    return load_scenario(options.scenario, options.sets, seed);
  } catch (const InputError& error) {
    why = to_text(error.faults().front());
    return std::nullopt;
  }
}

/// The scenario of the first seed whose world can be.
Scenario first_scenario(const SweepOptions& options) {
  std::string why;
  for (long k = 0; k < std::min(options.trials, seeds_to_try); ++k) {
    if (auto scenario = load_trial(options, options.first_seed + static_cast<std::uint64_t>(k), why)) {
      if (options.admit) options.admit(*scenario);
      return *std::move(scenario);
    }
  }
  return load_scenario(options.scenario, options.sets, options.first_seed);  // throws its faults
}

std::vector<std::string> drawn_keys(const nlohmann::json& description) {
  return description.at("drawn").get<std::vector<std::string>>();
}

/// A finished trial as the journal and the results keep it: its row of trials.csv, then its line of
/// traces.jsonl, where it has one.
struct TrialRecord {
  std::string row, trace;
};

TrialRecord parse_record(const std::string& text) {
  const std::size_t end = text.rfind("\n{\"seed\":");
  if (end == std::string::npos) return {text, ""};
  return {text.substr(0, end + 1), text.substr(end + 1)};
}

using Records = std::map<std::uint64_t, TrialRecord>;  // by their seeds

Sweep join(const nlohmann::json& description, const Records& records) {
  Sweep sweep{description, {}, trials_csv_header(drawn_keys(description)), ""};
  for (const auto& entry : records) {
    sweep.trials_csv += entry.second.row;
    sweep.traces_jsonl += entry.second.trace;
  }
  sweep.trials = parse_trials(sweep.trials_csv, "trials.csv");
  return sweep;
}

/// Nothing for a run that was cut short.
std::optional<TrialRecord> run_trial(const SweepOptions& options, const nlohmann::json& description,
                                     std::uint64_t seed, const std::shared_ptr<const ColorTable>& colors,
                                     const std::function<bool()>& go_on) {
  Trial trial;
  trial.scenario_hash = description.at("scenario_hash");
  trial.seed = seed;
  for (const std::string& key : drawn_keys(description)) trial.drawn.emplace_back(key, not_known);
  const auto scenario = load_trial(options, seed, trial.why);
  if (scenario) {
    for (auto& [key, value] : trial.drawn)
      for (const auto& [drawn_key, drawn_value] : scenario->drawn)
        if (drawn_key == key) value = drawn_value;
    trial.why = why_infeasible(*scenario);
  }
  trial.feasible = scenario && trial.why.empty();
  if (!trial.feasible) return TrialRecord{trial_row(trial), ""};
  RunOptions run_options;
  run_options.perception = options.perception;
  run_options.colors = colors;
  run_options.go_on = [&go_on](double) { return go_on(); };
  const RunRecord run = run_closed_loop(*scenario, run_options);
  if (run.summary.outcome == Outcome::interrupted) return std::nullopt;
  trial.summary = run.summary;
  trial.why = run.summary.outcome_text;
  if (!run.steps.empty()) {
    trial.last_state = control_state_name(run.steps.back().control.state);
    trial.last_reason = run.steps.back().control.reason;
  }
  return TrialRecord{trial_row(trial), trace_line(*scenario, run) + "\n"};
}

/// Whether a folder's job has all that a sweep's has, as `sweep_description` makes it.
void check_sweep_description(const nlohmann::json& description, const std::filesystem::path& folder) {
  try {
    if (description.at("command") != "sweep")
      throw InputError(folder.string(), "results of another command", "a sweep's folder");
    for (const char* key : {"scenario_hash", "perception", "law", "gain_warning"})
      description.at(key).get<std::string>();
    for (const char* key : {"first_seed", "trials", "distance_m"}) description.at(key).get<double>();
    for (const char* key : {"sets", "drawn"}) description.at(key).get<std::vector<std::string>>();
    description.at("scenario");
    description.at(WorkJob::places_key).at("scenario_file").get<std::string>();
  } catch (const nlohmann::json::exception& error) {
    throw InputError(folder.string(), std::string("a manifest that is not a sweep's: ") + error.what(),
                     "a folder as this version's sweep writes it");
  }
}

}  // namespace

std::vector<std::uint64_t> seeds_of(const SweepOptions& options) {
  std::vector<std::uint64_t> seeds;
  for (long k = 0; k < options.trials; ++k) {
    if (options.shard.holds(static_cast<std::size_t>(k)))
      seeds.push_back(options.first_seed + static_cast<std::uint64_t>(k));
  }
  return seeds;
}

nlohmann::json sweep_description(const SweepOptions& options) {
  const Scenario scenario = first_scenario(options);
  if (options.perception == PerceptionLevel::image && scenario.colors.empty())
    throw InputError(options.scenario.string() + ": colors", "nothing",
                     "a colours file, which perception from images needs");
  nlohmann::json hashes;
  hashes["camera"] = sha256_of_file(scenario.camera.file);
  if (!scenario.colors.empty() && std::filesystem::exists(scenario.colors))
    hashes["colors"] = sha256_of_file(scenario.colors);
  if (!scenario.taught.empty()) hashes["taught"] = sha256_of_file(scenario.taught);
  std::vector<std::string> drawn;
  for (const auto& entry : scenario.drawn) drawn.push_back(entry.first);
  const nlohmann::json document = nlohmann::json::parse(scenario.document_json);
  return {{"command", "sweep"},
          {"program", "ballservo " BALLSERVO_VERSION},
          {WorkJob::places_key, {{"scenario_file", options.scenario.lexically_normal().generic_string()}}},
          {"scenario", document},
          {"scenario_hash", sha256_hex(document.dump() + hashes.dump()).substr(0, 16)},
          {"files_sha256", hashes},
          {"sets", options.sets},
          {"perception", perception_level_name(options.perception)},
          {"first_seed", options.first_seed},
          {"trials", options.trials},
          {"drawn", drawn},
          {"law", scenario.law.name},
          {"distance_m", scenario.target_distance_m},
          {"gain_warning", gain_warning(scenario)}};
}

NoteCheck trials_of(const std::vector<SweepWork>& works) {
  return [works](const std::string& key, const std::string& value) {
    const std::size_t slash = key.find('/');
    const std::string notes = slash == std::string::npos ? "" : key.substr(0, slash + 1);
    const auto work =
        std::find_if(works.begin(), works.end(), [&](const SweepWork& each) { return each.notes == notes; });
    if (work == works.end()) return false;
    try {
      const auto seed = static_cast<std::uint64_t>(parse_integer(key.substr(notes.size())).value_or(-1));
      const std::uint64_t item = seed - work->options.first_seed;
      const TrialRecord record = parse_record(value);
      const std::vector<Trial> read =
          parse_trials(trials_csv_header(drawn_keys(work->description)) + record.row, key);
      return item < static_cast<std::uint64_t>(SweepOptions::max_trials) && work->options.shard.holds(item) &&
             read.size() == 1 && read[0].seed == seed &&
             read[0].scenario_hash == work->description.at("scenario_hash") &&
             trial_row(read[0]) == record.row &&
             (read[0].feasible ? seed_of_trace(record.trace, key) == seed : record.trace.empty());
    } catch (const InputError&) {
      return false;
    }
  };
}

std::vector<Sweep> run_sweeps(const std::vector<SweepWork>& works, Journal& journal,
                              const std::function<bool()>& go_on,
                              const std::function<void(long done, long total)>& progress) {
  struct Task {
    const SweepWork* work;
    std::shared_ptr<const ColorTable> colors;
    std::uint64_t seed;
    std::string note() const { return work->notes + std::to_string(seed); }
  };
  std::vector<Task> all, missing;
  for (const SweepWork& work : works) {
    const PerceptionLevel level = work.options.perception;
    const auto colors =
        level == PerceptionLevel::image ? colors_of(first_scenario(work.options), level) : nullptr;
    for (const std::uint64_t seed : seeds_of(work.options)) all.push_back({&work, colors, seed});
  }
  std::copy_if(all.begin(), all.end(), std::back_inserter(missing),
               [&](const Task& task) { return !journal.has(task.note()); });
  std::mutex mutex;
  const long total = static_cast<long>(all.size());
  long done = total - static_cast<long>(missing.size());
  const int threads = works.front().options.threads;
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute([&] {
    // Trials in their order, one at a time to whoever is free: they last differently long.
    std::atomic<std::size_t> next{0};
    tbb::parallel_for(0, tbb::this_task_arena::max_concurrency(), [&](int) {
      for (std::size_t k = next++; k < missing.size() && go_on(); k = next++) {
        const Task& task = missing[k];
        const auto record =
            run_trial(task.work->options, task.work->description, task.seed, task.colors, go_on);
        if (!record) return;
        const std::lock_guard<std::mutex> lock(mutex);
        journal.add(task.note(), record->row + record->trace);
        progress(++done, total);
      }
    });
  });
  std::map<const SweepWork*, Records> records;
  for (const Task& task : all) {
    if (const auto text = journal.find(task.note())) records[task.work][task.seed] = parse_record(*text);
  }
  std::vector<Sweep> sweeps;
  for (const SweepWork& work : works) sweeps.push_back(join(work.description, records[&work]));
  return sweeps;
}

namespace {

/// By their scenarios' hashes.
std::map<std::string, Records> read_records(const MergeableShards& shards,
                                            const std::vector<nlohmann::json>& descriptions) {
  for (const nlohmann::json& description : descriptions)
    check_sweep_description(description, shards.folders.front());
  std::map<std::string, Records> records;
  for (const std::filesystem::path& folder : shards.folders) {
    const std::string name = (folder / "trials.csv").string();
    for (const Trial& trial : parse_trials(read_file_bytes(name, max_trials_bytes), name)) {
      if (!records[trial.scenario_hash].insert({trial.seed, {trial_row(trial), ""}}).second)
        throw InputError(name, "seed " + std::to_string(trial.seed) + " twice", "each seed once");
    }
    if (is_grid(shards.description)) continue;  // which keeps no ways
    const std::string traces = (folder / "traces.jsonl").string();
    std::istringstream lines(read_file_bytes(traces, max_traces_bytes));
    Records& own = records[descriptions.front().at("scenario_hash")];
    for (std::string line; std::getline(lines, line);) {
      const auto record = own.find(seed_of_trace(line, traces));
      if (record != own.end()) record->second.trace = line + "\n";
    }
  }
  return records;
}

}  // namespace

void note_results(const std::filesystem::path& folder, const std::vector<SweepWork>& works,
                  Journal& journal) {
  const nlohmann::json description = read_finished_job(folder);
  auto records = read_records({description, {folder}}, cell_descriptions(description));
  for (const SweepWork& work : works)
    for (const auto& [seed, record] : records[work.description.at("scenario_hash")])
      journal.add(work.notes + std::to_string(seed), record.row + record.trace);
}

std::vector<Sweep> read_sweeps(const MergeableShards& shards) {
  const std::vector<nlohmann::json> descriptions = cell_descriptions(shards.description);
  std::map<std::string, Records> records = read_records(shards, descriptions);
  std::vector<Sweep> sweeps;
  for (const nlohmann::json& description : descriptions)
    sweeps.push_back(join(description, records[description.at("scenario_hash")]));
  return sweeps;
}

std::vector<Sweep> read_sweeps(const std::filesystem::path& folder) {
  return read_sweeps(MergeableShards{read_finished_job(folder), {folder}});
}

}  // namespace ballservo
