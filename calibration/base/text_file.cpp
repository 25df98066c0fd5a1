#include "calibration/base/text_file.hpp"

#include "calibration/base/system_file.hpp"

namespace ballservo {

std::string read_text_file(const std::filesystem::path& file, std::size_t max_bytes) {
  std::string text = read_file_bytes(file, max_bytes);
  if (text.compare(0, 3, "\xef\xbb\xbf") == 0) text.erase(0, 3);
  std::size_t kept = 0;
  for (std::size_t at = 0; at < text.size(); ++at)
    if (text[at] != '\r' || at + 1 == text.size() || text[at + 1] != '\n') text[kept++] = text[at];
  text.resize(kept);
  return text;
}

}  // namespace ballservo
