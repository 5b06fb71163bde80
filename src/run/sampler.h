#pragma once

/// Measures along a motion, between the ends of its steps, and does not change it.
///
/// The state at a time within a step follows from that at the step's start:
///
///     fixed steps      by one step of the same method, so with an error of the same order
///     adaptive steps   with the scene's tolerance, by dop853 if the motion's own method is explicit; by
///                      rodas5p if it is not, or if dop853 needs more than `mostSteps` steps
///     leaps            by their polynomial (ode/leap.h)
///     where they fail  by one step of ros34pw2, or of the scene's method if its steps are fixed;
///                      if that is not finite, along a straight line
///
/// So a measurement takes a bounded number of steps, whatever the step within which it is. They count in the
/// statistics. Each measurement begins anew: its state depends on the step and the time alone, and sensors do
/// not affect each other. Nothing switches within a step, so f is smooth there.

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "dynamics/dynamics.h"
#include "ode/integrator.h"
#include "run/windings.h"
#include "sensors/sensor_bank.h"

namespace planar_chain {

/// Allocates, but where it says so.
class Sampler {
 public:
  /// The most steps of dop853, and of rodas5p, for one measurement. The motions of the scenes that ship need
  /// up to 100.
  static constexpr int mostSteps = 1000;

  /// These must outlive this object. `dynamics` are those of the motion.
  Sampler(const Scene& scene, Dynamics& dynamics, const Windings& windings);

  SensorBank& bank() { return bank_; }
  /// The scene has another tolerance.
  void useTolerance();
  void saveOrRestore(Snapshot& snapshot) {
    snapshot(bank_);
    for (const auto& each : integrators_) each->saveOrRestore(snapshot);
  }
  /// Adds the steps that the measurements took.
  void countSteps(long long& accepted, long long& rejected) const;

  /// As Integrator::integrate(), for the steps between two checks of energy: takes the measurements that are
  /// due within each.
  ode::Outcome integrate(ode::Integrator& integrator, ode::State& state, double end, double longestStep);
  /// Returns the measurements that were delivered by the time of this state.
  std::vector<Measurement> measure(const ode::State& state);
  /// Takes the measurements that are due by the time of this state.
  void measureAt(const ode::State& state);

 private:
  std::unique_ptr<ode::Integrator> makeIntegrator(const std::string& method) const;
  /// Takes the measurements that are due within the last step, and at its end.
  void measureWithin(const ode::State& from, const ode::State& to, ode::Integrator& last, bool isLeap);
  /// Allocates nothing.
  void moveTo(double t, const ode::State& from, const ode::State& to, const std::string& method);
  void take(const ode::State& state);

  const Scene& scene_;
  Dynamics& dynamics_;
  const Windings& windings_;
  const Coordinates coordinates_ = scene_.chain.coordinates();
  SensorBank bank_{scene_};
  /// dop853, rodas5p, and a method of fixed step, which takes one to any time. Each is tried after those
  /// before it.
  std::array<std::unique_ptr<ode::Integrator>, 3> integrators_;
  ode::State start_, at_;
  Eigen::VectorXd y_;
  std::vector<double> q_, qd_;
  std::vector<LinkMotion> motions_;
};

}  // namespace planar_chain
