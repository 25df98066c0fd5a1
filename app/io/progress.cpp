#include "app/io/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <utility>

#include "app/io/messages.hpp"

namespace ballservo {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr Seconds quiet_start(1.0), bar_period(0.1), line_period(5.0);
constexpr int bar_width = 30;

std::string bar(long done, long total) {
  const double fraction = std::clamp(static_cast<double>(done) / static_cast<double>(total), 0.0, 1.0);
  const auto filled = static_cast<std::size_t>(fraction * bar_width);
  return "[" + std::string(filled, '#') + std::string(bar_width - filled, '.') + "]";
}

}  // namespace

std::optional<double> time_left_s(double elapsed_s, long done, long total) {
  constexpr double soonest_s = 2, least_share = 0.03, surely_s = 30;
  if (done <= 0 || done >= total || elapsed_s < soonest_s) return std::nullopt;
  const double share = static_cast<double>(done) / static_cast<double>(total);
  if (share < least_share && elapsed_s < surely_s) return std::nullopt;
  return elapsed_s * (1 - share) / share;
}

Progress::Progress(std::string what, long total, bool quiet)
    : what_(std::move(what)),
      total_(total),
      quiet_(quiet),
      terminal_(::isatty(fileno(message_stream())) == 1),
      start_(std::chrono::steady_clock::now()),
      last_(start_) {}

Progress::~Progress() {
  if (shown_ && terminal_) write_message("\n");
}

void Progress::step(long done) {
  if (quiet_) return;
  const auto now = std::chrono::steady_clock::now();
  const Seconds elapsed = now - start_, since_last = now - last_;
  const bool due = shown_ ? since_last >= (terminal_ ? bar_period : line_period) : elapsed >= quiet_start;
  const bool last_of_bar = shown_ && terminal_ && total_ > 0 && done >= total_;
  if (!due && !last_of_bar) return;
  last_ = now;
  shown_ = true;
  std::string line = what_ + ": ";
  if (total_ > 0) {
    if (terminal_) line += bar(done, total_) + " ";
    line += fmt::format("{} of {}", done, total_);
    if (const auto left_s = time_left_s(elapsed.count(), done, total_))
      line += fmt::format(", about {:.0f} s left", *left_s);
  } else {
    line += fmt::format("{}", done);
  }
  // "\033[K" clears the rest of a longer line that stood there before.
  write_message(terminal_ ? "\r" + line + "\033[K" : line + "\n");
}

}  // namespace ballservo
