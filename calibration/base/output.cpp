#include "calibration/base/output.hpp"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <functional>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/base/system_file.hpp"

namespace fs = std::filesystem;

namespace ballservo {
namespace {

/// How the hidden names for something unfinished begin, with room for the longest names a file system takes;
/// the process' number follows.
std::string staging_prefix(const fs::path& target) {
  return "." + target.stem().string().substr(0, 100) + ".partial-";
}

/// Makes something new in `place` for what is to become `target`: the first name for which `make` succeeds.
template <class Make>
fs::path new_staging(const fs::path& place, const fs::path& target, const std::string& extension, Make make) {
  const std::string start = staging_prefix(target) + std::to_string(::getpid()) + "-";
  for (int attempt = 0;; ++attempt) {
    fs::path name = place / (start + std::to_string(attempt) + extension.substr(0, 100));
    if (make(name, target.string())) return name;
  }
}

bool has_ended(pid_t process) { return ::kill(process, 0) != 0 && errno == ESRCH; }

/// "out/" and "out/." name the folder "out", however it is spelt.
fs::path without_trailing_separator(const fs::path& path) {
  fs::path plain = path.lexically_normal();
  if (!plain.has_filename() && plain.has_relative_path()) plain = plain.parent_path();
  return plain;
}

fs::path parent_folder(const fs::path& target) {
  return target.has_parent_path() ? target.parent_path() : fs::path(".");
}

/// What a link points at in the end, whether it is there or not.
fs::path behind_links(fs::path target) {
  std::error_code error;
  for (int links = 0; links < 40 && fs::is_symlink(target, error); ++links)
    target = parent_folder(target) / fs::read_symlink(target, error);
  return target;
}

void require_folder_of(const fs::path& target) {
  std::error_code error;
  if (target.empty()) throw InputError("output", "an empty name", "the name of a file or folder to write");
  if (!fs::is_directory(parent_folder(target), error)) {
    throw InputError(target.string(), "no folder " + parent_folder(target).string(),
                     "an output in a folder that exists");
  }
}

/// Files below `folder`, relative to it, with the folders that hold them first.
std::vector<fs::path> entries_below(const fs::path& folder) {
  std::vector<fs::path> entries;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    entries.push_back(entry.path().lexically_relative(folder));
  }
  return entries;
}

/// A summary says that the files beside it are one run's.
bool is_summary(const fs::path& entry) { return !entry.has_parent_path() && entry.extension() == ".json"; }

/// Moves what `staging` holds into `target`; nothing is moved if any name is taken by something of another
/// kind. Summaries go first and come last: a folder in which two runs are mixed, since the process was killed
/// here, has none.
void merge_folder(const fs::path& staging, const fs::path& target) {
  std::vector<fs::path> entries = entries_below(staging);
  const auto summaries = std::stable_partition(entries.begin(), entries.end(), std::not_fn(is_summary));
  FaultList faults;
  for (const fs::path& entry : entries) {
    std::error_code ignored;
    const fs::file_status there = fs::status(target / entry, ignored);
    const bool want_folder = fs::is_directory(staging / entry);
    if (fs::exists(there) && fs::is_directory(there) != want_folder) {
      faults.add((target / entry).string(), want_folder ? "a file" : "a folder",
                 want_folder ? "a folder to write into, or nothing" : "a file to replace, or nothing");
    } else if (!want_folder) {
      flush_to_disk(staging / entry, (target / entry).string());
    }
  }
  faults.throw_if_any();
  for (auto summary = summaries; summary != entries.end(); ++summary) fs::remove(target / *summary);
  for (const fs::path& entry : entries) {
    if (fs::is_directory(staging / entry)) {
      make_new_folder(target / entry, (target / entry).string());
    } else {
      rename_path(staging / entry, target / entry, true);
    }
  }
}

}  // namespace

OutputFile::OutputFile(fs::path target, Overwrite overwrite)
    : target_(std::move(target)), overwrite_(overwrite) {
  target_ = behind_links(target_);
  require_folder_of(target_);
  std::error_code error;
  const fs::file_status status = fs::status(target_, error);
  if (fs::is_directory(status)) throw InputError(target_.string(), "a folder", "the name of a file to write");
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw InputError(target_.string(), "something that is no regular file", "the name of a file to write");
  }
  if (fs::exists(status) && overwrite == Overwrite::refuse) {
    throw InputError(target_.string(), "an existing file", "a new name, or --force to replace it");
  }
  staging_ = new_staging(parent_folder(target_), target_, target_.extension().string(), make_new_file);
}

