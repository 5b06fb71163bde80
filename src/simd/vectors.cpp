#include "simd/vectors.h"

namespace planar_chain::simd {

#ifdef PLANAR_CHAIN_X86

bool runsAvx2() {
  return __builtin_cpu_supports("fma") && __builtin_cpu_supports("avx2");
}
bool runsAvx512() {
  return runsAvx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512vl");
}

extern const VectorKernel vectorsAvx2, vectorsAvx512;
constexpr const VectorKernel *avx2 = &vectorsAvx2, *avx512 = &vectorsAvx512;

#else

bool runsAvx2() {
  return false;
}
bool runsAvx512() {
  return false;
}

constexpr const VectorKernel *avx2 = nullptr, *avx512 = nullptr;

#endif

extern const VectorKernel vectorsBaseline;

const Kernels<VectorKernel>& vectorKernels() {
  static const Kernels<VectorKernel> kernels = runnable(avx512, avx2, vectorsBaseline);
  return kernels;
}

const VectorKernel& vectorsFor(std::ptrdiff_t size) {
  return bestFor(vectorKernels(), size);
}

}  // namespace planar_chain::simd
