#pragma once

/// All that a kernel is made of, for the CPU that the including file's compiler options name.

#include "lanes/ensemble_kernel.h"
#include "lanes/general_segment_kernel.h"
#include "lanes/linear_kernel.h"
#include "lanes/series_cart.h"

namespace planar_chain::simd {
namespace {

constexpr Kernel kernelHere(const char* name, const ShortChains* shortChains) {
  return {name,
          laneCount,
          rotations,
          shortChains,
          segmentsAll,
          pinsOfSegments,
          {generalLinks<Ends::none>, generalLinks<Ends::wrench>, generalLinks<Ends::tip>},
          {generalSegments<Ends::none>, generalSegments<Ends::wrench>, generalSegments<Ends::tip>},
          linearKernels<Pack>,
          linearKernels<Lane>,
          {seriesOfOne, seriesOf<Two>, seriesOf<Links<Lane>>, seriesOf<Links<Lane, true>>, seriesOfCart},
          {ensembleOf<OneInEachLane>, ensembleOf<TwoInEachLane>, ensembleOf<Links<Pack>>}};
}

}  // namespace
}  // namespace planar_chain::simd
