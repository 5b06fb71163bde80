/// For every CPU; CMakeLists.txt has the options.

#include "lanes/kernel_here.h"
#include "lanes/short_kernel.h"

namespace planar_chain::simd {

const ShortChains shortChains{laneCount, shortChainFor};

const Kernel kernelBaseline = kernelHere("baseline", &shortChains);

}  // namespace planar_chain::simd
