#pragma once

/// The kinds of CPU that a kernel is compiled for. The program chooses when it starts, so a binary that was
/// built anywhere runs everywhere.

#include <vector>

namespace planar_chain::simd {

/// True if this CPU runs the code of avx2.cpp, or of avx512.cpp.
bool runsAvx2();
bool runsAvx512();

/// While one that is on exists, this thread chooses the baseline kernels. They have no fused multiplication,
/// and give the same digits on every x86-64 CPU. The environment variable PLANAR_CHAIN_PLAIN_KERNEL=1 does
/// the same for the whole program.
class PlainKernels {
 public:
  explicit PlainKernels(bool on);
  ~PlainKernels();
  PlainKernels(const PlainKernels&) = delete;
  PlainKernels& operator=(const PlainKernels&) = delete;

  static bool areOn();

 private:
  bool before_;
};

/// The kernels to choose from, the best first; `baseline` runs on every CPU. A kernel that the compiler does
/// not make is nullptr. The first call for each type allocates.
template <class Kernel>
const std::vector<const Kernel*>& runnable(const Kernel* avx512, const Kernel* avx2, const Kernel& baseline) {
  static const auto all = [&] {
    std::vector<const Kernel*> found;
    if (avx512 && runsAvx512()) found.push_back(avx512);
    if (avx2 && runsAvx2()) found.push_back(avx2);
    found.push_back(&baseline);
    return found;
  }();
  static const std::vector<const Kernel*> plain{&baseline};
  return PlainKernels::areOn() ? plain : all;
}

}  // namespace planar_chain::simd
