#include "perception/segmentation/yuyv.hpp"

#if defined(__x86_64__)
#include <immintrin.h>

#define AVX2 __attribute__((target("avx2")))

namespace ballservo {
namespace {

using F = YuvFactors;

AVX2 inline __m256i times(__m256i values, int factor) {
  return _mm256_mullo_epi32(values, _mm256_set1_epi32(factor));
}

AVX2 inline __m256i byte(__m256i sum) {
  const __m256i value = _mm256_srai_epi32(sum, F::shift);
  return _mm256_max_epi32(_mm256_min_epi32(value, _mm256_set1_epi32(255)), _mm256_setzero_si256());
}

AVX2 inline __m256i bytes(__m256i first, __m256i second, __m256i third) {
  return _mm256_or_si256(_mm256_or_si256(first, _mm256_slli_epi32(second, 8)), _mm256_slli_epi32(third, 16));
}

// The 12 bytes of two pairs of pixels, and four more behind them.
AVX2 inline void store(std::uint8_t* to, __m128i pairs) {
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to), pairs);
}

// 16 pixels: a pair of them in each of eight 32-bit numbers.
AVX2 inline void convert(const std::uint8_t* yuyv, std::uint8_t* bgr) {
  const __m256i pairs = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(yuyv));
  const __m256i low_byte = _mm256_set1_epi32(255), middle = _mm256_set1_epi32(128);
  const __m256i u = _mm256_sub_epi32(_mm256_and_si256(_mm256_srli_epi32(pairs, 8), low_byte), middle);
  const __m256i v = _mm256_sub_epi32(_mm256_srli_epi32(pairs, 24), middle);
  const __m256i half = _mm256_set1_epi32(F::half);
  const __m256i blue = _mm256_add_epi32(times(u, F::blue_of_u), half);
  const __m256i green =
      _mm256_add_epi32(_mm256_add_epi32(times(u, F::green_of_u), times(v, F::green_of_v)), half);
  const __m256i red = _mm256_add_epi32(times(v, F::red_of_v), half);
  __m256i pixel[2];  // blue, green, red from the lowest byte on
  for (int k = 0; k < 2; ++k) {
    const __m256i raw = _mm256_and_si256(_mm256_srli_epi32(pairs, 16 * k), low_byte);
    const __m256i above = _mm256_sub_epi32(raw, _mm256_set1_epi32(16));
    const __m256i y = times(_mm256_max_epi32(above, _mm256_setzero_si256()), F::level);
    pixel[k] = bytes(byte(_mm256_add_epi32(y, blue)), byte(_mm256_add_epi32(y, green)),
                     byte(_mm256_add_epi32(y, red)));
  }
  // Pixels of four bytes, in order, to pixels of three.
  const __m256i three_of_four =
      _mm256_broadcastsi128_si256(_mm_setr_epi8(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, -1, -1, -1, -1));
  const __m256i low = _mm256_shuffle_epi8(_mm256_unpacklo_epi32(pixel[0], pixel[1]), three_of_four);
  const __m256i high = _mm256_shuffle_epi8(_mm256_unpackhi_epi32(pixel[0], pixel[1]), three_of_four);
  store(bgr, _mm256_castsi256_si128(low));
  store(bgr + 12, _mm256_castsi256_si128(high));
  store(bgr + 24, _mm256_extracti128_si256(low, 1));
  store(bgr + 36, _mm256_extracti128_si256(high, 1));
}

}  // namespace

AVX2 void yuyv_to_bgr_avx2(const std::uint8_t* yuyv, int pixels, std::uint8_t* bgr) {
  for (; pixels >= 16; pixels -= 16, yuyv += 2 * 16, bgr += 3 * 16) convert(yuyv, bgr);
  yuyv_to_bgr_portable(yuyv, pixels, bgr);
}

}  // namespace ballservo
#endif
