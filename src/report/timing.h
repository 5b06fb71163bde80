#pragma once

/// Time on the processor, and medians of it.

#include <algorithm>
#include <ctime>
#include <vector>

namespace planar_chain::tools {

/// s of this thread on the processor.
inline double threadSeconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The upper one of an even number; of one value at least.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// s that `call` takes.
template <class Call>
double secondsOf(Call&& call) {
  const double start = threadSeconds();
  call();
  return threadSeconds() - start;
}

}  // namespace planar_chain::tools
