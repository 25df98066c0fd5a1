// The files of a run: all that it reads and all that it writes, known before any work and held apart.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/io/interrupt.hpp"
#include "calibration/base/output.hpp"

namespace ballservo {

/// Standard output, where an option takes it for a name.
inline constexpr const char* standard_output = "-";

/// Outputs are named first, then inputs as they become known. Files are the same where device and inode are,
/// whatever they are called and through any link; a file and its .covariance.json belong together.
class RunFiles {
 public:
  /// Throws InputError for a name that cannot be one (empty, too long, a link to itself, `-` where `dash`
  /// does not allow it) or that another output has. Removes what a killed run left unfinished there.
  void writes(const std::string& option, const std::filesystem::path& name, bool dash);

  /// Throws InputError where an output would take the place of the input: is it, or is the folder that it
  /// lies in. Of a folder all pictures are inputs, of a folder of results all files.
  void reads(const std::string& option, const std::filesystem::path& name) const;

  /// Throws std::logic_error for an output that was not named.
  void require(const std::filesystem::path& output) const;

  /// Moves finished outputs (OutputFile, OutputFolder, VideoFile; optional ones where they are) to their
  /// places. Throws Interrupted, and leaves what is there, where an interrupted run would replace results.
  /// Once the first are there, all others are to follow: nothing stops the run any more.
  template <class... Outputs>
  void commit(Outputs&... outputs) {
    if (!placing_.owns_lock()) {
      placing_ = hold_interrupt_deadline();
      if (replaces_ && interrupt_requested())
        throw Interrupted("interrupted; what was there stays, and nothing of this run is written");
    }
    (commit_one(outputs), ...);
  }

  /// Removes what this process has not finished.
  void tidy() const;

 private:
  using FileId = std::pair<dev_t, ino_t>;
  struct Output {
    std::string option;
    std::filesystem::path name;
    std::map<FileId, std::filesystem::path> files;  ///< that are there: it, or those in it
  };
  static std::map<FileId, std::filesystem::path> files_at(const std::filesystem::path& name, bool as_input);

  template <class Out>
  static void commit_one(Out& output) {
    output.commit();
  }
  template <class Out>
  static void commit_one(std::optional<Out>& output) {
    if (output) output->commit();
  }

  std::vector<Output> outputs_;
  bool replaces_ = false;
  std::unique_lock<std::recursive_mutex> placing_;
};

}  // namespace ballservo
