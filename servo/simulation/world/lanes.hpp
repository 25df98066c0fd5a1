// Neighbouring pixels at once, in single precision: what a compiler maps to the vectors of any processor.
//
// Vectors this wide have no common calling convention: functions that are not inlined take and give them by
// reference or inside a larger struct.
#pragma once

#include <cmath>
#include <cstdint>
#include <initializer_list>

/// For a function that works on lanes: all that it calls in its file is inlined, and it is compiled for AVX2
/// besides, which is taken where the processor has it. The same bytes either way: nothing is fused. Not with
/// sanitizers, whose checks cannot run when such a choice is made.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__OPTIMIZE__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define BALLSERVO_WIDE __attribute__((flatten, target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define BALLSERVO_WIDE
#endif

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace ballservo {

inline constexpr int lanes = 8;
using Floats = float __attribute__((vector_size(4 * lanes), aligned(4 * lanes)));
using Ints = std::int32_t
    __attribute__((vector_size(4 * lanes), aligned(4 * lanes)));  ///< also a truth: -1 where it holds, else 0

/// A thing of each pixel as (x, y, z): directions, points; or (red, green, blue) of linear light.
struct Triples {
  Floats x, y, z;
};

/// Surface coordinates of points, or the sides of patches.
struct Pairs {
  Floats u, v;
};

inline Floats spread(float x) { return Floats{} + x; }
inline Floats spread(double x) { return spread(static_cast<float>(x)); }
inline Floats min(Floats a, Floats b) { return a < b ? a : b; }
inline Floats max(Floats a, Floats b) { return a > b ? a : b; }
inline Floats abs(Floats x) { return reinterpret_cast<Floats>(reinterpret_cast<Ints>(x) & 0x7fffffff); }
inline Floats to_float(Ints x) { return __builtin_convertvector(x, Floats); }

/// The largest whole numbers that are not larger (of numbers within the range of 32-bit integers).
inline Ints floor_index(Floats x) {
  const Ints whole = __builtin_convertvector(x, Ints);
  return whole + (x < to_float(whole));
}
inline Floats floor(Floats x) { return to_float(floor_index(x)); }

inline Floats square_root(Floats x) {
  for (int i = 0; i < lanes; ++i) x[i] = std::sqrt(x[i]);
  return x;
}

/// atan2(y, x) to 2e-6 rad (Abramowitz and Stegun, 1964, 4.4.49, on the smaller over the larger).
inline Floats angle_of(Floats y, Floats x) {
  const Floats ax = abs(x), ay = abs(y);
  const Floats q = min(ax, ay) / max(max(ax, ay), spread(1e-30f)), q2 = q * q;
  Floats sum = spread(0.0028662257f);
  for (const float coefficient : {-0.0161657367f, 0.0429096138f, -0.0752896400f, 0.1065626393f,
                                  -0.1420889944f, 0.1999355085f, -0.3333314528f, 1.0f})
    sum = sum * q2 + coefficient;
  Floats angle = sum * q;
  angle = ay > ax ? 1.5707963f - angle : angle;
  angle = x < 0.0f ? 3.1415927f - angle : angle;
  return y < 0.0f ? -angle : angle;
}

using Longs = std::int64_t __attribute__((vector_size(4 * lanes), aligned(4 * lanes)));
inline bool any(Ints truth) {
  const auto halves = reinterpret_cast<Longs>(truth);
  std::int64_t some = 0;
  for (int i = 0; i < lanes / 2; ++i) some |= halves[i];
  return some != 0;
}
inline bool all(Ints truth) { return !any(~truth); }

}  // namespace ballservo

#pragma GCC diagnostic pop
