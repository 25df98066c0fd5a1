// From one thread to another: the newest few of something; who reads late misses the oldest.
#pragma once

#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace ballservo {

/// Allocates in the constructor only.
template <typename T>
class Mailbox {
 public:
  /// `capacity`: 1 or more.
  explicit Mailbox(std::size_t capacity) : ring_(capacity) {}

  void put(T item) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (count_ == ring_.size()) drop_oldest();
    ring_[(oldest_ + count_++) % ring_.size()] = std::move(item);
  }

  /// The oldest item, if it is `ready`.
  template <typename Ready>
  std::optional<T> take(const Ready& ready) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (count_ == 0 || !ready(ring_[oldest_])) return std::nullopt;
    std::optional<T> item(std::move(ring_[oldest_]));
    drop_oldest();
    return item;
  }

 private:
  void drop_oldest() {
    oldest_ = (oldest_ + 1) % ring_.size();
    --count_;
  }

  std::mutex mutex_;
  std::vector<T> ring_;
  std::size_t oldest_ = 0, count_ = 0;
};

}  // namespace ballservo
