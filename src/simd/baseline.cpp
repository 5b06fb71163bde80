/// For every CPU; CMakeLists.txt has the options.

namespace planar_chain::simd {
namespace {
constexpr int laneCount = 2;
}  // namespace
}  // namespace planar_chain::simd

#include "linear_kernel.h"
#include "short_kernel.h"
#include "vector_kernel.h"

namespace planar_chain::simd {

const ShortChains shortChains{laneCount, shortChainFor};

extern const Kernel baseline;
const Kernel baseline{"baseline",
                      laneCount,
                      rotations,
                      &shortChains,
                      inwardsAll,
                      outwardsAll,
                      linearizeOutwardsAll,
                      linearizeInwardsAll,
                      linearKernel<Real>,
                      linearKernel<ComplexLanes>,
                      vectorKernel};

}  // namespace planar_chain::simd
