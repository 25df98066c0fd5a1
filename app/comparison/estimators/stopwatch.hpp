// What a piece of work costs.
#pragma once

#include <ctime>

namespace ballservo {

/// Processor time of the calling thread since its making: the same whoever else is at work on the machine.
class Stopwatch {
 public:
  double us() const { return now_us() - start_us_; }

 private:
  static double now_us() {
    std::timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return 1e6 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_nsec);
  }

  double start_us_ = now_us();
};

}  // namespace ballservo
