#pragma once

/// The kinds of CPU that a kernel is compiled for. The program chooses when it starts, so a binary that was
/// built anywhere runs everywhere.

#include <vector>

namespace planar_chain::simd {

/// True if this CPU runs the code of avx2.cpp, or of avx512.cpp.
bool runsAvx2();
bool runsAvx512();

/// The kernels to choose from: those of this CPU, or the plain ones. The latter have no fused multiplication,
/// and give the same digits on every x86-64 CPU.
struct KernelChoice {
  bool isPlain = false;
};

/// True if the environment variable PLANAR_CHAIN_PLAIN_KERNEL=1 chooses the plain kernels for the whole
/// program.
bool allArePlain();

/// The kernels to choose from, the best first; `baseline` runs on every CPU, and is the plain one. A kernel
/// that the compiler does not make is nullptr. The first call for each type allocates.
template <class Kernel>
const std::vector<const Kernel*>& runnable(const Kernel* avx512, const Kernel* avx2, const Kernel& baseline,
                                           KernelChoice choice) {
  static const auto all = [&] {
    std::vector<const Kernel*> found;
    if (avx512 && runsAvx512()) found.push_back(avx512);
    if (avx2 && runsAvx2()) found.push_back(avx2);
    found.push_back(&baseline);
    return found;
  }();
  static const std::vector<const Kernel*> plain{&baseline};
  return choice.isPlain || allArePlain() ? plain : all;
}

}  // namespace planar_chain::simd
