/// For x86-64 with AVX2 and FMA; CMakeLists.txt has the options.

#include "lanes/kernel_here.h"
#include "lanes/short_kernel.h"

namespace planar_chain::simd {

const ShortChains shortChainsAvx2{laneCount, shortChainFor};

const Kernel kernelAvx2 = kernelHere("avx2", &shortChainsAvx2);

}  // namespace planar_chain::simd
