#include "planar_chain/short_chain.h"

#include "planar_chain/segments.h"
#include "simd/kernel.h"

namespace planar_chain {

const int ShortChain::most = simd::ShortChains::most;

int ShortChain::roomFor(int n) {
  return n + simd::SegmentHandles::most;
}

ShortChain::ShortChain(const Chain& chain, const simd::Kernel* kernel) : n_(chain.size()) {
  const simd::ShortChains& kind = *(kernel ? *kernel : *simd::kernels().front()).shortChains;
  for (const Acting acting : {Acting::nothing, Acting::moments, Acting::forces}) {
    runs_[static_cast<std::size_t>(acting)] = kind.runFor(n_, acting);
  }
  links_ = linksInBlocks(chain, kind.lanes);
}

std::string ShortChain::name() const {
  if (n_ == 2) return "closed form for two";
  if (n_ > simd::ShortChains::mostUnrolled) return "link by link";
  return "link by link, written out for " + std::to_string(n_);
}

}  // namespace planar_chain
