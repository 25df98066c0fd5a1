// The folder of a job that can be killed, resumed, split over machines and put together again.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/io/shard.hpp"
#include "app/io/work_journal.hpp"
#include "calibration/base/checksum.hpp"
#include "calibration/base/output.hpp"

namespace ballservo {

/// What a job is: everything that its results depend on, hashes of its inputs included, and nothing else (no
/// thread counts). Two jobs are the same if and only if their descriptions are, but for the key `places`:
/// where inputs were found, which may be elsewhere on another machine.
struct WorkJob {
  static constexpr const char* places_key = "places";
  nlohmann::json description;
  Shard shard;

  std::string sha256() const;  ///< of description, but for its places, and shard
};

/// A job's results on their way: none is there before all are (see OutputFolder).
class WorkResults {
 public:
  void write(const std::string& name, std::string_view contents);
  /// Adds to a result that is too long to be held whole.
  void append(const std::string& name, std::string_view piece);
  /// Results that are not the same each time (wall-clock figures), left out of the manifest.
  void write_untracked(const std::string& name, std::string_view contents);
  void append_untracked(const std::string& name, std::string_view piece);
  /// Where they lie until then.
  const std::filesystem::path& path() const { return folder_.path(); }

 private:
  friend class WorkFolder;
  explicit WorkResults(const std::filesystem::path& target) : folder_(target, Overwrite::allow) {}

  OutputFolder folder_;
  std::map<std::string, Sha256> hashes_;
};

/// A folder with, while the job is under way, `unfinished.journal`, and at the end its results and
/// `manifest.json`: {"job": description, "shard": "I/N", "sha256": {NAME: hash of that result}}.
class WorkFolder {
 public:
  static constexpr const char* journal_name = "unfinished.journal";
  static constexpr const char* manifest_name = "manifest.json";

  /// Makes the folder if need be. A folder that is not empty is refused, except: with `resume`, this job's
  /// own (its journal is read; or it is finished); with Overwrite::allow (and no `resume`) the job begins
  /// anew in it. Throws InputError as OutputFolder and WorkJournal do.
  WorkFolder(std::filesystem::path target, WorkJob job, bool resume, Overwrite overwrite);

  /// The same job has been here before and left its results: there is nothing to do, but they may be written
  /// anew.
  bool already_finished() const { return journal_ == nullptr; }

  /// What is done so far; not to be called where the job is already finished.
  WorkJournal& journal() { return *journal_; }

  /// Results that are written piece by piece, then put in the place of older ones of this job by
  /// `commit_results`.
  WorkResults begin_results() const { return WorkResults(target_); }
  /// `finished` also writes the manifest and removes the journal; without it (interrupted) the folder can be
  /// resumed.
  void commit_results(WorkResults&& results, bool finished);

 private:
  std::filesystem::path target_;
  WorkJob job_;
  std::unique_ptr<WorkJournal> journal_;
};

/// One finished part of a job.
struct FinishedShard {
  std::filesystem::path folder;
  Shard shard;
};

/// The parts of one job, put together.
struct MergeableShards {
  nlohmann::json description;
  std::vector<FinishedShard> shards;  ///< 1 to N, each once
};

/// Reads the folders' manifests. Throws InputError with every fault: no manifest (no result of this program,
/// or an unfinished one), a result that is not as it was written, parts of different jobs (and in which key
/// they differ), a part given twice, missing parts by their numbers.
MergeableShards read_shards(const std::vector<std::filesystem::path>& folders);

/// The description of the job whose results the folder holds, be it the whole or a part. Throws InputError
/// for a folder without a manifest.
nlohmann::json read_finished_job(const std::filesystem::path& folder);

}  // namespace ballservo
