#include "lanes/kernel.h"

namespace planar_chain::simd {

#ifdef PLANAR_CHAIN_X86
extern const Kernel kernelAvx2, kernelAvx512;
constexpr const Kernel *avx2 = &kernelAvx2, *avx512 = &kernelAvx512;
#else
constexpr const Kernel *avx2 = nullptr, *avx512 = nullptr;
#endif

extern const Kernel kernelBaseline;

const Kernels<Kernel>& kernels() {
  static const Kernels<Kernel> all = runnable(avx512, avx2, kernelBaseline);
  return all;
}

const Kernel& kernelFor(std::ptrdiff_t size) {
  return bestFor(kernels(), size);
}

}  // namespace planar_chain::simd
