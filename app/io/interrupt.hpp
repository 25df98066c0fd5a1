// Ctrl-C: the first one asks the running command to stop at the next whole step.
#pragma once

#include <stdexcept>

namespace ballservo {

/// Thrown where an interrupted command has nothing whole to keep; the program exits with 130.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

/// Installs the handler of SIGINT and SIGTERM; a second one, two seconds later or more,
/// ends the program at once.
void install_interrupt_handler();

/// True once the user has asked to stop.
bool interrupt_requested();

/// Throws Interrupted if the user has asked to stop.
void throw_if_interrupted();

}  // namespace ballservo
