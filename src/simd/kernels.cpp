#include "kernel.h"

namespace planar_chain::simd {

extern const Kernel baseline;
#ifdef PLANAR_CHAIN_X86
extern const Kernel avx2;
extern const Kernel avx512;
#endif

const std::array<const Kernel*, 3>& kernels() {
  static const std::array<const Kernel*, 3> runnable = [] {
    std::array<const Kernel*, 3> found{};
    std::size_t count = 0;
#ifdef PLANAR_CHAIN_X86
    const bool fused = __builtin_cpu_supports("fma");
    if (fused && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) {
      found[count++] = &avx512;
    }
    if (fused && __builtin_cpu_supports("avx2")) found[count++] = &avx2;
#endif
    found[count] = &baseline;
    return found;
  }();
  return runnable;
}

}  // namespace planar_chain::simd
