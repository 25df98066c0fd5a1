// Files through the system's own calls, which report a full disk where streams keep quiet about it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

namespace ballservo {

/// A file descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor();
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;

  int number() const { return number_; }  ///< negative: none
  /// Closes now; false if the system reports a late write error (as network file systems do).
  bool close();

 private:
  int number_;
};

/// Opens a file to be read; InputError if it is missing or not a regular file.
Descriptor open_regular_file(const std::filesystem::path& file);
/// Reads at most `most` bytes; 0 at the file's end. InputError about `place`.
std::size_t read_some(const Descriptor& descriptor, const std::string& place, char* bytes, std::size_t most);

/// The system's words for an error number, in English whatever the locale.
std::string system_error_text(int error_number);

/// The whole file as bytes; InputError if it is missing, not a regular file, or larger than `max_bytes`.
std::string read_file_bytes(const std::filesystem::path& file, std::size_t max_bytes);

/// The same of a text as editors of any system leave it: without a byte order mark, its lines ended by LF
/// where they ended in CR LF.
std::string read_text_file(const std::filesystem::path& file, std::size_t max_bytes);

/// Replaces the contents of `file` (made if missing). InputError about `place` if that fails, on a full disk
/// too.
void write_bytes(const std::filesystem::path& file, std::string_view contents, const std::string& place);

/// Adds `contents` to the end of `file` (made if missing). InputError as write_bytes.
void append_bytes(const std::filesystem::path& file, std::string_view contents, const std::string& place);

/// Makes a new empty file, or folder; false if something of this name exists. InputError about `place` if it
/// fails.
bool make_new_file(const std::filesystem::path& file, const std::string& place);
bool make_new_folder(const std::filesystem::path& folder, const std::string& place);

/// Waits until the file or folder has reached the disk. InputError about `place` if it cannot.
void flush_to_disk(const std::filesystem::path& path, const std::string& place);

/// Renames within one file system; without `replace`, an existing target is an InputError about it.
void rename_path(const std::filesystem::path& from, const std::filesystem::path& to, bool replace);

}  // namespace ballservo