OutputFile::~OutputFile() {
  std::error_code ignored;
  if (!staging_.empty()) fs::remove(staging_, ignored);
}

void OutputFile::write(std::string_view contents) { write_bytes(staging_, contents, target_.string()); }

void OutputFile::commit() {
  flush_to_disk(staging_, target_.string());
  rename_path(staging_, target_, overwrite_ == Overwrite::allow);
  staging_.clear();
  flush_to_disk(parent_folder(target_), target_.string());
}

void write_file(const fs::path& target, std::string_view contents, Overwrite overwrite) {
  OutputFile file(target, overwrite);
  file.write(contents);
  file.commit();
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "ballservo_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr)
    throw InputError(name, "no temporary folder can be made there", "a writable folder (TMPDIR)");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

fs::path unused_path(const fs::path& name) {
  std::error_code ignored;
  for (int number = 2;; ++number) {
    const fs::path other = name.string() + "_" + std::to_string(number);
    if (!fs::exists(fs::symlink_status(other, ignored))) return other;
  }
}

void remove_unfinished(const fs::path& target, Unfinished whose) {
  const fs::path plain = without_trailing_separator(target);
  const std::string prefix = staging_prefix(plain);
  for (const fs::path& place : {parent_folder(plain), plain}) {
    std::vector<fs::path> found;
    std::error_code error;
    for (fs::directory_iterator entry(place, error), end; !error && entry != end; entry.increment(error)) {
      const std::string name = entry->path().filename().string();
      if (name.compare(0, prefix.size(), prefix) != 0) continue;
      const auto process =
          parse_integer(name.substr(prefix.size(), name.find('-', prefix.size()) - prefix.size()));
      if (!process || *process <= 0 || *process > std::numeric_limits<pid_t>::max()) continue;
      const auto number = static_cast<pid_t>(*process);
      if (whose == Unfinished::of_this_process ? number == ::getpid() : has_ended(number))
        found.push_back(entry->path());
    }
    for (const fs::path& path : found) fs::remove_all(path, error);
  }
}

OutputFolder::OutputFolder(fs::path target, Overwrite overwrite)
    : target_(without_trailing_separator(target)) {
  std::error_code error;
  if (!fs::exists(target_, error)) target_ = behind_links(target_);
  require_folder_of(target_);
  const fs::file_status status = fs::status(target_, error);
  existed_ = fs::exists(status);
  if (existed_ && !fs::is_directory(status)) {
    throw InputError(target_.string(), "a file", "the name of a folder to write");
  }
  if (existed_ && overwrite == Overwrite::refuse && !fs::is_empty(target_, error)) {
    throw InputError(target_.string(), error ? error.message() : "a folder that is not empty",
                     "a new or empty folder, or --force to write into this one");
  }
  staging_ = new_staging(existed_ ? target_ : parent_folder(target_), target_, "", make_new_folder);
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (!staging_.empty()) fs::remove_all(staging_, ignored);
}

fs::path OutputFolder::staged(const std::string& name) const {
  const fs::path relative = fs::path(name).lexically_normal();
  if (relative.empty() || relative.is_absolute() || *relative.begin() == "..") {
    throw std::invalid_argument("an output's name must lie inside its folder: " + name);
  }
  std::error_code error;
  fs::create_directories((staging_ / relative).parent_path(), error);
  return staging_ / relative;
}

void OutputFolder::write(const std::string& name, std::string_view contents) const {
  write_bytes(staged(name), contents, (target_ / name).string());
}

void OutputFolder::append(const std::string& name, std::string_view piece) const {
  append_bytes(staged(name), piece, (target_ / name).string());
}

void OutputFolder::supersede(std::function<bool(const std::string& name)> is_earlier) {
  is_earlier_ = std::move(is_earlier);
}

void OutputFolder::commit() {
  if (existed_) {
    std::vector<fs::path> earlier;
    for (const auto& entry : fs::directory_iterator(target_)) {
      const fs::path name = entry.path().filename();
      std::error_code ignored;  // what cannot be looked at is none
      if (is_earlier_ && is_earlier_(name.string()) && entry.is_regular_file(ignored) &&
          !fs::exists(staging_ / name))
        earlier.push_back(entry.path());
    }
    merge_folder(staging_, target_);
    for (const fs::path& file : earlier) fs::remove(file);
    fs::remove_all(staging_);
  } else {
    for (const fs::path& entry : entries_below(staging_)) {
      flush_to_disk(staging_ / entry, (target_ / entry).string());
    }
    rename_path(staging_, target_, false);
  }
  staging_.clear();
  flush_to_disk(existed_ ? target_ : parent_folder(target_), target_.string());
}

}  // namespace ballservo
