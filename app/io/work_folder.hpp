// The folder of a job, or of one of its parts, that can be killed, resumed, split over machines and put
// together again.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/io/journal.hpp"
#include "calibration/base/checksum.hpp"
#include "calibration/base/output.hpp"

namespace ballservo {

/// The `index`-th (from 1) of `count` parts of a list of items. Items are dealt out like cards, so that parts
/// of a list whose cost changes slowly along it cost about the same.
struct Shard {
  int index = 1, count = 1;

  /// Whether item `item` (from 0) belongs to this part. Each item belongs to exactly one of the parts.
  bool holds(std::size_t item) const {
    return item % static_cast<std::size_t>(count) == static_cast<std::size_t>(index - 1);
  }
  bool is_whole() const { return count == 1; }
  std::string to_text() const;  ///< "2/4"
};

inline constexpr int max_shards = 100000;

/// Reads "I/N" (1 <= I <= N <= max_shards); InputError about `place` otherwise.
Shard parse_shard(const std::string& text, const std::string& place = "--shard");

/// What a job is: everything that its results depend on, hashes of its inputs included, and nothing else (no
/// thread counts). Two jobs are the same if and only if their descriptions are, but for the key `places`:
/// where inputs were found, which may be elsewhere on another machine.
struct WorkJob {
  static constexpr const char* places_key = "places";
  static constexpr const char* size_key = "trials";  ///< a job may be resumed with more of them
  nlohmann::json description;
  Shard shard;

  std::string sha256() const;  ///< of description, but for its places and size, and shard
};

/// A folder with, while the job is under way, `unfinished.journal`, and at the end its results and
/// `manifest.json`: {"job": description, "shard": "I/N", "sha256": {NAME: hash of that result}}.
class WorkFolder {
 public:
  static constexpr const char* journal_name = "unfinished.journal";
  static constexpr const char* manifest_name = "manifest.json";

  /// Makes the folder if need be. A folder that is not empty is refused, except: with `resume`, this job's
  /// own, or a smaller one's (its journal is read; or it is finished); with Overwrite::allow (and no
  /// `resume`) the job begins anew in it. `is_note` knows the job's notes. Throws InputError as OutputFolder
  /// and Journal do.
  WorkFolder(std::filesystem::path target, WorkJob job, bool resume, Overwrite overwrite, NoteCheck is_note);

  /// The same job has been here before and left its results: there is nothing to do, but they may be written
  /// anew.
  bool already_finished() const { return journal_ == nullptr; }

  /// A smaller job of the kind has left its results here: what they hold need not be done again.
  bool has_grown() const { return has_grown_; }

  /// What is done so far; not to be called where the job is already finished.
  Journal& journal() { return *journal_; }

  /// Adds to a result. None is there before `commit` (see OutputFolder).
  void write(const std::string& name, std::string_view piece);
  /// The same of a result that differs each time (wall-clock figures): the manifest leaves it out.
  void write_varying(const std::string& name, std::string_view piece);

  /// Where the results lie until then; to be asked after the first is written.
  const std::filesystem::path& staging() const { return results_->path(); }

  /// Puts the results in the place of older ones of this job; but a finished job's stay until this one is.
  void commit_unfinished();
  /// The same with the manifest; the journal goes, or stays as `keep_journal_as`.
  void commit_finished(const std::string& keep_journal_as = "");

 private:
  void commit_results();

  std::filesystem::path target_;
  WorkJob job_;
  bool replaces_results_ = false;  // of a finished job
  bool has_grown_ = false;
  std::unique_ptr<Journal> journal_;
  std::optional<OutputFolder> results_;
  std::map<std::string, Sha256> hashes_;
};

/// The parts of one job, put together.
struct MergeableShards {
  nlohmann::json description;
  std::vector<std::filesystem::path> folders;  ///< of parts 1 to N
};

/// Reads the folders' manifests. Throws InputError with every fault: no manifest (no result of this program,
/// or an unfinished one), a result that is not as it was written, parts of different jobs (and in which key
/// they differ), a part given twice, missing parts by their numbers.
MergeableShards read_shards(const std::vector<std::filesystem::path>& folders);

/// The description of the job whose results the folder holds, be it the whole or a part. Throws InputError
/// for a folder without a manifest.
nlohmann::json read_finished_job(const std::filesystem::path& folder);

}  // namespace ballservo
