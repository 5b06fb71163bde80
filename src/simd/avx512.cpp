/// For x86-64 with AVX-512; CMakeLists.txt has the options.

#include <immintrin.h>

namespace planar_chain::simd {
namespace {
constexpr int laneCount = 8;
}  // namespace
}  // namespace planar_chain::simd

#include "simd/vector_kernel.h"

namespace planar_chain::simd {

extern const VectorKernel vectorsAvx512;
const VectorKernel vectorsAvx512 = vectorKernel;

}  // namespace planar_chain::simd
