#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include "ode/methods.h"
#include "planar_chain/simulation.h"
#include "report/benchmark/counted_system.h"
#include "report/benchmark/measure.h"
#include "report/benchmark/moving_rods.h"

namespace planar_chain::benchmarks {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double interval = 1e-7;  // s: so short that rods hardly move in a whole run and no step is rejected
constexpr double tolerance = 1e-6;
constexpr double tick = 1e-3;         // s
constexpr int ticksBefore = 20;       // until the method has found its step
constexpr int longestWithAuto = 200;  // links: longer chains, undamped, are followed in microseconds
constexpr int stepsCounted = 100;     // one update of local_stiffness.h among them

/// Rods under a method that goes forward by one interval at a time.
class Stepped {
 public:
  Stepped(const std::string& method, int n, ode::SeriesSystem& f, const MovingRods& at)
      : state_(f.sizeInLaneOrder()) {
    std::copy_n(at.laneOrderedY.data(), f.sizeInLaneOrder(), state_.y.data());
    ode::Tolerance allowed{tolerance, Eigen::ArrayXd::Constant(2 * n, infinity)};
    allowed.ceiling.head(n) = 5;
    integrator_ = ode::makeMethod(method, f, interval, allowed);
    step();  // the first one looks for its length
  }
  bool step() { return integrator_->advance(state_, state_.t + interval, infinity) == ode::Outcome::arrived; }
  ode::StepCount count() const { return integrator_->count(); }

 private:
  ode::State state_;
  std::unique_ptr<ode::Integrator> integrator_;
};

/// Evaluations and solves of one step, on average; counted once.
const benchmark::UserCounters& callsOf(const std::string& method, int n) {
  static std::map<std::pair<std::string, int>, benchmark::UserCounters> counted;
  const auto [entry, isNew] = counted.try_emplace({method, n});
  if (!isNew) return entry->second;
  MovingRods at(n, crooked(n));
  CountedSystem f(at.dynamics);
  Stepped stepped(method, n, f, at);
  const CountedSystem before = f;
  for (int k = 0; k < stepsCounted; ++k) stepped.step();
  const auto add = [&, &counters = entry->second](const char* what, long long CountedSystem::*calls) {
    counters[what] = static_cast<double>(f.*calls - before.*calls) / stepsCounted;
  };
  add("evaluations", &CountedSystem::evaluations);
  add("linearizations", &CountedSystem::linearizations);
  add("factors", &CountedSystem::factors);
  add("solves", &CountedSystem::solves);
  add("complex_factors", &CountedSystem::complexFactors);
  add("complex_solves", &CountedSystem::complexSolves);
  return entry->second;
}

/// Evaluations that each wait for the one before: the address of the next state depends on its result.
void measureInARow(benchmark::State& state, int n) {
  MovingRods at(n, crooked(n));
  const double* y = at.laneOrderedY.data();
  double* rates = at.laneOrderedRates.data() + at.dynamics.positions();
  const double& last = rates[at.dynamics.sizeInLaneOrder() - at.dynamics.positions() - 1];
  for (auto _ : state) {
    at.dynamics.rates(0, y, rates);
    y += std::isnan(last) ? 1 : 0;
    benchmark::ClobberMemory();
  }
  if (y != at.laneOrderedY.data()) state.SkipWithError("not a number");
  state.counters["ns_per_link"] = perLink(n);
}

/// Evaluations of a state in chain order.
void measureInOrder(benchmark::State& state, int n) {
  MovingRods at(n, crooked(n));
  for (auto _ : state) {
    at.dynamics.derivative(0, at.y.data(), at.dydt.data());
    benchmark::ClobberMemory();
  }
  state.counters["ns_per_link"] = perLink(n);
}

void measureStep(benchmark::State& state, const std::string& method, int n) {
  MovingRods at(n, crooked(n));
  Stepped stepped(method, n, at.dynamics, at);
  for (auto _ : state) {
    if (!stepped.step()) state.SkipWithError("no single step");
  }
  if (stepped.count().rejected > 0) state.SkipWithError("steps were rejected");
  const benchmark::UserCounters& calls = callsOf(method, n);
  state.counters.insert(calls.begin(), calls.end());
  state.counters["ns_per_link"] = perLink(n);
}

void measureTick(benchmark::State& state, const std::string& method, int n) {
  Scene scene = hanging(n);
  scene.integrator.method = method;
  scene.integrator.step = tick;
  Simulation simulation(scene);
  long long ticks = 0;
  const auto next = [&] { return simulation.advanceTo(static_cast<double>(++ticks) * tick); };
  while (ticks < ticksBefore) next();
  const long long before = simulation.statistics().steps;
  for (auto _ : state) {
    if (!next()) state.SkipWithError(simulation.fault().c_str());
    benchmark::DoNotOptimize(simulation.energyBalance().residual);
  }
  state.counters["ns_per_link"] = perLink(n);
  state.counters["steps"] =
      static_cast<double>(simulation.statistics().steps - before) / static_cast<double>(ticks - ticksBefore);
}

}  // namespace

void registerSteps() {
  for (const int n : sizes()) {
    benchmark::RegisterBenchmark(nameOf("in a row", "evaluation", n).c_str(),
                                 [n](benchmark::State& state) { measureInARow(state, n); });
    benchmark::RegisterBenchmark(nameOf("in order", "evaluation", n).c_str(),
                                 [n](benchmark::State& state) { measureInOrder(state, n); });
    for (const char* method : {"rk4", "dopri5", "dop853", "rodas5p", "ros34pw2", "radau13", "taylor"}) {
      benchmark::RegisterBenchmark(nameOf("step", method, n).c_str(),
                                   [method, n](benchmark::State& state) { measureStep(state, method, n); });
    }
    for (const char* method : {"auto", "ros34pw2_fixed"}) {
      if (std::string(method) == "auto" && n > longestWithAuto) continue;
      benchmark::RegisterBenchmark(nameOf("tick", method, n).c_str(),
                                   [method, n](benchmark::State& state) { measureTick(state, method, n); });
    }
  }
}

}  // namespace planar_chain::benchmarks
