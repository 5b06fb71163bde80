#include "lanes/kernel.h"

namespace planar_chain::simd {

#ifdef PLANAR_CHAIN_X86
constexpr const Kernel* avx2 = &kernelAvx2;
#else
constexpr const Kernel* avx2 = nullptr;
#endif
#ifdef PLANAR_CHAIN_AVX512
constexpr const Kernel* avx512 = &kernelAvx512;
#else
constexpr const Kernel* avx512 = nullptr;
#endif

const std::vector<const Kernel*>& kernels(KernelChoice choice) {
  return runnable<Kernel>(avx512, avx2, kernelBaseline, choice);
}

const Kernel& kernelFor(int links, KernelChoice choice) {
  constexpr int few = 64;  // 8 lanes are too many for fewer
  const std::vector<const Kernel*>& all = kernels(choice);
  return all.front()->lanes == 8 && links < few ? *all[1] : *all.front();
}

}  // namespace planar_chain::simd
