// What a long job has finished so far, in a file that survives a kill at any moment.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "app/io/noted_lines.hpp"

namespace ballservo {

/// One line a finished item, as JSON: ["key","value"]; the first line names the job. Every line is handed to
/// the system whole, with its line end as the last byte: a line without one was under way when the process
/// died, and counts as never written. (A machine that loses power may lose lines, too.) One process at a time
/// works with a journal. Values are kept in the file only. Thread-safe.
class WorkJournal {
 public:
  /// Opens the journal at `file`, or begins one where there is none or an empty one. `job` is a text (a hash)
  /// that two jobs share only if their items mean the same. Throws InputError where the journal is another
  /// job's, is damaged, is in another process' hands, or cannot be written.
  WorkJournal(std::filesystem::path file, const std::string& job);
  ~WorkJournal();
  WorkJournal(const WorkJournal&) = delete;
  WorkJournal& operator=(const WorkJournal&) = delete;

  /// Whether an item is noted, by an earlier process or this one; and its value, nothing where it is not.
  bool has(const std::string& key) const;
  std::optional<std::string> find(const std::string& key) const;
  std::size_t size() const;

  /// Notes a finished item. A key that is known already keeps its value. InputError on a full disk.
  void add(const std::string& key, const std::string& value);

  /// Closes and deletes the journal: its job is done.
  void remove();

 private:
  void read(const std::string& job);
  NotePlace append(const std::string& line);

  std::filesystem::path file_;
  int descriptor_ = -1;
  mutable std::mutex mutex_;
  std::uint64_t end_ = 0;  // of the whole lines
  std::map<std::string, NotePlace> places_;
};

}  // namespace ballservo
