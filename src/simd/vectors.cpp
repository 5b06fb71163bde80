#include "simd/vectors.h"

#include "simd/cpu.h"

namespace planar_chain::simd {

#ifdef PLANAR_CHAIN_X86
bool runsAvx2() {
  return __builtin_cpu_supports("fma") && __builtin_cpu_supports("avx2");
}
bool runsAvx512() {
  return runsAvx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512vl");
}
constexpr const VectorKernel* avx2 = &vectorsAvx2;
#else
bool runsAvx2() {
  return false;
}
bool runsAvx512() {
  return false;
}
constexpr const VectorKernel* avx2 = nullptr;
#endif

const std::vector<const VectorKernel*>& vectorKernels() {
  static const auto kernels = runnable<VectorKernel>(nullptr, avx2, vectorsBaseline);
  return kernels;
}

const VectorKernel& vectors() {
  return *vectorKernels().front();
}

}  // namespace planar_chain::simd
