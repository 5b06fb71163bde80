/// For x86-64 with AVX-512; CMakeLists.txt has the options.

#include "lanes/kernel_here.h"

namespace planar_chain::simd {

// 8 lanes are too many for short chains.
const Kernel kernelAvx512 = kernelHere("avx512", &shortChainsAvx2);

}  // namespace planar_chain::simd
