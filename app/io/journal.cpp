#include "app/io/journal.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <fstream>
#include <nlohmann/json.hpp>

#include "calibration/base/fault.hpp"

namespace fs = std::filesystem;

namespace ballservo {
namespace {

constexpr const char* first_key = "ballservo journal 1";

struct Note {
  std::string key, value;
};

/// Nothing for a line that is no note.
std::optional<Note> parse_note(const std::string& line) {
  const nlohmann::json parsed = nlohmann::json::parse(line, nullptr, false);
  if (!parsed.is_array() || parsed.size() != 2 || !parsed[0].is_string() || !parsed[1].is_string())
    return std::nullopt;
  return Note{parsed[0].get<std::string>(), parsed[1].get<std::string>()};
}

/// Hands each whole line of a journal to `each`, with its place; returns how many bytes they take.
std::uint64_t read_notes(
    const fs::path& file, const NoteCheck& is_note,
    const std::function<void(const Note& note, std::uint64_t offset, std::uint64_t bytes)>& each) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) throw InputError(file.string(), "no regular file", "a journal");
  std::ifstream stream(file, std::ios::binary);
  std::uint64_t end = 0;
  std::string line;
  for (long number = 1; std::getline(stream, line) && !stream.eof(); ++number) {
    const auto note = parse_note(line);
    if (!note || (number == 1) != (note->key == first_key) ||
        (number > 1 && !is_note(note->key, note->value)))
      throw InputError(file.string() + ":" + std::to_string(number), "a damaged line",
                       "the journal as it was written; --force to begin anew");
    each(*note, end, line.size());
    end += line.size() + 1;
  }
  return end;
}

}  // namespace

Journal::Journal(fs::path file, const std::string& job, NoteCheck is_note)
    : file_(std::move(file)),
      is_note_(std::move(is_note)),
      lock_(::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666)) {
  const std::string name = file_.string();
  if (lock_.number() < 0) throw InputError(name, system_error_text(errno), "a place that can be written");
  if (::flock(lock_.number(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    throw InputError(name, "a journal with which another process is at work",
                     "one process at a time: wait for it, or take another folder");
  end_ = read_notes(file_, is_note_, [&](const Note& note, std::uint64_t offset, std::uint64_t bytes) {
    if (offset > 0) {
      places_.insert({note.key, {offset, bytes}});
    } else if (note.value != job) {
      throw InputError(
          name, "the finished part of another job",
          "the inputs and options that this folder was begun with, another folder, or --force to begin anew");
    }
  });
  fs::resize_file(file_, end_);
  if (end_ == 0) append(first_key, job);
}

void Journal::append(const std::string& key, const std::string& value) {
  const std::string line =
      nlohmann::json{key, value}.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  try {
    append_bytes(file_, line + "\n", file_.string());
  } catch (...) {
    // Half a line must not stand before the next one; where that fails the next start finds it damaged.
    std::error_code ignored;
    fs::resize_file(file_, end_, ignored);
    throw;
  }
  if (key != first_key) places_.insert({key, {end_, line.size()}});
  end_ += line.size() + 1;
}

bool Journal::has(const std::string& key) const {
  const std::lock_guard lock(mutex_);
  return places_.count(key) > 0;
}

std::size_t Journal::size() const {
  const std::lock_guard lock(mutex_);
  return places_.size();
}

std::optional<std::string> Journal::find(const std::string& key) const {
  Place place;
  {
    const std::lock_guard lock(mutex_);
    const auto found = places_.find(key);
    if (found == places_.end()) return std::nullopt;
    place = found->second;
  }
  std::ifstream stream(file_, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(place.offset));
  std::string line(place.bytes, '\0');
  stream.read(line.data(), static_cast<std::streamsize>(line.size()));
  const auto note = parse_note(line);
  if (!stream || !note)
    throw InputError(file_.string(), "a note that has changed", "the file as it was written");
  return note->value;
}

void Journal::add(const std::string& key, const std::string& value) {
  const std::lock_guard lock(mutex_);
  if (places_.count(key) == 0) append(key, value);
}

void Journal::add_part(const fs::path& part) {
  const std::uint64_t whole =
      read_notes(part, is_note_, [&](const Note& note, std::uint64_t offset, std::uint64_t) {
        if (offset > 0) add(note.key, note.value);
      });
  if (whole == 0 || whole != fs::file_size(part))
    throw InputError(part.string(), whole == 0 ? "no whole line" : "an unfinished last line",
                     "the journal of a finished part, as it was written");
}

}  // namespace ballservo
