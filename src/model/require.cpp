#include "model/require.h"

#include <cmath>

namespace planar_chain {

void requireNumber(std::vector<Fault>& faults, const std::string& path, double given, bool isInRange,
                   const std::string& which) {
  if (std::isfinite(given) && isInRange) return;
  // What is no number at all is asked for a number, ±∞ for a finite one.
  faults.push_back({path, (std::isinf(given) ? "a finite number" : "a number") + which, toText(given)});
}

}  // namespace planar_chain
