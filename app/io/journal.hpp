// What a long job has finished so far, in a file that survives a kill at any moment.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "calibration/base/system_file.hpp"

namespace ballservo {

/// Whether a note is one that the job writes: a key of its own with what belongs to it.
using NoteCheck = std::function<bool(const std::string& key, const std::string& value)>;

/// One line a finished item, as JSON: ["key","value"]; the first line names the job. A line without its end
/// was under way when the process died, and counts as never written. (A machine that loses power may lose
/// whole lines, too.) Values stay in the file, so that a journal of any length takes no more memory than its
/// keys. One process at a time works with a journal. Thread-safe.
class Journal {
 public:
  /// Opens the journal at `file`, or begins one where there is none or an empty one. `job` is a text (a hash)
  /// that two jobs share only if their items mean the same. Throws InputError where the journal is another
  /// job's, is damaged or holds a note that is none, is in another process' hands, or cannot be written.
  Journal(std::filesystem::path file, const std::string& job, NoteCheck is_note);

  bool has(const std::string& key) const;
  /// The value of an item that an earlier process noted, or this one.
  std::optional<std::string> find(const std::string& key) const;
  std::size_t size() const;

  /// Notes a finished item. A key that is known already keeps its value. InputError on a full disk.
  void add(const std::string& key, const std::string& value);
  /// Notes what a finished part's journal holds. InputError for a file that is none, or is not whole.
  void add_part(const std::filesystem::path& part);

 private:
  struct Place {
    std::uint64_t offset = 0, bytes = 0;
  };
  void append(const std::string& key, const std::string& value);

  std::filesystem::path file_;
  NoteCheck is_note_;
  Descriptor lock_;
  mutable std::mutex mutex_;
  std::uint64_t end_ = 0;  // of the whole lines
  std::map<std::string, Place> places_;
};

}  // namespace ballservo
