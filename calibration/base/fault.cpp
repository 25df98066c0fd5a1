#include "calibration/base/fault.hpp"

#include <fmt/format.h>

#include <utility>

namespace ballservo {
namespace {

/// One printable line: what a hostile file holds must not reach the terminal as control characters.
std::string printable(const std::string& text, std::size_t max_length) {
  std::string line;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (line.size() >= max_length) {
      while (!line.empty() && (static_cast<unsigned char>(line.back()) & 0xC0) == 0x80) line.pop_back();
      if (!line.empty() && static_cast<unsigned char>(line.back()) >= 0xC0) line.pop_back();
      return line + "...";
    }
    if (c == '\n') {
      line += "\\n";
    } else if (c == '\t') {
      line += ' ';
    } else if (byte < 0x20 || byte == 0x7F) {
      line += fmt::format("\\x{:02x}", byte);
    } else {
      line += c;
    }
  }
  return line;
}

std::string to_text(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& fault : faults) text += (text.empty() ? "" : "\n") + ballservo::to_text(fault);
  return text;
}

}  // namespace

std::string to_text(const Fault& fault) {
  const bool blank = fault.found.find_first_not_of(' ') == std::string::npos;
  return printable(fault.place, 1000) + ": found " +
         printable(blank ? '"' + fault.found + '"' : fault.found, 300) +
         "; allowed: " + printable(fault.allowed, 1000);
}

InputError::InputError(std::vector<Fault> faults)
    : std::runtime_error(to_text(faults)), faults_(std::move(faults)) {}

InputError::InputError(std::string place, std::string found, std::string allowed)
    : InputError({Fault{std::move(place), std::move(found), std::move(allowed)}}) {}

void FaultList::add(std::string place, std::string found, std::string allowed) {
  faults_.push_back({std::move(place), std::move(found), std::move(allowed)});
}

void FaultList::throw_if_any() const {
  if (!faults_.empty()) throw InputError(faults_);
}

void check_range(FaultList& faults, const std::string& place, double value, double low, double high) {
  if (!(value >= low && value <= high))
    faults.add(place, fmt::format("{}", value), fmt::format("{} to {}", low, high));
}

}  // namespace ballservo
