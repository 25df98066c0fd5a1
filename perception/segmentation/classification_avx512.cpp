#include "perception/segmentation/classification_kernels.hpp"

#if defined(__x86_64__)
#include <immintrin.h>

#define AVX512 __attribute__((target("avx512f,avx512bw,avx512vbmi")))

namespace ballservo {
namespace {

// Where the 64 bytes of a channel lie among the 192 bytes of 64 pixels, for two VPERMT2B: the first takes
// what lies in the first 128 bytes, the second keeps that (its own place) and adds the rest.
struct Gathering {
  alignas(64) std::uint8_t first[3][64] = {}, second[3][64] = {};
  constexpr Gathering() {
    for (int c = 0; c < 3; ++c) {
      for (int i = 0; i < 64; ++i) {
        const int from = 3 * i + c;
        first[c][i] = static_cast<std::uint8_t>(from < 128 ? from : 0);
        second[c][i] = static_cast<std::uint8_t>(from < 128 ? i : 64 + from - 128);
      }
    }
  }
};
constexpr Gathering gathering;

AVX512 inline __m512i load(const std::uint8_t* from) { return _mm512_load_si512(from); }

struct Cells {
  __m512i channel[3];
};

struct Deinterleaving {
  __m512i first[3], second[3];

  AVX512 Deinterleaving() {
    for (int c = 0; c < 3; ++c) {
      first[c] = load(gathering.first[c]);
      second[c] = load(gathering.second[c]);
    }
  }

  // Of 64 pixels from 192 bytes. The upper three bits of a cell are what the shift brings from the byte
  // beside: VPERMB does not look at two of them, and for the third the tables are there twice.
  AVX512 Cells cells(__m512i low, __m512i middle, __m512i high) const {
    low = _mm512_srli_epi16(low, 3);
    middle = _mm512_srli_epi16(middle, 3);
    high = _mm512_srli_epi16(high, 3);
    Cells cells;
    for (int c = 0; c < 3; ++c) {
      const __m512i part = _mm512_permutex2var_epi8(low, first[c], middle);
      cells.channel[c] = _mm512_permutex2var_epi8(part, second[c], high);
    }
    return cells;
  }
};

struct Tables {
  __m512i of_channel[3];

  AVX512 explicit Tables(const BoxTables& tables) {
    for (int c = 0; c < 3; ++c) of_channel[c] = load(tables.bits[c]);
  }

  AVX512 __m512i bits(const Cells& cells) const {
    const __m512i blue = _mm512_permutexvar_epi8(cells.channel[0], of_channel[0]);
    const __m512i green = _mm512_permutexvar_epi8(cells.channel[1], of_channel[1]);
    const __m512i red = _mm512_permutexvar_epi8(cells.channel[2], of_channel[2]);
    return _mm512_and_si512(_mm512_and_si512(blue, green), red);
  }
};

AVX512 inline __m512i load_bytes(const std::uint8_t* from, int count) {
  const __mmask64 mask = count >= 64 ? ~__mmask64{0} : count <= 0 ? 0 : (__mmask64{1} << count) - 1;
  return _mm512_maskz_loadu_epi8(mask, from);
}

}  // namespace

AVX512 void tell_by_boxes_avx512(const std::uint8_t* bgr, int pixels, const ColorBoxes& boxes,
                                 std::uint64_t* const* rows, std::uint64_t* unsure) {
  const Deinterleaving deinterleaving;
  const Tables outer(boxes.outer), inner(boxes.inner);
  for (int word = 0; 64 * word < pixels; ++word, bgr += 3 * 64) {
    const int count = pixels - 64 * word;
    Cells cells;
    std::uint64_t counted = ~std::uint64_t{0};
    if (count >= 64) {
      cells = deinterleaving.cells(_mm512_loadu_si512(bgr), _mm512_loadu_si512(bgr + 64),
                                   _mm512_loadu_si512(bgr + 128));
    } else {
      cells = deinterleaving.cells(load_bytes(bgr, 3 * count), load_bytes(bgr + 64, 3 * count - 64),
                                   load_bytes(bgr + 128, 3 * count - 128));
      counted >>= 64 - count;
    }
    const __m512i in_outer = outer.bits(cells);
    std::uint64_t left = _mm512_test_epi8_mask(in_outer, in_outer) & counted;
    if (left == 0) {
      for (int k = 0; k < boxes.classes; ++k) rows[k][word] = 0;
    } else {
      const __m512i in_inner = inner.bits(cells);
      for (int k = 0; k < boxes.classes; ++k) {
        const __m512i own = _mm512_set1_epi8(static_cast<char>(boxes.inner_of_class[k]));
        const std::uint64_t sure = _mm512_test_epi8_mask(in_inner, own) & left;
        rows[k][word] = sure;
        left ^= sure;
      }
    }
    unsure[word] = left;
  }
}

}  // namespace ballservo
#endif
