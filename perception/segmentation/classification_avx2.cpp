#include "perception/segmentation/classification_kernels.hpp"

#if defined(__x86_64__)
#include <immintrin.h>

#include <cstring>

#define AVX2 __attribute__((target("avx2")))

namespace ballservo {
namespace {

AVX2 inline __m256i in_both_lanes(const std::uint8_t* from) {
  return _mm256_broadcastsi128_si256(_mm_load_si128(reinterpret_cast<const __m128i*>(from)));
}

// A table of 32 entries for PSHUFB, which knows 16: it looks at the lower four bits of an index, and gives 0
// where the index is negative.
struct Table32 {
  __m256i lower, change;  // entries 0 to 15; what turns them into entries 16 to 31
};

AVX2 inline Table32 table_of(const std::uint8_t* entries) {
  const __m256i lower = in_both_lanes(entries);
  return {lower, _mm256_xor_si256(lower, in_both_lanes(entries + 16))};
}

AVX2 inline __m256i look_up(const Table32& table, __m256i cells) {
  const __m256i above = _mm256_sub_epi8(cells, _mm256_set1_epi8(16));
  return _mm256_xor_si256(_mm256_shuffle_epi8(table.lower, cells), _mm256_shuffle_epi8(table.change, above));
}

AVX2 inline __m256i load_lanes(const std::uint8_t* low, const std::uint8_t* high) {
  const __m128i first = _mm_loadu_si128(reinterpret_cast<const __m128i*>(low));
  const __m128i second = _mm_loadu_si128(reinterpret_cast<const __m128i*>(high));
  return _mm256_inserti128_si256(_mm256_castsi128_si256(first), second, 1);
}

// Where a channel's bytes lie among the 48 of 16 pixels: for each of their three vectors, the places that
// they take from there; elsewhere PSHUFB writes 0.
struct Gathering {
  alignas(16) std::uint8_t from[3][3][16] = {};
  constexpr Gathering() {
    for (int c = 0; c < 3; ++c) {
      for (int i = 0; i < 16; ++i) {
        const int byte = 3 * i + c;
        for (int vector = 0; vector < 3; ++vector)
          from[c][vector][i] = static_cast<std::uint8_t>(byte / 16 == vector ? byte % 16 : 128);
      }
    }
  }
};
constexpr Gathering gathering;

// The cells of 32 pixels, a channel each.
struct Cells {
  __m256i channel[3];
};

AVX2 inline Cells cells_of(const std::uint8_t* bgr) {  // 96 bytes
  const __m256i vectors[3] = {load_lanes(bgr, bgr + 48), load_lanes(bgr + 16, bgr + 64),
                              load_lanes(bgr + 32, bgr + 80)};
  Cells cells;
  for (int c = 0; c < 3; ++c) {
    __m256i bytes = _mm256_setzero_si256();
    for (int i = 0; i < 3; ++i) {
      const __m256i part = _mm256_shuffle_epi8(vectors[i], in_both_lanes(gathering.from[c][i]));
      bytes = _mm256_or_si256(bytes, part);
    }
    cells.channel[c] = _mm256_and_si256(_mm256_srli_epi16(bytes, 3), _mm256_set1_epi8(31));
  }
  return cells;
}

struct Tables {
  Table32 of_channel[3];

  AVX2 explicit Tables(const BoxTables& tables) {
    for (int c = 0; c < 3; ++c) of_channel[c] = table_of(tables.bits[c]);
  }

  AVX2 __m256i bits(const Cells& cells) const {
    const __m256i blue = look_up(of_channel[0], cells.channel[0]);
    const __m256i green = look_up(of_channel[1], cells.channel[1]);
    const __m256i red = look_up(of_channel[2], cells.channel[2]);
    return _mm256_and_si256(_mm256_and_si256(blue, green), red);
  }
};

AVX2 inline std::uint64_t nonzero(__m256i low, __m256i high) {
  const __m256i zero = _mm256_setzero_si256();
  const auto none_low = static_cast<std::uint32_t>(_mm256_movemask_epi8(_mm256_cmpeq_epi8(low, zero)));
  const auto none_high = static_cast<std::uint32_t>(_mm256_movemask_epi8(_mm256_cmpeq_epi8(high, zero)));
  return ~(none_low | static_cast<std::uint64_t>(none_high) << 32);
}

}  // namespace

AVX2 void tell_by_boxes_avx2(const std::uint8_t* bgr, int pixels, const ColorBoxes& boxes,
                             std::uint64_t* const* rows, std::uint64_t* unsure) {
  const Tables outer(boxes.outer), inner(boxes.inner);
  std::uint8_t rest[3 * 64] = {};
  for (int word = 0; 64 * word < pixels; ++word, bgr += 3 * 64) {
    const int count = pixels - 64 * word;
    std::uint64_t counted = ~std::uint64_t{0};
    if (count < 64) {
      std::memcpy(rest, bgr, static_cast<std::size_t>(3 * count));
      bgr = rest;
      counted >>= 64 - count;
    }
    const Cells low = cells_of(bgr), high = cells_of(bgr + 96);
    std::uint64_t left = nonzero(outer.bits(low), outer.bits(high)) & counted;
    if (left == 0) {
      for (int k = 0; k < boxes.classes; ++k) rows[k][word] = 0;
    } else {
      const __m256i in_low = inner.bits(low), in_high = inner.bits(high);
      for (int k = 0; k < boxes.classes; ++k) {
        const __m256i own = _mm256_set1_epi8(static_cast<char>(boxes.inner_of_class[k]));
        const std::uint64_t sure =
            nonzero(_mm256_and_si256(in_low, own), _mm256_and_si256(in_high, own)) & left;
        rows[k][word] = sure;
        left ^= sure;
      }
    }
    unsure[word] = left;
  }
}

}  // namespace ballservo
#endif
