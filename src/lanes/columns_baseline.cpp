/// The columns of derivatives for every CPU.

#include "lanes/column_kernel.h"

namespace planar_chain::simd {

const ColumnKernel columnsBaseline = columnKernel;

}  // namespace planar_chain::simd
