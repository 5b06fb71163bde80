/// How long everything takes that runs again and again: see measure.h for the names and counters, `run` for
/// the tables.

#include "report/benchmark/measure.h"
#include "report/benchmark/peer.h"

int main(int argc, char** argv) {
  using namespace planar_chain::benchmarks;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  for (const PeerKind& peer : peers()) {
    if (!peer.version.empty()) benchmark::AddCustomContext(peer.name, peer.version);
  }
  registerEvaluations();
  registerSolves();
  registerSteps();
#ifdef WITH_ROS
  registerMessages();
#endif
  benchmark::RunSpecifiedBenchmarks();
  return allAgreed() ? 0 : 1;
}
