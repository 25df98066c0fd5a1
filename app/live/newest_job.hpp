// A thread for what is wanted of the newest state alone.
#pragma once

#include <boost/asio/thread_pool.hpp>
#include <functional>
#include <mutex>

namespace ballservo {

/// Does jobs at a lower priority than whoever asks for them, who never waits: of those that have not begun
/// yet the last alone is done.
class NewestJob {
 public:
  void ask(std::function<void()> job);

 private:
  std::mutex mutex_;
  std::function<void()> next_;
  boost::asio::thread_pool thread_{1};  // its end waits for the job under way, and does no other
};

}  // namespace ballservo
