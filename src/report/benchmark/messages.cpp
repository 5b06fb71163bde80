#include "ros/view/messages.h"

#include "report/benchmark/chains.h"
#include "report/benchmark/measure.h"

namespace planar_chain::benchmarks {

namespace {

/// Fills one message again and again.
template <class Fill>
void add(const char* what, int n, Fill fill) {
  benchmark::RegisterBenchmark(nameOf("message", what, n).c_str(), [n, fill](benchmark::State& state) {
    const Scene scene = sceneOf(rods(n), crooked(n));
    Simulation simulation(scene);
    Messages messages(simulation, "/planar_chain", false);
    for (auto _ : state) {
      fill(messages, simulation, ros::Time(1));
      benchmark::ClobberMemory();
    }
    state.counters["ns_per_link"] = perLink(n);
  });
}

}  // namespace

void registerMessages() {
  for (const int n : sizes()) {
    add("joint_states", n,
        [](Messages& messages, Simulation&, ros::Time stamp) { messages.jointStates(stamp); });
    add("tf", n, [](Messages& messages, Simulation&, ros::Time stamp) { messages.transforms(stamp); });
    add("link_states", n,
        [](Messages& messages, Simulation&, ros::Time stamp) { messages.linkStates(stamp); });
    add("status", n, [](Messages&, Simulation& simulation, ros::Time) {
      SimStatus status;
      describe(simulation, status);
      benchmark::DoNotOptimize(status);
    });
  }
}

}  // namespace planar_chain::benchmarks
