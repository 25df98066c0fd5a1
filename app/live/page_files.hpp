// The files of the page, which lie in the program itself.
#pragma once

#include <optional>
#include <string_view>

namespace ballservo {

struct PageFile {
  std::string_view name;  ///< as the page asks for it; index.html has none
  std::string_view type;  ///< as HTTP's Content-Type
  std::string_view bytes;
};

std::optional<PageFile> page_file(std::string_view name);

}  // namespace ballservo
