#include "app/live/newest_job.hpp"

#include <sys/resource.h>

#include <utility>

namespace ballservo {

NewestJob::~NewestJob() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void NewestJob::ask(std::function<void()> job) {
  {
    const std::lock_guard lock(mutex_);
    next_.swap(job);  // the last one is let go without the lock
  }
  changed_.notify_one();
}

void NewestJob::work() {
  constexpr int niceness = 5;
  setpriority(PRIO_PROCESS, 0, niceness);  // in Linux of this thread
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ended_ || next_; });
    if (ended_) return;
    auto job = std::exchange(next_, nullptr);
    lock.unlock();
    job();
    job = nullptr;  // what it holds is let go without the lock
    lock.lock();
  }
}

}  // namespace ballservo
