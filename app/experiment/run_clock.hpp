// The wall clock of a run: seconds since its start.
#pragma once

#include <chrono>
#include <thread>

namespace ballservo {

class RunClock {
 public:
  double now_s() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  void sleep_until(double time_s) const {
    std::this_thread::sleep_until(
        start_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(time_s)));
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

}  // namespace ballservo
