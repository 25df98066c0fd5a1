#include "app/io/interrupt.hpp"

#include <semaphore.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <thread>
#include <utility>

#include "app/io/messages.hpp"

namespace ballservo {
namespace {

// A signal handler can reach nothing but what has static storage.
std::atomic<bool> requested{false};
std::atomic<long long> first_signal_s{0};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<long long>::is_always_lock_free);

sem_t signal_heard;
constexpr std::chrono::milliseconds time_to_stop(600);

struct Deadline {
  std::recursive_mutex mutex;
  std::function<void()> tidy;
};

/// Lives as long as the process: its end may come while the others' destructors run.
Deadline& deadline() {
  static auto* const only = new Deadline;
  return *only;
}

void stop_at_deadline() {
  while (sem_wait(&signal_heard) != 0) {
  }
  std::this_thread::sleep_for(time_to_stop);
  const auto lock = hold_interrupt_deadline();
  if (deadline().tidy) deadline().tidy();
  write_message("ballservo: interrupted\n");
  _exit(130);
}

void on_signal(int signal) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  if (!requested.exchange(true)) {
    first_signal_s.store(now.tv_sec);
    sem_post(&signal_heard);
    return;
  }
  // A shell or `timeout` may send one Ctrl-C to the program and again to its group: that is still the first.
  if (now.tv_sec - first_signal_s.load() < 2) return;
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

void install_interrupt_handler() {
  sem_init(&signal_heard, 0, 0);
  std::thread(stop_at_deadline).detach();
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;  // reads and writes under way go on: the command stops at a whole step
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  struct sigaction hangup {};
  sigaction(SIGHUP, nullptr, &hangup);
  if (hangup.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);  // as nohup has it
}

void tidy_when_stopped(std::function<void()> tidy) {
  const auto lock = hold_interrupt_deadline();
  deadline().tidy = std::move(tidy);
}

std::unique_lock<std::recursive_mutex> hold_interrupt_deadline() {
  return std::unique_lock(deadline().mutex);
}

bool interrupt_requested() { return requested.load(); }

void request_interrupt(bool wanted) { requested.store(wanted); }

void throw_if_interrupted() {
  if (interrupt_requested()) throw Interrupted();
}

}  // namespace ballservo
