#pragma once

/// The kinds of CPU that a kernel is compiled for. Which one runs is found out when the program starts, so a
/// binary built anywhere runs everywhere.

#include <array>
#include <cstddef>

namespace planar_chain::simd {

/// One of each kind that this CPU can run, the best first. The last one runs on every CPU. Null pointers fill
/// up the array.
template <class Kernel>
using Kernels = std::array<const Kernel*, 3>;

/// True if this CPU can run what is compiled with the options of avx2.cpp, or of avx512.cpp.
bool runsAvx2();
bool runsAvx512();

/// avx512, avx2: nullptr where the compiler makes none.
template <class Kernel>
Kernels<Kernel> runnable(const Kernel* avx512, const Kernel* avx2, const Kernel& baseline) {
  Kernels<Kernel> found{};
  std::size_t count = 0;
  if (avx512 && runsAvx512()) found[count++] = avx512;
  if (avx2 && runsAvx2()) found[count++] = avx2;
  found[count] = &baseline;
  return found;
}

/// The best for so many numbers: 8 lanes are too many for few.
template <class Kernel>
const Kernel& bestFor(const Kernels<Kernel>& kernels, std::ptrdiff_t size) {
  constexpr std::ptrdiff_t few = 64;  // for 8 lanes; 4 suit all
  return kernels[0]->lanes == 8 && size < few ? *kernels[1] : *kernels[0];
}

}  // namespace planar_chain::simd
