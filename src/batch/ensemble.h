#pragma once

/// An ensemble: runs of a batch, one in each SIMD lane. See lanes/ensemble_kernel.h.
///
/// Each lane goes its own steps along its own Taylor series, so no result depends on the other lanes. With
/// the shortest step of all lanes for all, 32 double pendulums took 1.8 times as many steps in four lanes
/// and 2.3 times in eight, and 1.7 times the time (`batches 32`, with h_ set to its minimum in step()).
/// States between steps come from the series: output shortens no step. A lane that has ended takes the next
/// run. Some runs are given up: those that are stiff, whose angles make many turns, whose energy balance does
/// not close, or that fail. A Simulation begins them anew. Where torques are held, a step ends with each
/// interval: the next one has a series of its own, and no estimate looks across the jump.

#include <optional>
#include <vector>

#include "batch/runs.h"
#include "lanes/motion_series.h"
#include "run/energy_guard.h"
#include "simd/cache_lines.h"

namespace planar_chain {

class Ensemble {
 public:
  /// For runs of scenes like this one.
  Ensemble(const Scene& like, Runs& runs, const simd::Kernel& kernel);
  /// The best kernel of this CPU with at most so many lanes; 0: any. Nothing if such scenes do not run in
  /// lanes.
  static const simd::Kernel* kernelFor(const Scene& scene, int mostLanes);

  /// True if this scene may run in a lane.
  bool takes(const Scene& scene) const;
  bool areFull() const { return inUse_ == lanes_.size(); }
  bool areEmpty() const { return inUse_ == 0; }
  /// Needs a free lane.
  void begin(std::size_t run, Scene scene);

  struct Given {
    std::size_t run;
    Scene scene;
  };
  /// One step of all lanes. Returns the runs that are given up.
  std::vector<Given> step();

 private:
  struct Lane {
    std::optional<Given> given;  ///< nothing: this lane is free
    double t = 0, end = 0;       ///< of the step
    std::size_t next = 0;        ///< of the times
    std::size_t held = 0;        ///< the time until which the present torques are held
    double supplied = 0;         ///< W_s less the work that the present torques do from q = 0 on, J
    long long steps = 0;
    double turned = 0;  ///< about the angles that the steps have turned, rad
    std::optional<EnergyCheck> balance{};
    double dissipated = 0;    ///< W_d, J
    long long unchecked = 0;  ///< steps since the balance was checked
  };

  static constexpr double mostRate = 1e100;  ///< rad/s: the square is finite

  simd::EnsembleArrays arrays();
  std::size_t place(int i, std::size_t lane) const { return index(i) * lanes_.size() + lane; }
  /// Holds the torques of the interval that begins now.
  void holdTorques(std::size_t lane);
  /// At q = 0.
  double& torqueIn(int joint, std::size_t lane) {
    return joints_[place(simd::EnsembleArrays::jointQuantities * joint + 2, lane)];
  }
  void findTurningTimes(const simd::EnsembleArrays& all);
  void writeStates();
  bool isHopeless(std::size_t lane);
  /// False if the energy balance of this lane does not close. At time 0 it starts there.
  bool balances(std::size_t lane);
  /// Integrates the dampers' power over the step `ahead_`.
  void dissipate(const simd::EnsembleArrays& all);

  Runs& runs_;
  const IntegratorSettings settings_;
  const long long mostSteps_;  ///< of a run
  const int n_ = runs_.n;
  const simd::Kernel& kernel_;
  const simd::EnsembleKernel& run_;
  const int order_;
  /// Gauss's rule for W_d. Its error is about 1e-12: steps are short for the radius of convergence.
  const Eigen::MatrixX2d rule_;
  const simd::StepControl control_;
  SeriesStorage series_;
  std::vector<Lane> lanes_;
  std::vector<double> state_;  ///< of one lane
  std::size_t inUse_ = 0;
  std::vector<double> steady_, limits_;  ///< torques at q = 0 but for those held, and their limits, N m
  CacheLines ground_, joints_, N_, c_, carry_, h_, ahead_, within_, power_, turning_, direction_, scratch_,
      states_;
};

}  // namespace planar_chain
