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
    if (fused && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl")) {
      found[count++] = &avx512;
    }
    if (fused && __builtin_cpu_supports("avx2")) found[count++] = &avx2;
#endif
    found[count] = &baseline;
    return found;
  }();
  return runnable;
}

const Kernel& kernelFor(std::ptrdiff_t size) {
  constexpr std::ptrdiff_t isShort = 64;  // for 8 lanes; 4 suit all
  const Kernel& best = *kernels().front();
  return best.lanes == 8 && size < isShort ? *kernels()[1] : best;
}

}  // namespace planar_chain::simd
