#include "simd/vectors.h"

#include "simd/cpu.h"

namespace planar_chain::simd {

#ifdef PLANAR_CHAIN_X86
constexpr const VectorKernel* avx2 = &vectorsAvx2;
#else
constexpr const VectorKernel* avx2 = nullptr;
#endif

const std::vector<const VectorKernel*>& vectorKernels() {
  return runnable<VectorKernel>(nullptr, avx2, vectorsBaseline);
}

const VectorKernel& vectors() {
  return *vectorKernels().front();
}

}  // namespace planar_chain::simd
