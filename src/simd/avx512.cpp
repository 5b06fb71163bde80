/// For x86-64 with AVX-512; CMakeLists.txt has the options.

#include <immintrin.h>

namespace planar_chain::simd {
namespace {
constexpr int laneCount = 8;
}  // namespace
}  // namespace planar_chain::simd

#include "linear_kernel.h"

namespace planar_chain::simd {

extern const Kernel avx512;
const Kernel avx512{"avx512",
                    laneCount,
                    rotations,
                    inwardsAll,
                    outwardsAll,
                    linearizeOutwardsAll,
                    linearizeInwardsAll,
                    linearKernel<Real>,
                    linearKernel<ComplexLanes>};

}  // namespace planar_chain::simd
