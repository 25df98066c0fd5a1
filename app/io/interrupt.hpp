// Ctrl-C: the first one asks the running command to stop at the next whole step.
#pragma once

#include <functional>
#include <mutex>
#include <stdexcept>

namespace ballservo {

/// Thrown where an interrupted command has nothing whole to keep; the program exits with 130.
class Interrupted : public std::runtime_error {
 public:
  explicit Interrupted(const std::string& what = "interrupted") : std::runtime_error(what) {}
};

/// Installs the handler of SIGINT, SIGTERM and SIGHUP. A command that has not stopped 0.6 s after the first
/// signal is stopped with exit code 130; a second signal, two seconds later or more, ends the program at
/// once.
void install_interrupt_handler();

/// What is called before a command is stopped; before there is anything to tidy up.
void tidy_when_stopped(std::function<void()> tidy);

/// While it lives the command is not stopped: for results on the way to their places.
[[nodiscard]] std::unique_lock<std::recursive_mutex> hold_interrupt_deadline();

/// True once the user has asked to stop.
bool interrupt_requested();

/// Asks to stop, as a program does that has no handler of these here; or takes it back.
void request_interrupt(bool wanted);

/// Throws Interrupted if the user has asked to stop.
void throw_if_interrupted();

}  // namespace ballservo
