#include "app/io/work_journal.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <nlohmann/json.hpp>

#include "calibration/files/fault.hpp"
#include "calibration/files/system_file.hpp"

namespace ballservo {
namespace {

constexpr std::size_t max_bytes = std::size_t{1} << 30;
constexpr const char* first_line_key = "ballservo journal 1";

std::string line_of(const std::string& key, const std::string& value) {
  return nlohmann::json::array({key, value}).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) +
         "\n";
}

/// The line's key and value; false where it is none of ours.
bool parse_line(const std::string& line, std::string& key, std::string& value) {
  const nlohmann::json json = nlohmann::json::parse(line, nullptr, false);
  if (!json.is_array() || json.size() != 2 || !json[0].is_string() || !json[1].is_string()) return false;
  key = json[0].get<std::string>();
  value = json[1].get<std::string>();
  return true;
}

std::string all_of(int descriptor, const std::string& place) {
  std::string text, block(1u << 16, '\0');
  for (;;) {
    const ssize_t got = ::read(descriptor, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw InputError(place, system_error_text(errno), "a journal that can be read");
    if (got == 0) return text;
    text.append(block, 0, static_cast<std::size_t>(got));
    if (text.size() > max_bytes) throw InputError(place, "more than 1 GiB", "a journal of this program");
  }
}

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
  const std::string text = all_of(descriptor_, file_.string());
  std::size_t begin = 0;
  long number = 0;
  for (std::size_t end = text.find('\n'); end != std::string::npos;
       begin = end + 1, end = text.find('\n', begin)) {
    std::string key, value;
    ++number;
    const bool good = parse_line(text.substr(begin, end - begin), key, value);
    if (!good || (number == 1) != (key == first_line_key)) {
      throw InputError(file_.string() + ":" + std::to_string(number), "a damaged line",
                       "the journal as it was written; --force to begin anew");
    }
    if (number == 1 && value != job) {
      throw InputError(
          file_.string(), "the finished part of another job",
          "the inputs and options that this folder was begun with, another folder, or --force to "
          "begin anew");
    }
    if (number > 1) items_.emplace(std::move(key), std::move(value));
  }
  if (begin < text.size() && ::ftruncate(descriptor_, static_cast<off_t>(begin)) != 0) {
    throw InputError(file_.string(), system_error_text(errno), "a place that can be written");
  }
  if (number == 0) append(line_of(first_line_key, job));
}

void WorkJournal::append(const std::string& line) {
  std::string_view rest = line;
  while (!rest.empty()) {
    const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      throw InputError(file_.string(), system_error_text(errno),
                       "a place that can be written, with room on the disk");
    }
    rest.remove_prefix(static_cast<std::size_t>(written));
  }
}

const std::string* WorkJournal::find(const std::string& key) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto item = items_.find(key);
  return item == items_.end() ? nullptr : &item->second;
}

std::size_t WorkJournal::size() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return items_.size();
}

void WorkJournal::add(const std::string& key, const std::string& value) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!items_.emplace(key, value).second) return;
  append(line_of(key, value));
}

void WorkJournal::remove() {
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
  ::close(descriptor_);
  descriptor_ = -1;
}

}  // namespace ballservo
