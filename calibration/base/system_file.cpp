#include "calibration/base/system_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

constexpr const char* writable_place = "a place that can be written, with room on the disk";

[[noreturn]] void fail(const std::string& place) {
  throw InputError(place, system_error_text(errno), writable_place);
}

void write_with(int flags, const std::filesystem::path& file, std::string_view contents,
                const std::string& place) {
  Descriptor descriptor(::open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | flags, 0666));
  if (descriptor.number() < 0) fail(place);
  while (!contents.empty()) {
    const ssize_t written = ::write(descriptor.number(), contents.data(), contents.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(place);
    contents.remove_prefix(static_cast<std::size_t>(written));
  }
  if (!descriptor.close()) fail(place);
}

}  // namespace

std::string system_error_text(int error_number) {
  const char* description = ::strerrordesc_np(error_number);
  return description ? description : "system error " + std::to_string(error_number);
}

Descriptor::~Descriptor() { close(); }

bool Descriptor::close() { return number_ < 0 || ::close(std::exchange(number_, -1)) == 0; }

Descriptor open_regular_file(const std::filesystem::path& file) {
  // Without waiting: a named pipe without a writer would block for ever.
  Descriptor descriptor(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (descriptor.number() < 0 || ::fstat(descriptor.number(), &status) != 0)
    throw InputError(file.string(), system_error_text(errno), "a file that can be read");
  if (!S_ISREG(status.st_mode))
    throw InputError(file.string(),
                     S_ISDIR(status.st_mode) ? "a folder" : "something that is no regular file",
                     "a regular file");
  return descriptor;
}

std::size_t read_some(const Descriptor& descriptor, const std::string& place, char* bytes, std::size_t most) {
  for (;;) {
    const ssize_t count = ::read(descriptor.number(), bytes, most);
    if (count >= 0) return static_cast<std::size_t>(count);
    if (errno != EINTR) throw InputError(place, system_error_text(errno), "a file that can be read");
  }
}

std::string read_file_bytes(const std::filesystem::path& file, std::size_t max_bytes) {
  const Descriptor descriptor = open_regular_file(file);
  std::string bytes;
  constexpr std::size_t block = std::size_t{1} << 16;
  for (std::size_t size = 0;;) {
    bytes.resize(size + block);
    const std::size_t count = read_some(descriptor, file.string(), bytes.data() + size, block);
    bytes.resize(size += count);
    if (size > max_bytes)
      throw InputError(file.string(), fmt::format("more than {} bytes", max_bytes),
                       fmt::format("a regular file of at most {} bytes", max_bytes));
    if (count == 0) return bytes;
  }
}

std::string read_text_file(const std::filesystem::path& file, std::size_t max_bytes) {
  std::string text = read_file_bytes(file, max_bytes);
  if (text.compare(0, 3, "\xef\xbb\xbf") == 0) text.erase(0, 3);
  std::size_t kept = 0;
  for (std::size_t at = 0; at < text.size(); ++at)
    if (text[at] != '\r' || at + 1 == text.size() || text[at + 1] != '\n') text[kept++] = text[at];
  text.resize(kept);
  return text;
}

void write_bytes(const std::filesystem::path& file, std::string_view contents, const std::string& place) {
  write_with(O_TRUNC, file, contents, place);
}

void append_bytes(const std::filesystem::path& file, std::string_view contents, const std::string& place) {
  write_with(O_APPEND, file, contents, place);
}

bool make_new_file(const std::filesystem::path& file, const std::string& place) {
  const Descriptor descriptor(::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (descriptor.number() < 0 && errno != EEXIST) fail(place);
  return descriptor.number() >= 0;
}

bool make_new_folder(const std::filesystem::path& folder, const std::string& place) {
  const int made = ::mkdir(folder.c_str(), 0777);
  if (made != 0 && errno != EEXIST) fail(place);
  return made == 0;
}

void flush_to_disk(const std::filesystem::path& path, const std::string& place) {
  const Descriptor descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (descriptor.number() < 0) fail(place);
  // Some file systems cannot flush a folder and say EINVAL: there is nothing to wait for then.
  if (::fsync(descriptor.number()) != 0 && errno != EINVAL) fail(place);
}

void rename_path(const std::filesystem::path& from, const std::filesystem::path& to, bool replace) {
  const auto refuse_existing = [&] {
    throw InputError(to.string(), "an existing output", "a new name, or --force");
  };
  if (!replace) {
    if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return;
    if (errno == EEXIST) refuse_existing();
    // File systems without this flag: look first, which leaves only an instant for somebody else's file.
    if (errno != EINVAL && errno != ENOSYS) fail(to.string());
    std::error_code ignored;
    if (std::filesystem::exists(std::filesystem::symlink_status(to, ignored))) refuse_existing();
  }
  if (std::rename(from.c_str(), to.c_str()) != 0) fail(to.string());
}

}  // namespace ballservo
