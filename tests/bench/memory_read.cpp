#include "tests/bench/memory_read.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace ballservo::bench {
namespace {

using Sum = std::uint64_t (*)(const std::uint8_t* bytes, std::size_t count);

std::uint64_t sum_portable(const std::uint8_t* bytes, std::size_t count) {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += bytes[i];
  return sum;
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) std::uint64_t sum_avx2(const std::uint8_t* bytes, std::size_t count) {
  const __m256i zero = _mm256_setzero_si256();
  __m256i sums[2] = {zero, zero};
  std::size_t i = 0;
  for (; i + 64 <= count; i += 64) {
    for (std::size_t k = 0; k < 2; ++k) {
      const auto* const from = reinterpret_cast<const __m256i*>(bytes + i + 32 * k);
      sums[k] = _mm256_add_epi64(sums[k], _mm256_sad_epu8(_mm256_loadu_si256(from), zero));
    }
  }
  alignas(32) std::uint64_t parts[4];
  _mm256_store_si256(reinterpret_cast<__m256i*>(parts), _mm256_add_epi64(sums[0], sums[1]));
  return parts[0] + parts[1] + parts[2] + parts[3] + sum_portable(bytes + i, count - i);
}

__attribute__((target("avx512f,avx512bw"))) std::uint64_t sum_avx512(const std::uint8_t* bytes,
                                                                     std::size_t count) {
  const __m512i zero = _mm512_setzero_si512();
  __m512i sums[2] = {zero, zero};
  std::size_t i = 0;
  for (; i + 128 <= count; i += 128) {
    for (std::size_t k = 0; k < 2; ++k) {
      const __m512i part = _mm512_loadu_si512(bytes + i + 64 * k);
      sums[k] = _mm512_add_epi64(sums[k], _mm512_sad_epu8(part, zero));
    }
  }
  alignas(64) std::uint64_t parts[8];
  _mm512_store_si512(parts, _mm512_add_epi64(sums[0], sums[1]));
  std::uint64_t sum = sum_portable(bytes + i, count - i);
  for (const std::uint64_t part : parts) sum += part;
  return sum;
}
#endif

Sum widest() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512bw")) return sum_avx512;
  if (__builtin_cpu_supports("avx2")) return sum_avx2;
#endif
  return sum_portable;
}

}  // namespace

std::uint64_t sum_of_bytes(const std::uint8_t* bytes, std::size_t count) {
  static const Sum sum = widest();
  return sum(bytes, count);
}

}  // namespace ballservo::bench
