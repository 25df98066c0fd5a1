// Text files as editors of any system leave them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace ballservo {

/// The file's text without a byte order mark, its lines ended by LF where they ended in CR LF. Throws as
/// read_file_bytes does.
std::string read_text_file(const std::filesystem::path& file, std::size_t max_bytes);

}  // namespace ballservo
