// Which of the processor's instructions a computation may use; its result is the same, to the last bit.
#pragma once

namespace ballservo {

enum class Instructions { fastest, portable };

#if defined(__x86_64__)
template <auto compute, class... Arguments>
[[gnu::target("avx2")]] void compute_with_avx2(Arguments&... arguments) {
  compute(arguments...);
}
#endif

/// Calls `compute`, which is compiled with AVX2 and without: it and what it calls are to be inlined always.
template <auto compute, class... Arguments>
void compute_by(Instructions instructions, Arguments&... arguments) {
#if defined(__x86_64__)
  static const bool has_avx2 = __builtin_cpu_supports("avx2");
  if (has_avx2 && instructions == Instructions::fastest) return compute_with_avx2<compute>(arguments...);
#endif
  compute(arguments...);
}

}  // namespace ballservo
