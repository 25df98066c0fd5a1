// The colours file: versioned, checksummed, one file for table, names, histograms, and the counts that the
// table can be made from anew, so that files can be merged and learnt on.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "calibration/color/color_table.hpp"

namespace ballservo {

inline constexpr int color_file_version = 2;
inline constexpr std::size_t color_file_max_bytes = 16u << 20;

/// Whether a class may be called that, and what it may be called, for messages.
bool is_class_name(std::string_view name);
inline constexpr const char* class_name_rule = "1 to 64 of a-z, 0-9 and _, beginning with a letter";

/// Throws std::invalid_argument for a table that could not be read back.
std::string color_file_bytes(const ColorTable& table);

/// Throws InputError (with `place` as the file) for a file that is truncated, of another version, of a wrong
/// checksum, or whose contents contradict themselves (class numbers without a class, bad names, counts that
/// overflow).
ColorTable parse_color_file(std::string_view bytes, const std::string& place);

ColorTable read_color_file(const std::filesystem::path& file);

}  // namespace ballservo
