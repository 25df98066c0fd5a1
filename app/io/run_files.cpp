#include "app/io/run_files.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>

#include "app/io/image_source.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/system_file.hpp"

namespace fs = std::filesystem;

namespace ballservo {
namespace {

fs::path covariance_of(const fs::path& file) { return file.string() + ".covariance.json"; }

fs::path plain(const fs::path& name) {
  std::error_code ignored;
  const fs::path whole = fs::absolute(name), known = fs::weakly_canonical(whole, ignored);
  const fs::path path = (known.empty() ? whole : known).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

bool holds_results(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / "manifest.json", ignored) || fs::exists(folder / "report.json", ignored);
}

}  // namespace

std::map<RunFiles::FileId, fs::path> RunFiles::files_at(const fs::path& name, bool as_input) {
  std::map<FileId, fs::path> files;
  struct stat status {};
  const auto add = [&](const fs::path& file) {
    const bool there = ::stat(file.c_str(), &status) == 0;
    if (there) files.emplace(FileId{status.st_dev, status.st_ino}, file);
    return there && S_ISDIR(status.st_mode);
  };
  if (!add(name)) {
    add(covariance_of(name));
    return files;
  }
  const bool pictures_only = as_input && !holds_results(name);
  std::error_code error;
  for (fs::directory_iterator entry(name, error), end; !error && entry != end; entry.increment(error))
    if (!entry->is_directory(error) && (!pictures_only || has_image_name(entry->path()))) add(entry->path());
  return files;
}

void RunFiles::writes(const std::string& option, const fs::path& name, bool dash) {
  if (name.empty()) throw InputError(option, "an empty name", "the name of a file or folder to write");
  if (name == standard_output) {
    if (!dash)
      throw InputError(option, "- (standard output)", "the name of a file or folder (./- for one called -)");
  } else {
    struct stat status {};
    if (::stat(name.c_str(), &status) != 0 && errno != ENOENT)
      throw InputError(option + " " + name.string(), system_error_text(errno),
                       "the name of a file or folder to write");
    remove_unfinished(name, Unfinished::of_ended_processes);
  }
  Output output{option, plain(name), files_at(name, false)};
  for (const Output& other : outputs_) {
    const bool same = output.name == other.name || covariance_of(output.name) == other.name ||
                      output.name == covariance_of(other.name) ||
                      std::any_of(output.files.begin(), output.files.end(),
                                  [&](const auto& file) { return other.files.count(file.first) > 0; });
    if (same)
      throw InputError(option, name.string() + ", as " + other.option, "a name of its own for each output");
  }
  std::error_code error;
  replaces_ =
      replaces_ || (fs::exists(name, error) && !(fs::is_directory(name, error) && fs::is_empty(name, error)));
  outputs_.push_back(std::move(output));
}

void RunFiles::reads(const std::string& option, const fs::path& name) const {
  for (const auto& [id, file] : files_at(name, true))
    for (const Output& output : outputs_)
      if (output.files.count(id) > 0)
        throw InputError(output.option + " " + output.name.string(),
                         "a place of " + file.string() + ", which is read (" + option + ")",
                         "a name apart from all that is read, a folder of its own");
}

void RunFiles::require(const fs::path& output) const {
  const fs::path name = plain(output);
  if (std::none_of(outputs_.begin(), outputs_.end(), [&](const Output& known) { return known.name == name; }))
    throw std::logic_error("an output that is no option's: " + output.string());
}

void RunFiles::tidy() const {
  for (const Output& output : outputs_) {
    remove_unfinished(output.name, Unfinished::of_this_process);
    remove_unfinished(covariance_of(output.name), Unfinished::of_this_process);
  }
}

}  // namespace ballservo
