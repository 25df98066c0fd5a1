// Which of the processor's instructions a computation may use; its result is the same, to the last bit.
#pragma once

namespace ballservo {

enum class Instructions { fastest, portable };

/// Is there AVX2, and may it be used?
inline bool may_use_avx2(Instructions instructions) {
#if defined(__x86_64__)
  static const bool has_it = __builtin_cpu_supports("avx2");
  return has_it && instructions == Instructions::fastest;
#else
  static_cast<void>(instructions);
  return false;
#endif
}

}  // namespace ballservo
