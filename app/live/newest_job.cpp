#include "app/live/newest_job.hpp"

#include <sys/resource.h>

#include <boost/asio/post.hpp>
#include <utility>

namespace ballservo {

void NewestJob::ask(std::function<void()> job) {
  {
    const std::lock_guard lock(mutex_);
    next_.swap(job);  // the last one is let go without the lock
  }
  boost::asio::post(thread_, [this] {
    constexpr int niceness = 5;
    setpriority(PRIO_PROCESS, 0, niceness);  // in Linux of this thread
    std::unique_lock lock(mutex_);
    const auto next = std::exchange(next_, nullptr);
    lock.unlock();
    if (next) next();
  });
}

}  // namespace ballservo
