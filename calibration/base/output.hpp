// Outputs that appear whole or not at all, and never replace anything without being told to.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace ballservo {

/// Whether an existing output may be replaced (`--force`).
enum class Overwrite { refuse, allow };

/// A file that is written beside its target under a temporary name and renamed when it is complete.
/// The constructor checks at once (before any long work) that the target may be written; InputError
/// otherwise. A target in a folder that does not exist is a fault, and so is one that is no regular file (a
/// folder, a device). A symbolic link to a file stays, and the file it names is replaced. Without `commit`
/// nothing is left behind.
class OutputFile {
 public:
  OutputFile(std::filesystem::path target, Overwrite overwrite);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  const std::filesystem::path& target() const { return target_; }
  /// Where a writer that wants a path (video, image) writes; same folder and extension as the target.
  const std::filesystem::path& staging_path() const { return staging_; }
  /// Writes `contents` to the staging path; InputError on a full disk.
  void write(std::string_view contents);
  /// Flushes to disk and renames into place; InputError if that fails, and nothing changes then.
  void commit();

 private:
  std::filesystem::path target_, staging_;
  Overwrite overwrite_;
};

/// Writes one file whole: `OutputFile`, `write`, `commit`.
void write_file(const std::filesystem::path& target, std::string_view contents, Overwrite overwrite);

/// A new folder among the system's temporary ones, which goes with everything in it. Throws InputError.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// The name with _2, _3 ... behind it: the first that nothing has.
std::filesystem::path unused_path(const std::filesystem::path& name);

/// Whose outputs were begun and not finished.
enum class Unfinished { of_this_process, of_ended_processes };
/// Removes what such processes have left of outputs at `target`: beside it, and in it where it is a folder.
void remove_unfinished(const std::filesystem::path& target, Unfinished whose);

/// A folder of results. The constructor refuses an existing folder that is not empty unless `overwrite`
/// allows it, and a target whose own folder does not exist. Files are written to `path()`, a hidden staging
/// folder: beside a new target, which `commit` then makes appear whole by one rename; inside an existing one,
/// into which `commit` moves the files one by one, leaving other files of the user's there alone; old
/// summaries (*.json) go before that and new ones come last. Without `commit` nothing is left behind.
class OutputFolder {
 public:
  OutputFolder(std::filesystem::path target, Overwrite overwrite);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& target() const { return target_; }
  const std::filesystem::path& path() const { return staging_; }
  /// A file inside the staging folder, its subfolders made as needed; InputError on a full disk.
  void write(const std::string& name, std::string_view contents) const;
  /// Adds to such a file: for what is too long to be held whole.
  void append(const std::string& name, std::string_view piece) const;
  /// Of an existing target: what an earlier run left there, by its name; `commit` removes it, if it is not
  /// written anew, so that nobody takes it for this run's.
  void supersede(std::function<bool(const std::string& name)> is_earlier);
  void commit();

 private:
  std::filesystem::path staged(const std::string& name) const;

  std::filesystem::path target_, staging_;
  bool existed_ = false;
  std::function<bool(const std::string&)> is_earlier_;
};

}  // namespace ballservo
