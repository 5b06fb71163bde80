#include "simd/vectors.h"

namespace planar_chain::simd {

#ifdef PLANAR_CHAIN_X86
constexpr const VectorKernel* avx2 = &vectorsAvx2;
#else
constexpr const VectorKernel* avx2 = nullptr;
#endif

const std::vector<const VectorKernel*>& vectorKernels(KernelChoice choice) {
  return runnable<VectorKernel>(nullptr, avx2, vectorsBaseline, choice);
}

const VectorKernel& vectors(KernelChoice choice) {
  return *vectorKernels(choice).front();
}

}  // namespace planar_chain::simd
