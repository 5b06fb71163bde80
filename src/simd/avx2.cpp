/// For x86-64 with AVX2 and FMA; CMakeLists.txt has the options.

#include <immintrin.h>

namespace planar_chain::simd {
namespace {
constexpr int laneCount = 4;
}  // namespace
}  // namespace planar_chain::simd

#include "simd/vector_kernel.h"

namespace planar_chain::simd {

extern const VectorKernel vectorsAvx2;
const VectorKernel vectorsAvx2 = vectorKernel;

}  // namespace planar_chain::simd
