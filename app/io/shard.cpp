#include "app/io/shard.hpp"

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {

std::string Shard::to_text() const { return std::to_string(index) + "/" + std::to_string(count); }

Shard parse_shard(const std::string& text, const std::string& place) {
  const std::size_t slash = text.find('/');
  if (slash != std::string::npos) {
    const auto index = parse_integer(text.substr(0, slash)), count = parse_integer(text.substr(slash + 1));
    if (index && count && *index >= 1 && *index <= *count && *count <= max_shards) {
      return {static_cast<int>(*index), static_cast<int>(*count)};
    }
  }
  throw InputError(place, text.empty() ? "nothing" : text,
                   "I/N with I from 1 to N, such as 2/4 for the second of four parts (N up to " +
                       std::to_string(max_shards) + ")");
}

}  // namespace ballservo
