#include "app/io/messages.hpp"

#include <cstdio>
#include <iostream>

namespace ballservo {
namespace {

bool stdout_is_json = false;  // set once, with the options

}  // namespace

void write_message(const std::string& text) noexcept { std::fwrite(text.data(), 1, text.size(), stderr); }

void write_result(const std::string& text) noexcept {
  std::fwrite(text.data(), 1, text.size(), stdout_is_json ? stderr : stdout);
}

void give_stdout_to_json() noexcept { stdout_is_json = true; }

void write_json(const std::string& text) noexcept { std::fwrite(text.data(), 1, text.size(), stdout); }

bool stdout_failed() noexcept {
  std::cout.flush();
  return std::fflush(stdout) != 0 || std::ferror(stdout) != 0;
}

}  // namespace ballservo
