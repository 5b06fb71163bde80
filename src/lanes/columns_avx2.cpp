/// The columns of derivatives for x86-64 with AVX2 and FMA; CMakeLists.txt has the options.

#include "lanes/column_kernel.h"

namespace planar_chain::simd {

const ColumnKernel columnsAvx2 = columnKernel;

}  // namespace planar_chain::simd
