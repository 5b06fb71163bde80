/// For every CPU; CMakeLists.txt has the options.

namespace planar_chain::simd {
namespace {
constexpr int laneCount = 2;
}  // namespace
}  // namespace planar_chain::simd

#include "simd/vector_kernel.h"

namespace planar_chain::simd {

extern const VectorKernel vectorsBaseline;
const VectorKernel vectorsBaseline = vectorKernel;

}  // namespace planar_chain::simd
