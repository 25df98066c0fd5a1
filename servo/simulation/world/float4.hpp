// Four neighbouring pixels at once, in single precision: what a compiler maps to the vectors of any
// processor.
#pragma once

#include <cstdint>

namespace ballservo {

using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));  ///< also a truth: -1 where it holds, else 0

/// A thing of four pixels as (x, y, z): directions, points; or (red, green, blue) of linear light.
struct Triple4 {
  Float4 x, y, z;
};

/// Surface coordinates of four points, or the sides of four patches.
struct Pair4 {
  Float4 u, v;
};

inline Float4 four(float x) { return Float4{x, x, x, x}; }
inline Float4 four(double x) { return four(static_cast<float>(x)); }
inline Float4 min(Float4 a, Float4 b) { return a < b ? a : b; }
inline Float4 max(Float4 a, Float4 b) { return a > b ? a : b; }
inline Float4 abs(Float4 x) { return reinterpret_cast<Float4>(reinterpret_cast<Int4>(x) & 0x7fffffff); }
inline Float4 to_float(Int4 x) { return __builtin_convertvector(x, Float4); }

/// The largest whole numbers that are not larger (of numbers within the range of 32-bit integers).
inline Int4 floor_index(Float4 x) {
  const Int4 whole = __builtin_convertvector(x, Int4);
  return whole + (x < to_float(whole));
}
inline Float4 floor(Float4 x) { return to_float(floor_index(x)); }

using Long2 = std::int64_t __attribute__((vector_size(16)));
inline bool any(Int4 truth) {
  const auto halves = reinterpret_cast<Long2>(truth);
  return (halves[0] | halves[1]) != 0;
}
inline bool all(Int4 truth) {
  const auto halves = reinterpret_cast<Long2>(truth);
  return (halves[0] & halves[1]) == -1;
}

}  // namespace ballservo
