// What a long job has finished so far, in a file that survives a kill at any moment.
#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <string_view>

namespace ballservo {

/// One line a finished item, as JSON: ["key","value"]; the first line names the job. Every line is handed to
/// the system whole, with its line end as the last byte: a line without one was under way when the process
/// died, and counts as never written. (A machine that loses power may lose lines, too.) One process at a time
/// works with a journal. Thread-safe.
class WorkJournal {
 public:
  /// Opens the journal at `file`, or begins one where there is none or an empty one. `job` is a text (a hash)
  /// that two jobs share only if their items mean the same. Throws InputError where the journal is another
  /// job's, is damaged, is in another process' hands, or cannot be written.
  WorkJournal(std::filesystem::path file, const std::string& job);
  ~WorkJournal();
  WorkJournal(const WorkJournal&) = delete;
  WorkJournal& operator=(const WorkJournal&) = delete;

  /// The value noted for an item, by an earlier process or this one; null where there is none. The pointer
  /// stays valid as long as the journal.
  const std::string* find(const std::string& key) const;
  std::size_t size() const;

  /// Notes a finished item. A key that is known already keeps its value. InputError on a full disk.
  void add(const std::string& key, const std::string& value);

  /// Closes and deletes the journal: its job is done.
  void remove();

 private:
  void read(const std::string& job);
  void append(const std::string& line);

  std::filesystem::path file_;
  int descriptor_ = -1;
  mutable std::mutex mutex_;
  std::map<std::string, std::string> items_;
};

}  // namespace ballservo
