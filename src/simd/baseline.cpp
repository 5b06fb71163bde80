/// The vector functions for every CPU; CMakeLists.txt has the options.

#include "simd/vector_kernel.h"

namespace planar_chain::simd {

const VectorKernel vectorsBaseline = vectorKernel;

}  // namespace planar_chain::simd
