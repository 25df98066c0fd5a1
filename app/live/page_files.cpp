#include "app/live/page_files.hpp"

#include <algorithm>
#include <array>

// The assembler takes the files as they are; BALLSERVO_PAGE and BALLSERVO_CHARTS are their folders.
#define BALLSERVO_EMBED(symbol, file)                                                                    \
  asm(".pushsection .rodata\n.global " #symbol "\n.hidden " #symbol "\n" #symbol ":\n.incbin \"" file    \
      "\"\n.global " #symbol "_end\n.hidden " #symbol "_end\n" #symbol "_end:\n.byte 0\n.popsection\n"); \
  extern "C" const char symbol[], symbol##_end[];

BALLSERVO_EMBED(ballservo_page_html, BALLSERVO_PAGE "/index.html")
BALLSERVO_EMBED(ballservo_page_css, BALLSERVO_PAGE "/live.css")
BALLSERVO_EMBED(ballservo_page_js, BALLSERVO_PAGE "/live.js")
BALLSERVO_EMBED(ballservo_calibrate_js, BALLSERVO_PAGE "/calibrate.js")
BALLSERVO_EMBED(ballservo_room_js, BALLSERVO_PAGE "/room.js")
BALLSERVO_EMBED(ballservo_chart_js, BALLSERVO_CHARTS "/chart.min.js")

namespace ballservo {

std::optional<PageFile> page_file(std::string_view name) {
  const auto file = [](std::string_view its_name, std::string_view type, const char* begin, const char* end) {
    return PageFile{its_name, type, {begin, static_cast<std::size_t>(end - begin)}};
  };
  static const std::array files = {
      file("", "text/html; charset=utf-8", ballservo_page_html, ballservo_page_html_end),
      file("live.css", "text/css; charset=utf-8", ballservo_page_css, ballservo_page_css_end),
      file("live.js", "text/javascript; charset=utf-8", ballservo_page_js, ballservo_page_js_end),
      file("calibrate.js", "text/javascript; charset=utf-8", ballservo_calibrate_js,
           ballservo_calibrate_js_end),
      file("room.js", "text/javascript; charset=utf-8", ballservo_room_js, ballservo_room_js_end),
      file("chart.js", "text/javascript; charset=utf-8", ballservo_chart_js, ballservo_chart_js_end)};
  const auto* const found =
      std::find_if(files.begin(), files.end(), [&](const PageFile& entry) { return entry.name == name; });
  if (found == files.end()) return std::nullopt;
  return *found;
}

}  // namespace ballservo
