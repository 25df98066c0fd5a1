// Notes in a file: a line of JSON each, ["key","value"]. Values stay in the file until they are asked for, so
// that a file of any length takes no more memory than its keys.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

namespace ballservo {

/// Where a note lies in its file, its line end left out.
struct NotePlace {
  std::uint64_t offset = 0;
  std::uint32_t bytes = 0;
};

std::string note_line(const std::string& key, const std::string& value);  ///< with its line end

struct NotedLine {
  long number = 0;  ///< from 1
  std::string key, value;
  NotePlace place;
};

/// Hands every whole line of an open file to `each`, from its beginning; returns how many bytes they take.
/// What stands behind the last line end was never finished. Throws InputError naming file (`name`) and line
/// for what is no note, or is longer than 64 MiB.
std::uint64_t read_notes(int descriptor, const std::string& name,
                         const std::function<void(const NotedLine&)>& each);

/// The value of a note in an open file. Throws InputError where it has been changed meanwhile.
std::string note_value(int descriptor, const std::string& name, const NotePlace& place);

/// A file of notes to look things up in. Thread-safe.
class NoteFile {
 public:
  /// Throws InputError as read_notes does, and for a last line without its end.
  explicit NoteFile(std::filesystem::path file);
  ~NoteFile();
  NoteFile(NoteFile&& other) noexcept;
  NoteFile& operator=(NoteFile&&) = delete;
  NoteFile(const NoteFile&) = delete;
  NoteFile& operator=(const NoteFile&) = delete;

  std::optional<std::string> find(const std::string& key) const;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  std::map<std::string, NotePlace> places_;
};

}  // namespace ballservo
