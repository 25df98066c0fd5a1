#include "app/io/noted_lines.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <nlohmann/json.hpp>
#include <utility>

#include "calibration/base/fault.hpp"
#include "calibration/base/system_file.hpp"

namespace ballservo {
namespace {

constexpr std::size_t longest_line = std::size_t{1} << 26, block_bytes = std::size_t{1} << 16;
constexpr const char* as_written = "the file as it was written";

bool parse_note(const std::string& line, std::string& key, std::string& value) {
  const nlohmann::json json = nlohmann::json::parse(line, nullptr, false);
  if (!json.is_array() || json.size() != 2 || !json[0].is_string() || !json[1].is_string()) return false;
  key = json[0].get<std::string>();
  value = json[1].get<std::string>();
  return true;
}

// Reads at most `bytes` at an offset, fewer at the file's end.
std::string bytes_at(int descriptor, const std::string& name, std::uint64_t offset, std::size_t bytes) {
  std::string text(bytes, '\0');
  std::size_t size = 0;
  while (size < bytes) {
    const ssize_t got =
        ::pread(descriptor, text.data() + size, bytes - size, static_cast<off_t>(offset + size));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw InputError(name, system_error_text(errno), "a file that can be read");
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  text.resize(size);
  return text;
}

}  // namespace

std::string note_line(const std::string& key, const std::string& value) {
  return nlohmann::json::array({key, value}).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) +
         "\n";
}

std::uint64_t read_notes(int descriptor, const std::string& name,
                         const std::function<void(const NotedLine&)>& each) {
  NotedLine line;
  std::string text;
  std::uint64_t read = 0;
  const auto damaged = [&] {
    return InputError(name + ":" + std::to_string(line.number), "a damaged line", as_written);
  };
  for (;;) {
    const std::string block = bytes_at(descriptor, name, read, block_bytes);
    if (block.empty()) return line.place.offset;
    read += block.size();
    std::size_t begin = 0;
    for (std::size_t end = block.find('\n'); end != std::string::npos;
         begin = end + 1, end = block.find('\n', begin)) {
      text.append(block, begin, end - begin);
      ++line.number;
      if (!parse_note(text, line.key, line.value)) throw damaged();
      line.place.bytes = static_cast<std::uint32_t>(text.size());
      each(line);
      line.place.offset += text.size() + 1;
      text.clear();
    }
    text.append(block, begin, std::string::npos);
    if (text.size() > longest_line) {
      ++line.number;
      throw damaged();
    }
  }
}

std::string note_value(int descriptor, const std::string& name, const NotePlace& place) {
  std::string key, value;
  if (!parse_note(bytes_at(descriptor, name, place.offset, place.bytes), key, value))
    throw InputError(name, "a note that has changed", as_written);
  return value;
}

NoteFile::NoteFile(std::filesystem::path file) : file_(std::move(file)) {
  // Without waiting: a named pipe without a writer would block for ever.
  descriptor_ = ::open(file_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor_ < 0) throw InputError(file_.string(), system_error_text(errno), "a file that can be read");
  try {
    const std::uint64_t whole = read_notes(descriptor_, file_.string(),
                                           [&](const NotedLine& line) { places_[line.key] = line.place; });
    if (!bytes_at(descriptor_, file_.string(), whole, 1).empty())
      throw InputError(file_.string(), "an unfinished last line", as_written);
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

NoteFile::~NoteFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

NoteFile::NoteFile(NoteFile&& other) noexcept
    : file_(std::move(other.file_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      places_(std::move(other.places_)) {}

std::optional<std::string> NoteFile::find(const std::string& key) const {
  const auto it = places_.find(key);
  if (it == places_.end()) return std::nullopt;
  return note_value(descriptor_, file_.string(), it->second);
}

}  // namespace ballservo
