// From one thread to another: the newest few of something; who reads late misses the oldest.
#pragma once

#include <deque>
#include <mutex>
#include <optional>

namespace ballservo {

template <typename T>
class Mailbox {
 public:
  explicit Mailbox(std::size_t capacity) : capacity_(capacity) {}

  void put(T item) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (items_.size() == capacity_) items_.pop_front();
    items_.push_back(std::move(item));
  }

  /// The oldest item, if it is `ready`.
  template <typename Ready>
  std::optional<T> take(const Ready& ready) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (items_.empty() || !ready(items_.front())) return std::nullopt;
    std::optional<T> item(std::move(items_.front()));
    items_.pop_front();
    return item;
  }

 private:
  std::size_t capacity_;
  std::mutex mutex_;
  std::deque<T> items_;
};

}  // namespace ballservo
