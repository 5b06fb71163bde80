/// The columns of derivatives for x86-64 with AVX-512; CMakeLists.txt has the options.

#include "lanes/column_kernel.h"

namespace planar_chain::simd {

const ColumnKernel columnsAvx512 = columnKernel;

}  // namespace planar_chain::simd
