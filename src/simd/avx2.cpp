/// The vector functions for x86-64 with AVX2 and FMA; CMakeLists.txt has the options.

#include "simd/vector_kernel.h"

namespace planar_chain::simd {

const VectorKernel vectorsAvx2 = vectorKernel;

}  // namespace planar_chain::simd
