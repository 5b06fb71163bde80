#pragma once

/// The measurements, as benchmarks of Google's library. Names are group/what/n, such as
/// "evaluation/crooked/Bullet/100"; the counter ns_per_link is the time over n, `difference` the largest one
/// of q̈ from this program's, in units of the largest q̈.

#include <benchmark/benchmark.h>

#include <string>

namespace planar_chain::benchmarks {

/// Evaluations of q̈: this program's and its peers'.
void registerEvaluations();
/// False when a peer that has been measured computed another motion.
bool allAgreed();
/// linearize, factor and solve; in segments and link by link.
void registerSolves();
/// One step of each method; one tick of the simulation.
void registerSteps();
#ifdef WITH_ROS
/// The messages of one tick of the node.
void registerMessages();
#endif

/// Time over n × times, in ns.
inline benchmark::Counter perLink(int n) {
  return benchmark::Counter(1e-9 * n,
                            benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

inline std::string nameOf(const std::string& group, const std::string& what, int n) {
  return group + "/" + what + "/" + std::to_string(n);
}

}  // namespace planar_chain::benchmarks
