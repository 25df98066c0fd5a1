// The time of a run: simulated, or the wall's.
#pragma once

#include <chrono>
#include <thread>

namespace ballservo {

/// Seconds since the start of the run.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual double now_s() const = 0;
  /// Returns at that time, or at once where it has passed.
  virtual void sleep_until(double time_s) = 0;
};

/// Simulated time: who sleeps moves it on. For one thread.
class SteppedClock final : public Clock {
 public:
  double now_s() const override { return now_s_; }
  void sleep_until(double time_s) override {
    if (time_s > now_s_) now_s_ = time_s;
  }

 private:
  double now_s_ = 0;
};

/// Time since it was made. For any number of threads.
class WallClock final : public Clock {
 public:
  double now_s() const override { return std::chrono::duration<double>(Steady::now() - start_).count(); }
  void sleep_until(double time_s) override {
    std::this_thread::sleep_until(
        start_ + std::chrono::duration_cast<Steady::duration>(std::chrono::duration<double>(time_s)));
  }

 private:
  using Steady = std::chrono::steady_clock;
  Steady::time_point start_ = Steady::now();
};

}  // namespace ballservo
