#include "app/io/work_folder.hpp"

#include <algorithm>
#include <optional>

#include "calibration/base/fault.hpp"
#include "calibration/base/system_file.hpp"

namespace fs = std::filesystem;

namespace ballservo {
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
  const nlohmann::json json =
      nlohmann::json::parse(read_file_bytes(file, max_manifest_bytes), shallow, false);
  const auto damaged = [&file]() -> InputError {
    return {file.string(), "no manifest of a job", "the file as it was written"};
  };
  if (!json.is_object() || !json.contains("job") || !json.contains("shard") || !json.contains("sha256") ||
      !json["job"].is_object() || !json["shard"].is_string() || !json["sha256"].is_object()) {
    throw damaged();
  }
  Manifest manifest;
  manifest.description = json["job"];
  manifest.shard = parse_shard(json["shard"].get<std::string>(), file.string() + ": shard");
  for (const auto& [name, hash] : json["sha256"].items()) {
    const fs::path relative = fs::path(name).lexically_normal();
    if (!hash.is_string() || relative.is_absolute() || relative.empty() || *relative.begin() == "..") {
      throw damaged();
    }
    manifest.hashes[name] = hash.get<std::string>();
  }
  return manifest;
}

nlohmann::json without_places(nlohmann::json description) {
  description.erase(WorkJob::places_key);
  return description;
}

bool same_job(const nlohmann::json& a, const nlohmann::json& b) {
  return without_places(a) == without_places(b);
}

/// The first key in which two jobs differ, as "scenario_sha256".
std::string difference(const nlohmann::json& of_a, const nlohmann::json& of_b) {
  const nlohmann::json a = without_places(of_a), b = without_places(of_b);
  for (const auto& [key, value] : a.items()) {
    if (!b.contains(key) || b[key] != value) return key;
  }
  for (const auto& [key, value] : b.items()) {
    if (!a.contains(key)) return key;
  }
  return "nothing";
}

void check_results(const FinishedShard& shard, const Manifest& manifest, FaultList& faults) {
  for (const auto& [name, hash] : manifest.hashes) {
    faults.collect([&, result = name, expected = hash] {
      const fs::path file = shard.folder / result;
      if (sha256_of_file(file) != expected) {
        throw InputError(file.string(), "not what the job wrote (its checksum differs)",
                         "the file as it was written");
      }
    });
  }
}

std::string missing_parts(const std::vector<FinishedShard>& shards, int count) {
  std::string missing;
  int named = 0;
  auto next = shards.begin();
  for (int index = 1; index <= count; ++index) {
    while (next != shards.end() && next->shard.index < index) ++next;
    if (next != shards.end() && next->shard.index == index) continue;
    if (++named > 20) return missing + ", ...";
    missing += (missing.empty() ? "" : ", ") + Shard{index, count}.to_text();
  }
  return missing;
}

}  // namespace

std::string WorkJob::sha256() const {
  return sha256_hex(nlohmann::json{{"job", without_places(description)}, {"shard", shard.to_text()}}.dump());
}

WorkFolder::WorkFolder(fs::path target, WorkJob job, bool resume, Overwrite overwrite)
    : target_(std::move(target)), job_(std::move(job)) {
  const fs::path journal_file = target_ / journal_name;
  std::error_code error;
  const bool begun = fs::exists(fs::symlink_status(journal_file, error));
  if (resume && !begun) {
    const auto manifest = read_manifest(target_);
    const bool same_shard = manifest && manifest->shard.to_text() == job_.shard.to_text();
    if (same_shard && same_job(manifest->description, job_.description)) return;
    if (manifest) {
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
  OutputFolder folder(target_, begun ? Overwrite::allow : overwrite);
  folder.commit();
  if (!resume) {
    fs::remove(journal_file, error);
    fs::remove(target_ / manifest_name, error);
  }
  journal_ = std::make_unique<WorkJournal>(journal_file, job_.sha256());
}

void WorkResults::write(const std::string& name, std::string_view contents) {
  hashes_[name].add(contents);
  folder_.write(name, contents);
}

void WorkResults::append(const std::string& name, std::string_view piece) {
  hashes_[name].add(piece);
  folder_.append(name, piece);
}

void WorkResults::write_untracked(const std::string& name, std::string_view contents) {
  folder_.write(name, contents);
}

void WorkResults::append_untracked(const std::string& name, std::string_view piece) {
  folder_.append(name, piece);
}

void WorkFolder::commit_results(WorkResults&& results, bool finished) {
  if (finished) {
    nlohmann::json hashes = nlohmann::json::object();
    for (auto& [name, hash] : results.hashes_) hashes[name] = hash.hex();
    const nlohmann::json manifest = {
        {"job", job_.description}, {"shard", job_.shard.to_text()}, {"sha256", hashes}};
    results.folder_.write(manifest_name, manifest.dump(2) + "\n");
  }
  results.folder_.commit();
  if (finished && journal_) journal_->remove();
}

MergeableShards read_shards(const std::vector<fs::path>& folders) {
  FaultList faults;
  MergeableShards merge;
  std::optional<Manifest> first;
  fs::path first_folder;
  for (const fs::path& folder : folders) {
    faults.collect([&] {
      const auto manifest = read_manifest(folder);
      if (!manifest || fs::exists(folder / WorkFolder::journal_name)) {
        const bool begun = fs::exists(folder / WorkFolder::journal_name);
        throw InputError(folder.string(), begun ? "an unfinished job" : "no results of a job",
                         begun ? "a finished one: run its command again with --resume"
                               : "a folder that a finished job has written");
      }
      if (!first) {
        first = manifest;
        first_folder = folder;
      }
      if (!same_job(manifest->description, first->description)) {
        throw InputError(folder.string(),
                         "a part of another job than " + first_folder.string() + " (they differ in " +
                             difference(first->description, manifest->description) + ")",
                         "parts of one job");
      }
      if (manifest->shard.count != first->shard.count) {
        throw InputError(
            folder.string(), "part " + manifest->shard.to_text(),
            "one of " + std::to_string(first->shard.count) + " parts, like " + first_folder.string());
      }
      const auto twin = std::find_if(merge.shards.begin(), merge.shards.end(), [&](const auto& shard) {
        return shard.shard.index == manifest->shard.index;
      });
      if (twin != merge.shards.end()) {
        throw InputError(folder.string(),
                         "part " + manifest->shard.to_text() + ", as " + twin->folder.string() + " is",
                         "each part once");
      }
      merge.shards.push_back({folder, manifest->shard});
      check_results(merge.shards.back(), *manifest, faults);
    });
  }
  std::sort(merge.shards.begin(), merge.shards.end(),
            [](const auto& a, const auto& b) { return a.shard.index < b.shard.index; });
  if (first) {
    const std::string missing = missing_parts(merge.shards, first->shard.count);
    if (!missing.empty()) faults.add("merge", "parts " + missing + " missing", "all parts of the job");
    merge.description = first->description;
  } else if (faults.empty()) {
    faults.add("merge", "no folders", "the folders of all parts of a job");
  }
  faults.throw_if_any();
  return merge;
}

nlohmann::json read_finished_job(const fs::path& folder) {
  const auto manifest = read_manifest(folder);
  if (!manifest) {
    throw InputError(folder.string(), "no results of a job", "a folder that a finished job has written");
  }
  return manifest->description;
}

}  // namespace ballservo
