// Bytes in JSON (RFC 4648).
#pragma once

#include <optional>
#include <string>

namespace ballservo {

std::string base64(const std::string& bytes);
/// Nothing for a text that is none.
std::optional<std::string> from_base64(const std::string& text);

}  // namespace ballservo
