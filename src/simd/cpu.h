#pragma once

/// The kinds of CPU that a kernel is compiled for. The program chooses when it starts, so a binary that was
/// built anywhere runs everywhere.

#include <vector>

namespace planar_chain::simd {

/// True if this CPU runs the code of avx2.cpp, or of avx512.cpp.
bool runsAvx2();
bool runsAvx512();

/// The kernels that this CPU runs, the best first; `baseline` runs on every CPU. A kernel that the compiler
/// does not make is nullptr. Allocates.
template <class Kernel>
std::vector<const Kernel*> runnable(const Kernel* avx512, const Kernel* avx2, const Kernel& baseline) {
  std::vector<const Kernel*> found;
  if (avx512 && runsAvx512()) found.push_back(avx512);
  if (avx2 && runsAvx2()) found.push_back(avx2);
  found.push_back(&baseline);
  return found;
}

}  // namespace planar_chain::simd
