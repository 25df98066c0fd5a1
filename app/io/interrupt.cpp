#include "app/io/interrupt.hpp"

#include <time.h>

#include <atomic>
#include <csignal>

namespace ballservo {
namespace {

// A signal handler can reach nothing but what has static storage.
std::atomic<bool> requested{false};
std::atomic<long long> first_signal_s{0};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<long long>::is_always_lock_free);

void on_signal(int signal) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  if (!requested.exchange(true)) {
    first_signal_s.store(now.tv_sec);
    return;
  }
  // A shell or `timeout` may send one Ctrl-C to the program and again to its group: that is still the first.
  if (now.tv_sec - first_signal_s.load() < 2) return;
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

void install_interrupt_handler() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;  // reads and writes under way go on: the command stops at a whole step
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  struct sigaction hangup {};
  sigaction(SIGHUP, nullptr, &hangup);
  if (hangup.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);  // as nohup has it
}

bool interrupt_requested() { return requested.load(); }

void throw_if_interrupted() {
  if (interrupt_requested()) throw Interrupted();
}

}  // namespace ballservo
