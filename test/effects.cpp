/// What each effect costs: an evaluation and a tick (5 ms, five steps of rk4) of the bare chain, which has
/// none, and of the same chain with that one; and each message. A program, not a test; effects.py makes a
/// table of it.

#include "effects.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "counted.h"
#include "dynamics/dynamics.h"
#include "ode/methods.h"
#include "planar_chain/simulation.h"

using namespace planar_chain;
using test::Operation;

namespace {

constexpr double tick = 0.005;  // s
constexpr double step = 0.001;  // s
constexpr double forever = std::numeric_limits<double>::infinity();

// ---- Scenes ----------------------------------------------------------------------------------

struct Parts {
  std::vector<Link> links;
  std::vector<Joint> joints;
  Vec2d gravity;
  std::vector<Load> loads;
};

struct Effect {
  const char* name;
  void (*add)(Parts&);
};

void addLimits(Parts& parts, double lower) {
  for (Joint& joint : parts.joints) {
    joint.lower = lower;
    joint.upper = 1000;
    joint.stopStiffness = joint.stopDamping = 0.001;
  }
}

Load& addLoad(Parts& parts) {
  parts.loads.emplace_back();
  parts.loads.back().name = "load_" + std::to_string(parts.loads.size());
  return parts.loads.back();
}

void addGravity(Parts& parts) {
  parts.gravity = {0, -9.81};
}
void addOffsets(Parts& parts) {
  for (Link& link : parts.links) link.com.y = link.pin.y = 0.1;
}
void addSprings(Parts& parts) {
  for (Joint& joint : parts.joints) joint.stiffness = 1;
}
void addDampers(Parts& parts) {
  for (Joint& joint : parts.joints) joint.damping = 0.01;
}
void addTorque(Parts& parts) {
  Load& load = addLoad(parts);
  load.joint = static_cast<int>(parts.joints.size() / 2);
  load.torque = 0.1;
}
void addForce(Parts& parts) {
  Load& load = addLoad(parts);
  load.link = static_cast<int>(parts.links.size()) - 1;
  load.force = {0, 0.1};
  load.point = {1, 0};
}
void addSine(Parts& parts) {
  addTorque(parts);
  parts.loads.back().law = Sine{1, 0};
}
void addFarLimits(Parts& parts) {
  addLimits(parts, -1000);
}
void addLimitsPushed(Parts& parts) {
  addLimits(parts, 0.3);  // deep enough to stay there
}
void addNothing(Parts&) {}
void addAll(Parts& parts) {
  for (const auto add : {addGravity, addOffsets, addSprings, addDampers, addForce, addSine, addFarLimits}) {
    add(parts);
  }
}

constexpr Effect effects[] = {{"bare", addNothing},
                              {"gravity", addGravity},
                              {"offsets", addOffsets},
                              {"springs", addSprings},
                              {"dampers", addDampers},
                              {"torque in one joint", addTorque},
                              {"the same as a sine", addSine},
                              {"force at the tip", addForce},
                              {"limits, none reached", addFarLimits},
                              {"limits, all pushed", addLimitsPushed},
                              {"all, no limit reached", addAll}};

/// n rods of 1 m, bent by up to 0.1 rad in each joint and turning by up to 0.1 rad/s.
Scene sceneOf(int n, const Effect& effect) {
  Parts parts;
  std::vector<double> q, qd;
  for (int i = 1; i <= n; ++i) {
    parts.links.push_back({"link_" + std::to_string(i), 1, 1. / 12, {0.5, 0}, {1, 0}});
    parts.joints.push_back({"joint_" + std::to_string(i)});
    q.push_back(0.1 * std::sin(7. * i));
    qd.push_back(0.1 * std::cos(5. * i));
  }
  effect.add(parts);
  return {Chain(parts.links, parts.joints, parts.gravity), q, qd, parts.loads, {"rk4", 1e-8, step}, {}, 0};
}

// ---- What is measured ------------------------------------------------------------------------

struct Evaluated {
  explicit Evaluated(const Scene& given) : scene(given), dynamics(scene), y(dynamics.size()), slope(y) {
    const int n = scene.chain.size();
    double theta = 0, omega = 0;
    for (int i = 0; i < n; ++i) {
      y[i] = theta += scene.q[static_cast<std::size_t>(i)];
      y[n + i] = omega += scene.qd[static_cast<std::size_t>(i)];
    }
    y.tail(dynamics.works()).setZero();
    dynamics.enterState(y.data());
  }
  Scene scene;
  Dynamics dynamics;
  Eigen::VectorXd y, slope;
};

/// The integrator alone, which no guard watches.
struct Unguarded : Evaluated {
  explicit Unguarded(const Scene& given) : Evaluated(given), start(dynamics, y), state(start) {
    const ode::Tolerance tolerance{1, Eigen::ArrayXd::Constant(2 * scene.chain.size(), forever)};
    integrator = ode::makeMethod("rk4", dynamics, step, tolerance);
  }
  ode::State start, state;
  std::unique_ptr<ode::Integrator> integrator;
};

std::vector<Operation> operationsOf(int n) {
  std::vector<Operation> operations;
  for (const Effect& effect : effects) {
    const auto evaluated = std::make_shared<Evaluated>(sceneOf(n, effect));
    operations.push_back(
        {"evaluation", effect.name, [] {},
         [evaluated] { evaluated->dynamics.derivative(0, evaluated->y.data(), evaluated->slope.data()); }});
  }
  const auto addTicks = [&](const std::string& name, std::shared_ptr<Simulation> simulation) {
    operations.push_back({"tick", name, [simulation] { simulation->reset(); },
                          [simulation] { simulation->advanceTo(simulation->time() + tick); }});
  };
  for (const Effect& effect : effects)
    addTicks(effect.name, std::make_shared<Simulation>(sceneOf(n, effect)));
  addTicks("room for commands", std::make_shared<Simulation>(sceneOf(n, effects[0]), 256));
  const auto unguarded = std::make_shared<Unguarded>(sceneOf(n, effects[0]));
  operations.push_back({"tick", "no energy guard", [unguarded] { unguarded->state = unguarded->start; },
                        [unguarded] {
                          ode::State& state = unguarded->state;
                          unguarded->integrator->integrate(state, state.t + tick, forever);
                        }});
#ifdef PLANAR_CHAIN_MESSAGES
  for (const Operation& message : test::messagesOf(sceneOf(n, effects[0]))) operations.push_back(message);
#endif
  return operations;
}

// ---- Time ------------------------------------------------------------------------------------

double nanosecondsOf(const Operation& operation, int times) {
  operation.prepare();
  const auto start = std::chrono::steady_clock::now();
  counted(operation.run, times);
  const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - start;
  return taken.count() / times;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// So many calls that they take about half a millisecond.
int timesOf(const Operation& operation) {
  nanosecondsOf(operation, 1);
  return std::max(1, static_cast<int>(5e5 / nanosecondsOf(operation, 2)));
}

void measure(int n, const std::vector<Operation>& operations, int repetitions) {
  std::vector<int> times;
  for (const Operation& operation : operations) times.push_back(timesOf(operation));
  std::vector<std::vector<double>> taken(operations.size()), ratios(operations.size());
  for (int k = 0; k < repetitions; ++k) {
    std::map<std::string, double> bare;  // a message stands beside a tick
    for (std::size_t i = 0; i < operations.size(); ++i) {
      const Operation& operation = operations[i];
      const double ns = nanosecondsOf(operation, times[i]);
      if (operation.effect == "bare") bare[operation.table] = bare["message"] = ns;
      taken[i].push_back(ns);
      ratios[i].push_back(ns / bare[operation.table]);
    }
  }
  for (std::size_t i = 0; i < operations.size(); ++i) {
    std::printf("%s,\"%s\",%d,%.6g,%.4f\n", operations[i].table.c_str(), operations[i].effect.c_str(), n,
                median(taken[i]), median(ratios[i]));
  }
}

}  // namespace

/// effects REPETITIONS: lines of table, effect, links, ns, ratio to the bare chain: medians of so many
/// repetitions, in which all take their turns. 0: each is called for callgrind to count, some times, which
/// stand for ns.
int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const int repetitions = std::atoi(argv[1]);
  for (const int n : {2, 10, 100, 1000}) {
    const std::vector<Operation> operations = operationsOf(n);
    if (repetitions > 0) {
      measure(n, operations, repetitions);
      continue;
    }
    for (const Operation& operation : operations) {
      constexpr int times = 4;
      operation.run();
      operation.prepare();
      counted(operation.run, times);
      std::printf("%s,\"%s\",%d,%d\n", operation.table.c_str(), operation.effect.c_str(), n, times);
    }
  }
}
