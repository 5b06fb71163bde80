#pragma once

/// Many simulations at once: the same scene from other starts, with other masses, other loads.
///
/// It uses all cores. Chains of up to twelve links with nothing but pins, gravity, linear springs and dampers
/// run in SIMD lanes, one run in each, if the scene's method is auto or taylor. Every other run is a
/// Simulation of its own. The results of a run depend neither on the number of threads nor on the other runs.

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "planar_chain/scene.h"
#include "planar_chain/value.h"

namespace planar_chain {

class SavedState;

struct BatchOptions {
  int threads = 0;  ///< 0: one per core
  /// Runs at a time in a thread, at most. 0: as many as the CPU can; 1: every run is a Simulation of its own.
  int lanes = 0;
  /// Steps of one run, at most; more fail. Absent: a million for each second, and at least a million, for
  /// a method of fixed step besides the chosen ones.
  std::optional<long long> mostSteps{};
  /// Commanded torques, N m, and forces of prismatic joints, N. Number (run × times + k) × n + j is held in
  /// joint j from times[k − 1], or from 0, to times[k], as by Simulation::holdTorque(). Empty: none.
  std::vector<double> torques{};
  /// If given, every run begins in this state, which a Simulation of the scene saved and which outlives the
  /// call, and goes on as after Simulation::restore(), bit for bit. Times are those of that simulation, from
  /// the state's on. A run is then a Simulation of its own.
  const SavedState* state = nullptr;
  /// If given, it is called about ten times a second from the calling thread, with the number of runs that
  /// have ended. Cancels the batch by returning false.
  std::function<bool(std::size_t ended)> keepGoing{};
};

enum class RunOutcome {
  done,       ///< all times were reached
  failed,     ///< the scene was refused, or the integration failed: see `reason`
  cancelled,  ///< keepGoing returned false before the end
};

struct BatchRun {
  RunOutcome outcome = RunOutcome::cancelled;
  std::string reason;   ///< one line; empty unless the run failed
  std::string notes{};  ///< one line: those of its scene that the scene of the batch does not have
  long long steps = 0;  ///< accepted
};

struct BatchResult {
  /// states[(run × times + k) × 2n]: the relative angles q (rad), then their rates (rad/s), at times[k]. NaN
  /// for times that a failed or cancelled run did not reach.
  std::vector<double> states;
  std::vector<BatchRun> runs;
};

/// Changes a copy of the scene for one run: the start q and qd, the chain, loads. It is called once per run,
/// from several threads at once. If it throws a std::exception, the run fails for that reason.
using SceneOfRun = std::function<void(std::size_t run, Scene& scene)>;

/// The numbers that differ between runs, by the number of the run.
struct Varied {
  std::vector<double> starts;                          ///< 2n numbers per run, q and then qd; or none
  std::map<std::string, std::vector<double>> numbers;  ///< one per run, by a path such as "links/lower/mass"
};

/// Returns the function that makes the scene of each run. Both arguments must outlive it. tree: the values of
/// the scene.
/// @throws Refused with all faults, if a path cannot hold a number, or is an initial angle or velocity while
/// `starts` are given
SceneOfRun sceneOfRun(const Value& tree, const Varied& varied);

/// @throws Refused with a fault for each time that is not finite, negative, or before the one before it
void requireTimes(const std::vector<double>& times);

/// Simulates `runs` scenes from time 0, each with as many links as `scene`. times: s, ≥ 0, never falling.
/// @throws std::invalid_argument for other times, a negative number of threads or lanes, and torques of a
/// wrong number, that are not from -1e100 to 1e100, or not 0 in a driven joint; for a state of another scene,
/// or beside torques one of a simulation without commands
BatchResult simulateMany(const Scene& scene, std::size_t runs, const SceneOfRun& sceneOfRun,
                         const std::vector<double>& times, const BatchOptions& options = {});

/// Simulates one scene from other starts: 2n numbers per run, q and then qd.
/// @throws std::invalid_argument also if `starts` does not hold whole runs
BatchResult simulateMany(const Scene& scene, const std::vector<double>& starts,
                         const std::vector<double>& times, const BatchOptions& options = {});

}  // namespace planar_chain
