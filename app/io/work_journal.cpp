#include "app/io/work_journal.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <string_view>

#include "calibration/base/fault.hpp"
#include "calibration/base/system_file.hpp"

namespace ballservo {
namespace {

constexpr const char* first_line_key = "ballservo journal 1";

}  // namespace

WorkJournal::WorkJournal(std::filesystem::path file, const std::string& job) : file_(std::move(file)) {
  descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (descriptor_ < 0) {
    throw InputError(file_.string(), system_error_text(errno), "a place that can be written");
  }
  try {
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      throw InputError(file_.string(), "a journal with which another process is at work",
                       "one process at a time: wait for it, or take another folder");
    }
    read(job);
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

WorkJournal::~WorkJournal() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void WorkJournal::read(const std::string& job) {
  const std::string name = file_.string();
  end_ = read_notes(descriptor_, name, [&](const NotedLine& line) {
    if ((line.number == 1) != (line.key == first_line_key)) {
      throw InputError(name + ":" + std::to_string(line.number), "a damaged line",
                       "the journal as it was written; --force to begin anew");
    }
    if (line.number == 1 && line.value != job) {
      throw InputError(
          name, "the finished part of another job",
          "the inputs and options that this folder was begun with, another folder, or --force to "
          "begin anew");
    }
    if (line.number > 1) places_.emplace(line.key, line.place);
  });
  if (::ftruncate(descriptor_, static_cast<off_t>(end_)) != 0) {
    throw InputError(name, system_error_text(errno), "a place that can be written");
  }
  if (end_ == 0) append(note_line(first_line_key, job));
}

NotePlace WorkJournal::append(const std::string& line) {
  std::string_view rest = line;
  while (!rest.empty()) {
    const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int problem = errno;
      // Half a line must not stand before the next one; where that fails the next start finds it damaged.
      if (::ftruncate(descriptor_, static_cast<off_t>(end_)) != 0) errno = problem;
      throw InputError(file_.string(), system_error_text(problem),
                       "a place that can be written, with room on the disk");
    }
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
  const NotePlace place{end_, static_cast<std::uint32_t>(line.size() - 1)};
  end_ += line.size();
  return place;
}

bool WorkJournal::has(const std::string& key) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return places_.count(key) > 0;
}

std::optional<std::string> WorkJournal::find(const std::string& key) const {
  NotePlace place;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto it = places_.find(key);
    if (it == places_.end()) return std::nullopt;
    place = it->second;
  }
  return note_value(descriptor_, file_.string(), place);
}

std::size_t WorkJournal::size() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return places_.size();
}

void WorkJournal::add(const std::string& key, const std::string& value) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (places_.count(key) > 0) return;
  places_.emplace(key, append(note_line(key, value)));
}

void WorkJournal::remove() {
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
  ::close(descriptor_);
  descriptor_ = -1;
}

}  // namespace ballservo
