#include "app/io/work_folder.hpp"

#include <fmt/format.h>

#include <set>

#include "app/io/interrupt.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/base/system_file.hpp"

namespace fs = std::filesystem;

namespace ballservo {

std::string Shard::to_text() const { return std::to_string(index) + "/" + std::to_string(count); }

Shard parse_shard(const std::string& text, const std::string& place) {
  const std::size_t slash = text.find('/');
  if (slash != std::string::npos) {
    const auto index = parse_integer(text.substr(0, slash)), count = parse_integer(text.substr(slash + 1));
    if (index && count && *index >= 1 && *index <= *count && *count <= max_shards) {
      return {static_cast<int>(*index), static_cast<int>(*count)};
    }
  }
  throw InputError(place, text,
                   "I/N with I from 1 to N, such as 2/4 for the second of four parts (N up to " +
                       std::to_string(max_shards) + ")");
}

namespace {

constexpr std::size_t max_manifest_bytes = 16u << 20;

/// A manifest as far as it can be believed.
struct Manifest {
  nlohmann::json description;
  Shard shard;
  std::map<std::string, std::string> hashes;
};

std::optional<Manifest> read_manifest(const fs::path& folder) {
  const fs::path file = folder / WorkFolder::manifest_name;
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return std::nullopt;
  // Deeper than any of ours it is not read, so that no file can exhaust the stack.
  const auto shallow = [](int depth, nlohmann::json::parse_event_t, nlohmann::json&) { return depth < 32; };
  Manifest manifest;
  try {
    const auto parsed = nlohmann::json::parse(read_file_bytes(file, max_manifest_bytes), shallow);
    manifest.description = parsed.at("job").get<nlohmann::json::object_t>();
    manifest.shard = parse_shard(parsed.at("shard").get<std::string>(), file.string() + ": shard");
    parsed.at("sha256").get_to(manifest.hashes);
  } catch (const nlohmann::json::exception&) {
    throw InputError(file.string(), "no manifest of a job", "that of a folder which sweep or compare wrote");
  }
  for (const auto& entry : manifest.hashes) {
    const fs::path name = fs::path(entry.first).lexically_normal();
    if (name.is_absolute() || name.empty() || *name.begin() == "..")
      throw InputError(file.string(), "a result outside the folder: " + entry.first,
                       "the file as it was written");
  }
  return manifest;
}

InputError no_results(const fs::path& folder) {
  return {folder.string(), "no results of a job", "a folder that a finished job has written"};
}

nlohmann::json without_places(nlohmann::json description) {
  description.erase(WorkJob::places_key);
  return description;
}

/// Of a grid, of each of its cells.
nlohmann::json without_size(nlohmann::json description) {
  description.erase(WorkJob::size_key);
  if (const auto cells = description.find("cells"); cells != description.end())
    for (nlohmann::json& cell : *cells)
      if (cell.is_object()) cell.erase(WorkJob::size_key);
  return description;
}

/// The trials of a job, of a grid's those of a cell; 0: it has none.
double trial_count(const nlohmann::json& description) {
  const auto cells = description.find("cells");
  const nlohmann::json& of = cells != description.end() && !cells->empty() ? cells->front() : description;
  const auto size = of.find(WorkJob::size_key);
  return size != of.end() && size->is_number() ? size->get<double>() : 0;
}

bool same_job(const nlohmann::json& a, const nlohmann::json& b) {
  return without_places(a) == without_places(b);
}

/// The keys in which two jobs differ, as "first_seed, trials".
std::string difference(const nlohmann::json& of_a, const nlohmann::json& of_b) {
  const nlohmann::json a = without_places(of_a), b = without_places(of_b);
  std::set<std::string> keys;
  for (const nlohmann::json& one : {a, b})
    for (const auto& entry : one.items())
      if (a.value(entry.key(), nlohmann::json()) != b.value(entry.key(), nlohmann::json()))
        keys.insert(entry.key());
  return fmt::format("{}", fmt::join(keys, ", "));
}

void check_results(const fs::path& folder, const Manifest& manifest, FaultList& faults) {
  for (const auto& [name, expected] : manifest.hashes) {
    faults.collect([&, file = folder / name, hash = expected] {
      if (sha256_of_file(file) != hash)
        throw InputError(file.string(), "not what the job wrote (its checksum differs)",
                         "the file as it was written");
    });
  }
}

std::string missing_parts(const std::map<int, fs::path>& parts, int count) {
  std::string missing;
  int named = 0;
  for (int index = 1; index <= count; ++index) {
    if (parts.count(index) > 0) continue;
    if (++named > 20) return missing + ", ...";
    missing += (missing.empty() ? "" : ", ") + Shard{index, count}.to_text();
  }
  return missing;
}

}  // namespace

std::string WorkJob::sha256() const {
  return sha256_hex(
      nlohmann::json{{"job", without_size(without_places(description))}, {"shard", shard.to_text()}}.dump());
}

WorkFolder::WorkFolder(fs::path target, WorkJob job, bool resume, Overwrite overwrite, NoteCheck is_note)
    : target_(std::move(target)), job_(std::move(job)) {
  const fs::path journal_file = target_ / journal_name;
  std::error_code error;
  const bool begun = fs::exists(fs::symlink_status(journal_file, error));
  if (resume) {
    const auto manifest = read_manifest(target_);
    const bool same_shard = manifest && manifest->shard.to_text() == job_.shard.to_text();
    if (!begun && same_shard && same_job(manifest->description, job_.description)) return;
    has_grown_ = same_shard &&
                 same_job(without_size(manifest->description), without_size(job_.description)) &&
                 trial_count(manifest->description) < trial_count(job_.description);
    if (manifest && !begun && !has_grown_) {
      throw InputError(target_.string(),
                       "the results of another job (it differs in " +
                           (same_shard ? difference(manifest->description, job_.description) : "--shard") +
                           ")",
                       "the inputs and options of that job, or another folder");
    }
  }
  if (begun && !resume && overwrite == Overwrite::refuse) {
    throw InputError(target_.string(), "an unfinished job",
                     "--resume to go on with it, --force to begin anew, or another folder");
  }
  // Checks that the folder may be written, and makes it appear.
  OutputFolder(target_, begun || has_grown_ ? Overwrite::allow : overwrite).commit();
  if (!resume) fs::remove(journal_file, error);
  replaces_results_ = fs::exists(target_ / manifest_name, error);
  journal_ = std::make_unique<Journal>(journal_file, job_.sha256(), std::move(is_note));
}

void WorkFolder::write(const std::string& name, std::string_view piece) {
  hashes_[name].add(piece);
  write_varying(name, piece);
}

void WorkFolder::write_varying(const std::string& name, std::string_view piece) {
  if (!results_) results_.emplace(target_, Overwrite::allow);
  results_->append(name, piece);
}

void WorkFolder::commit_unfinished() {
  if (!replaces_results_) commit_results();
  results_.reset();
}

void WorkFolder::commit_results() {
  const auto undisturbed = hold_interrupt_deadline();
  if (results_) results_->commit();
  results_.reset();
  hashes_.clear();
}

void WorkFolder::commit_finished(const std::string& keep_journal_as) {
  nlohmann::json hashes = nlohmann::json::object();
  for (auto& [name, hash] : hashes_) hashes[name] = hash.hex();
  const nlohmann::json manifest = {
      {"job", job_.description}, {"shard", job_.shard.to_text()}, {"sha256", hashes}};
  write_varying(manifest_name, manifest.dump(2) + "\n");
  commit_results();
  const fs::path journal = target_ / journal_name;
  std::error_code ignored;
  if (keep_journal_as.empty())
    fs::remove(journal, ignored);
  else
    rename_path(journal, target_ / keep_journal_as, true);
  journal_.reset();
}

MergeableShards read_shards(const std::vector<fs::path>& folders) {
  FaultList faults;
  std::optional<Manifest> first;
  fs::path first_folder;
  std::map<int, fs::path> parts;
  const auto add = [&](const fs::path& folder) {
    const auto manifest = read_manifest(folder);
    if (fs::exists(folder / WorkFolder::journal_name))
      throw InputError(folder.string(), "an unfinished job",
                       "a finished one: run its command again with --resume");
    if (!manifest) throw no_results(folder);
    if (!first) first = manifest, first_folder = folder;
    if (!same_job(manifest->description, first->description))
      throw InputError(folder.string(),
                       "a part of another job than " + first_folder.string() + " (they differ in " +
                           difference(first->description, manifest->description) + ")",
                       "parts of one job");
    const std::string part = "part " + manifest->shard.to_text();
    if (manifest->shard.count != first->shard.count)
      throw InputError(
          folder.string(), part,
          "one of " + std::to_string(first->shard.count) + " parts, like " + first_folder.string());
    const auto [twin, is_new] = parts.emplace(manifest->shard.index, folder);
    if (!is_new)
      throw InputError(folder.string(), part + ", as " + twin->second.string() + " is", "each part once");
    check_results(folder, *manifest, faults);
  };
  for (const fs::path& folder : folders) faults.collect([&] { add(folder); });
  if (folders.empty()) faults.add("merge", "no folders", "the folders of all parts of a job");
  const std::string missing = first ? missing_parts(parts, first->shard.count) : "";
  if (!missing.empty()) faults.add("merge", "parts " + missing + " missing", "all parts of the job");
  faults.throw_if_any();
  MergeableShards merge{first->description, {}};
  for (const auto& entry : parts) merge.folders.push_back(entry.second);
  return merge;
}

nlohmann::json read_finished_job(const fs::path& folder) {
  const auto manifest = read_manifest(folder);
  if (!manifest) throw no_results(folder);
  return manifest->description;
}

}  // namespace ballservo
