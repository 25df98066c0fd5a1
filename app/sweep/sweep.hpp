// Many runs of one scenario, one a seed, on all cores.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/experiment/simulated_perception.hpp"
#include "app/io/work_folder.hpp"
#include "app/sweep/trial.hpp"

namespace ballservo {

struct SweepOptions {
  std::filesystem::path scenario;
  std::vector<std::string> sets;  ///< "key.path=value" each
  PerceptionLevel perception = PerceptionLevel::geometric;
  std::uint64_t first_seed = 0;
  static constexpr int max_trials = 1000000;
  long trials = 0;  ///< over all shards; trial k has seed first_seed + k
  Shard shard;
  int threads = 0;                             ///< 0: as many as the machine has
  std::function<void(const Scenario&)> admit;  ///< throws InputError for a scenario that may not run
};

/// The shard's own.
std::vector<std::uint64_t> seeds_of(const SweepOptions& options);

/// The job that these options are: the scenario as it stands after `sets`, the hashes of its files, seeds,
/// level of perception; not the shard, not the threads. Throws InputError with the scenario's faults (of the
/// first seed, where none of the first hundred can be).
nlohmann::json sweep_description(const SweepOptions& options);

/// A sweep or a part of one, as its folder holds it.
struct Sweep {
  nlohmann::json description;
  std::vector<Trial> trials;  ///< in order of their seeds
  std::string trials_csv, traces_jsonl;
};

/// A sweep to be run: of a grid of them, one cell.
struct SweepWork {
  SweepOptions options;
  nlohmann::json description;
  std::string notes;  ///< what its notes' keys begin with; empty for a sweep alone
};

/// Whether a note of a journal is a trial of the shard's, be the sweep as long as it may.
NoteCheck trials_of(const std::vector<SweepWork>& works);

/// Runs the shard's trials that the journal does not hold yet and notes them there. Returns all of the
/// shard's that are finished, a sweep for each work: the same bytes at any number of threads. `go_on` is
/// asked at each control step, from any thread; once it says false, what is under way is dropped. `progress`
/// is told how many trials are done, from one thread at a time.
std::vector<Sweep> run_sweeps(const std::vector<SweepWork>& works, Journal& journal,
                              const std::function<bool()>& go_on,
                              const std::function<void(long done, long total)>& progress);

/// Notes the trials of a finished folder, which is a smaller job's.
void note_results(const std::filesystem::path& folder, const std::vector<SweepWork>& works, Journal& journal);

/// Joins the results of finished folders, the parts of one job: a sweep, or the cells of a grid. Throws
/// InputError for what does not fit together or was not written by a sweep.
std::vector<Sweep> read_sweeps(const MergeableShards& shards);
std::vector<Sweep> read_sweeps(const std::filesystem::path& folder);

}  // namespace ballservo
