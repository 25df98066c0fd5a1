// What it costs to read a frame at all: the measure that the benchmark's other figures are held against.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ballservo::bench {

/// The sum of the bytes, by the widest instructions that this processor has.
std::uint64_t sum_of_bytes(const std::uint8_t* bytes, std::size_t count);

}  // namespace ballservo::bench
