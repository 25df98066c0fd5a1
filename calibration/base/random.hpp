// Portable random numbers: std:: engines are standardised, std:: distributions are not.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <string_view>

namespace ballservo {

using RandomEngine = std::mt19937_64;

/// The finaliser of SplitMix64 (Steele, Lea and Flood, OOPSLA 2014): every bit depends on all.
inline std::uint64_t mixed_bits(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}
inline constexpr std::uint64_t split_mix_step = 0x9e3779b97f4a7c15ull;

/// The engine for one purpose of one seed ("shot_noise", frame 12): streams of different purposes are
/// independent. FNV-1a of the purpose, then SplitMix64 over seed, purpose and index.
inline RandomEngine random_stream(std::uint64_t seed, std::string_view purpose, std::uint64_t index = 0) {
  std::uint64_t hash = 0xcbf29ce484222325ull;
  for (const char c : purpose) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
  const auto mix = [](std::uint64_t x) { return mixed_bits(x + split_mix_step); };
  return RandomEngine(mix(mix(mix(seed) ^ hash) ^ index));
}

/// Uniform in [0, 1), from the engine's upper 53 bits.
inline double uniform01(RandomEngine& engine) { return static_cast<double>(engine() >> 11) * 0x1.0p-53; }

inline double uniform(RandomEngine& engine, double low, double high) {
  return low + (high - low) * uniform01(engine);
}

/// Uniform in 0 .. count-1 by multiplication and shift (bias below 2^-32 for counts below 2^32).
inline std::uint32_t uniform_index(RandomEngine& engine, std::uint32_t count) {
  return static_cast<std::uint32_t>(((engine() >> 32) * count) >> 32);
}

/// Standard normal by Box and Muller (1958), one value a call.
inline double standard_normal(RandomEngine& engine) {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform01(engine)));
  return radius * std::cos(6.283185307179586 * uniform01(engine));
}

}  // namespace ballservo
