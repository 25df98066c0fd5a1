// One part of a job that several processes or machines share.
#pragma once

#include <cstddef>
#include <string>

namespace ballservo {

/// The `index`-th (from 1) of `count` parts of a list of items. Items are dealt out like cards, so that parts
/// of a list whose cost changes slowly along it cost about the same.
struct Shard {
  int index = 1, count = 1;

  /// Whether item `item` (from 0) belongs to this part. Each item belongs to exactly one of the parts.
  bool holds(std::size_t item) const {
    return item % static_cast<std::size_t>(count) == static_cast<std::size_t>(index - 1);
  }
  bool is_whole() const { return count == 1; }
  std::string to_text() const;  ///< "2/4"
};

inline constexpr int max_shards = 100000;

/// Reads "I/N" (1 <= I <= N <= max_shards); InputError about `place` otherwise.
Shard parse_shard(const std::string& text, const std::string& place = "--shard");

}  // namespace ballservo
