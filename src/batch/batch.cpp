#include "planar_chain/batch.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "batch/ensemble.h"
#include "dynamics/given_state.h"
#include "model/number_rule.h"
#include "planar_chain/simulation.h"
#include "run/step_budget.h"

namespace planar_chain {

namespace {

void requireCounts(const BatchOptions& options) {
  std::vector<Fault> faults;
  for (const auto& [name, number] : {std::pair("threads", options.threads), {"lanes", options.lanes}}) {
    if (number < 0) faults.push_back({name, "a number >= 0", std::to_string(number)});
  }
  if (!faults.empty()) throw Refused(std::move(faults));
}

bool isDriven(const Scene& scene, int joint) {
  return std::any_of(scene.drives.begin(), scene.drives.end(),
                     [joint](const Drive& drive) { return drive.joint == joint; });
}

/// Names the first fault of each joint.
void requireTorques(const Scene& scene, std::size_t runs, std::size_t times,
                    const std::vector<double>& torques) {
  if (torques.empty()) return;
  const std::size_t n = index(scene.chain.size());
  if (torques.size() != runs * times * n) {
    throw Refused({{"torques",
                    std::to_string(runs) + " x " + std::to_string(times) + " x " + std::to_string(n) +
                        " numbers, for each run, time and joint",
                    std::to_string(torques.size())}});
  }
  std::vector<Fault> faults;
  for (std::size_t j = 0; j < n; ++j) {
    const bool isGiven = isDriven(scene, static_cast<int>(j));
    std::size_t k = j;
    while (k < torques.size() && (isGiven ? torques[k] == 0 : isFactor(torques[k]))) k += n;
    if (k >= torques.size()) continue;
    const std::string place = std::to_string(k / n / times) + "/" + std::to_string(k / n % times) + "/";
    faults.push_back(
        {"torques/" + place + std::to_string(j),
         isGiven ? "0 N m in a driven joint" : factorInWords(torques[k]) + std::string(", in N m"),
         toText(torques[k])});
  }
  if (!faults.empty()) throw Refused(std::move(faults));
}

/// The state of this scene.
void requireState(const Scene& scene, const std::vector<double>& times, const BatchOptions& options) {
  if (!options.state) return;
  const std::unique_ptr<Simulation> start = Simulation::in(*options.state, scene);
  if (!times.empty() && times.front() < start->time()) {
    throw Refused({{"times/0", "a number >= " + toText(start->time()) + " s, the time of the state",
                    toText(times.front())}});
  }
  if (!options.torques.empty() && start->cutOffs().empty())
    throw Refused({{"state", "one of a simulation with commands, beside torques", "one without"}});
}

/// Holds these torques from now on.
void hold(Simulation& simulation, const double* torques) {
  for (int j = 0; j < simulation.scene().chain.size(); ++j) {
    if (torques[j] == 0 && isDriven(simulation.scene(), j)) continue;
    if (!simulation.holdTorque(j, torques[j], std::numeric_limits<double>::infinity()))
      throw std::domain_error("there is no room for a torque beside the commands of the state");
  }
}

/// In its first state.
std::unique_ptr<Simulation> simulationOf(Runs& runs, std::size_t run, const Scene& scene) {
  if (runs.options.state) return Simulation::in(*runs.options.state, scene);
  auto simulation = std::make_unique<Simulation>(scene, runs.haveTorques() ? 1 : 0);
  if (const std::string moved = movedWords("", scene.chain, scene.q.data(), simulation->q().data());
      !moved.empty())
    runs.add(run, moved);
  return simulation;
}

void simulate(Runs& runs, std::size_t run, const Scene& scene) {
  double* const states = runs.stateOf(run, 0);  // those of a lane that was given up
  std::fill_n(states, runs.times.size() * runs.stateSize(), std::numeric_limits<double>::quiet_NaN());
  try {
    const std::unique_ptr<Simulation> its = simulationOf(runs, run, scene);
    Simulation& simulation = *its;
    const long long before = simulation.statistics().steps;
    const StepBudget budget(simulation, runs.duration(), runs.options.mostSteps);
    const auto isWanted = [&] { return !runs.cancelled && budget.isLeft(); };
    bool arrives = true;
    for (std::size_t k = 0; k < runs.times.size() && arrives; ++k) {
      if (runs.haveTorques() && runs.times[k] > simulation.time()) hold(simulation, runs.torquesOf(run, k));
      arrives = simulation.advanceTo(runs.times[k], isWanted);
      if (!arrives) break;
      const auto rates = std::copy(simulation.q().begin(), simulation.q().end(), runs.stateOf(run, k));
      std::copy(simulation.qd().begin(), simulation.qd().end(), rates);
    }
    runs.result.runs[run].steps = simulation.statistics().steps - before;
    if (!simulation.fault().empty()) return runs.fail(run, simulation.fault());
    if (!arrives && !runs.cancelled) return runs.fail(run, budget.reason());
    runs.end(run, arrives ? RunOutcome::done : RunOutcome::cancelled);
  } catch (const std::exception& refusal) {
    runs.fail(run, refusal);
  }
}

/// The work of each thread.
void work(Runs& runs, const Scene& scene, int mostLanes) {
  std::optional<Ensemble> lanes;
  const simd::Kernel* kernel = runs.options.state ? nullptr : Ensemble::kernelFor(scene, mostLanes);
  if (kernel) lanes.emplace(scene, runs, *kernel);
  for (;;) {
    // Fill the lanes.
    while (!lanes || !lanes->areFull()) {
      const std::optional<std::size_t> run = runs.takeNext();
      if (!run) break;
      std::optional<Scene> its = runs.sceneOf(*run);
      if (its && lanes && lanes->takes(*its)) {
        lanes->begin(*run, std::move(*its));
      } else if (its) {
        simulate(runs, *run, *its);
      }
    }
    if (!lanes || lanes->areEmpty()) return;

    for (const Ensemble::Given& given : lanes->step()) simulate(runs, given.run, given.scene);
  }
}

/// The threads of a batch. They end with this object, at the latest a few steps later.
class Workers {
 public:
  explicit Workers(Runs& runs) : runs_(runs) {}
  ~Workers() {
    runs_.cancelled = true;
    for (std::thread& thread : threads_) thread.join();
  }
  void start(const Scene& scene, int mostLanes) {
    ++working_;
    threads_.emplace_back([this, &scene, mostLanes] {
      work(runs_, scene, mostLanes);
      const std::lock_guard<std::mutex> lock(mutex_);
      --working_;
      done_.notify_one();
    });
  }
  /// Returns true if all of them are done within this time.
  bool areDoneWithin(std::chrono::milliseconds time) {
    std::unique_lock<std::mutex> lock(mutex_);
    return done_.wait_for(lock, time, [this] { return working_ == 0; });
  }

