// What the program says. A stream that is closed, full or a broken pipe takes nothing, and nothing ends for
// it.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <utility>

namespace ballservo {

/// From now on stderr is ours alone: what OpenCV, libpng, FFmpeg print there of pictures that they cannot
/// read is said by our own faults, and goes nowhere.
void keep_stderr_for_messages() noexcept;
std::FILE* message_stream() noexcept;
/// Writes to stderr; a failure is nobody's concern.
void write_message(const std::string& text) noexcept;
/// Writes to stdout; stdout_failed() tells of a failure, in the end.
void write_result(const std::string& text) noexcept;
bool stdout_failed() noexcept;
/// Whether stdout is a pipe that nobody reads any more.
bool stdout_reader_left() noexcept;
/// Writes to stdout what a program reads; text for people goes to stderr from now on.
void give_stdout_to_json() noexcept;
void write_json(const std::string& text) noexcept;

template <class... Values>
void print_message(fmt::format_string<Values...> format, Values&&... values) {
  write_message(fmt::format(format, std::forward<Values>(values)...));
}

template <class... Values>
void print_result(fmt::format_string<Values...> format, Values&&... values) {
  write_result(fmt::format(format, std::forward<Values>(values)...));
}

}  // namespace ballservo
