#include "app/live/live_exchange.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace ballservo {

std::uint64_t LiveExchange::publish(nlohmann::json state, Clock::time_point taken,
                                    std::function<cv::Mat(const std::string&)> draw, std::string line) {
  const std::uint64_t serial = ++serial_;
  state["serial"] = serial;
  auto moment = std::make_shared<const LiveMoment>(
      LiveMoment{serial, state.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace), taken,
                 std::move(draw), std::move(line)});
  std::function<void()> tell;
  {
    const std::lock_guard lock(mutex_);
    newest_.swap(moment);  // the last one is let go without the lock
    tell = on_publish_;
  }
  if (tell) tell();
  return serial;
}

std::vector<LiveCommand> LiveExchange::next_commands() {
  const std::lock_guard lock(mutex_);
  const auto end = commands_.begin() + static_cast<std::ptrdiff_t>(std::min(commands_.size(), most_at_once));
  std::vector<LiveCommand> next(std::make_move_iterator(commands_.begin()), std::make_move_iterator(end));
  commands_.erase(commands_.begin(), end);
  return next;
}

void LiveExchange::wait_until(Clock::time_point time) {
  std::unique_lock lock(mutex_);
  changed_.wait_until(lock, time, [&] { return awake_ || !commands_.empty(); });
  awake_ = false;
}

void LiveExchange::wake() {
  const std::lock_guard lock(mutex_);
  awake_ = true;
  changed_.notify_all();
}

bool LiveExchange::is_looked_at(const std::string& view) const {
  const std::lock_guard lock(mutex_);
  return views_.count(view) > 0;
}

void LiveExchange::set_on_publish(std::function<void()> on_publish) {
  const std::lock_guard lock(mutex_);
  on_publish_ = std::move(on_publish);
}

std::shared_ptr<const LiveMoment> LiveExchange::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

bool LiveExchange::put(LiveCommand command) {
  const std::lock_guard lock(mutex_);
  if (commands_.size() >= most_waiting) return false;
  commands_.push_back(std::move(command));
  changed_.notify_all();
  return true;
}

void LiveExchange::set_views(std::set<std::string> views) {
  const std::lock_guard lock(mutex_);
  views_ = std::move(views);
}

}  // namespace ballservo