 private:
  Runs& runs_;
  std::mutex mutex_;
  std::condition_variable done_;
  std::atomic<int> working_{0};
  std::vector<std::thread> threads_;
};

}  // namespace

void requireTimes(const std::vector<double>& times) {
  std::vector<Fault> faults;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double least = k > 0 && times[k - 1] > 0 ? times[k - 1] : 0;
    if (std::isfinite(times[k]) && times[k] >= least) continue;
    faults.push_back({"times/" + std::to_string(k),
                      "a finite number >= " + toText(least) + " s (times start from 0 and never fall)",
                      toText(times[k])});
  }
  if (!faults.empty()) throw Refused(std::move(faults));
}

BatchResult simulateMany(const Scene& scene, std::size_t runs, const SceneOfRun& sceneOfRun,
                         const std::vector<double>& times, const BatchOptions& options) {
  requireCounts(options);
  requireTimes(times);
  requireTorques(scene, runs, times.size(), options.torques);
  requireState(scene, times, options);
  const auto cores = options.threads > 0 ? static_cast<unsigned>(options.threads)
                                         : std::max(1u, std::thread::hardware_concurrency());

  Runs all(scene, runs, sceneOfRun, times, options);
  {
    Workers workers(all);
    for (std::size_t k = 0; k < std::min<std::size_t>(cores, runs); ++k) {
      workers.start(scene, options.lanes);
    }
    while (!workers.areDoneWithin(std::chrono::milliseconds(100))) {
      if (options.keepGoing && !all.cancelled && !options.keepGoing(all.ended)) all.cancelled = true;
    }
  }
  return std::move(all.result);
}

BatchResult simulateMany(const Scene& scene, const std::vector<double>& starts,
                         const std::vector<double>& times, const BatchOptions& options) {
  const std::size_t n = index(scene.chain.size());
  if (starts.size() % (2 * n) != 0) {
    throw Refused({{"starts", std::to_string(2 * n) + " numbers a run", std::to_string(starts.size())}});
  }
  const Value none;
  const Varied varied{starts, {}};
  return simulateMany(scene, starts.size() / (2 * n), sceneOfRun(none, varied), times, options);
}

}  // namespace planar_chain
