// A small strict checker: is this text well-formed XML (as far as our pages use it)?
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ballservo::test {

/// What is wrong with the markup, or empty. Knows elements, attributes in double quotes, the five references
/// that pages use, a document type and an XML declaration; `<style>` has text only.
inline std::string markup_fault(std::string_view text) {
  std::vector<std::string> open;
  const auto reference_ok = [&](std::size_t at) {
    for (const std::string_view known : {"&amp;", "&lt;", "&gt;", "&quot;", "&#39;"}) {
      if (text.substr(at, known.size()) == known) return true;
    }
    return false;
  };
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 && c != '\n' && c != '\t') return "control character at " + std::to_string(at);
    if (c == '&' && !reference_ok(at)) return "bare & at " + std::to_string(at);
    if (c == '>') return "bare > at " + std::to_string(at);
    if (c != '<') continue;
    // Reads one tag, minding quotes.
    std::size_t end = at + 1;
    bool quoted = false;
    for (; end < text.size() && (quoted || text[end] != '>'); ++end) {
      if (text[end] == '"') quoted = !quoted;
      if (text[end] == '<') return "< within a tag at " + std::to_string(end);
      if (text[end] == '&' && !reference_ok(end)) return "bare & in an attribute at " + std::to_string(end);
    }
    if (end == text.size()) return "unclosed tag at " + std::to_string(at);
    const std::string tag(text.substr(at + 1, end - at - 1));
    at = end;
    if (tag.empty()) return "empty tag";
    if (tag[0] == '!' || tag[0] == '?') continue;
    if (tag[0] == '/') {
      if (open.empty() || open.back() != tag.substr(1)) return "</" + tag.substr(1) + "> closes nothing";
      open.pop_back();
      continue;
    }
    if (tag.back() == '/') continue;
    open.push_back(tag.substr(0, tag.find_first_of(" \n")));
  }
  return open.empty() ? "" : "<" + open.back() + "> stays open";
}

/// How often `needle` occurs.
inline int occurrences(std::string_view text, std::string_view needle) {
  int count = 0;
  for (std::size_t at = text.find(needle); at != std::string_view::npos; at = text.find(needle, at + 1))
    ++count;
  return count;
}

}  // namespace ballservo::test
