#include "app/io/messages.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <iostream>

namespace ballservo {
namespace {

bool stdout_is_json = false;   // set once, with the options
std::FILE* messages = stderr;  // set once, at the start

}  // namespace

std::FILE* message_stream() noexcept { return messages; }

void keep_stderr_for_messages() noexcept {
  const int own = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  std::FILE* const stream = own < 0 ? nullptr : fdopen(own, "w");
  if (stream && nowhere >= 0) {
    setvbuf(stream, nullptr, _IONBF, 0);
    messages = stream;
    dup2(nowhere, STDERR_FILENO);
  }
  close(nowhere);
}

void write_message(const std::string& text) noexcept { std::fwrite(text.data(), 1, text.size(), messages); }

void write_result(const std::string& text) noexcept {
  std::FILE* const stream = stdout_is_json ? messages : stdout;
  std::fwrite(text.data(), 1, text.size(), stream);
  std::fflush(stream);  // who reads a pipe waits for no more than the line
}

void give_stdout_to_json() noexcept { stdout_is_json = true; }

void write_json(const std::string& text) noexcept { std::fwrite(text.data(), 1, text.size(), stdout); }

bool stdout_failed() noexcept {
  std::cout.flush();
  return std::fflush(stdout) != 0 || std::ferror(stdout) != 0;
}

bool stdout_reader_left() noexcept {
  pollfd pipe{STDOUT_FILENO, 0, 0};
  return poll(&pipe, 1, 0) == 1 && (pipe.revents & POLLERR) != 0;
}

}  // namespace ballservo
