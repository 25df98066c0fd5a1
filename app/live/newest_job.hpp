// A thread for what is wanted of the newest state alone.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace ballservo {

/// Does jobs at a lower priority than whoever asks for them, who never waits: of those that have not begun
/// yet the last alone is done.
class NewestJob {
 public:
  NewestJob() = default;
  /// Waits for the job under way.
  ~NewestJob();

  void ask(std::function<void()> job);

 private:
  void work();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::function<void()> next_;
  bool ended_ = false;
  std::thread thread_{[this] { work(); }};
};

}  // namespace ballservo
