#pragma once

/// Measures along a motion, between the ends of its steps, and does not change it.
///
/// The state at a time within a step follows from that at the step's start, by shorter steps of an integrator
/// of its own with the scene's tolerance: dop853, or rodas5p if the motion's own method is implicit. It
/// begins anew each time, because it adapts as it runs. Nothing switches within a step, so f is smooth there.
/// The state depends on the step and the time alone. So sensors do not affect each other.

#include <memory>
#include <string>
#include <vector>

#include "dynamics/dynamics.h"
#include "ode/integrator.h"
#include "run/turns.h"
#include "sensors/sensor_bank.h"

namespace planar_chain {

/// Allocates, but where it says so.
class Sampler {
 public:
  /// These must outlive this object. `dynamics` are those of the motion.
  Sampler(const Scene& scene, Dynamics& dynamics, const Turns& turns);

  SensorBank& bank() { return bank_; }
  /// The scene has another tolerance.
  void useTolerance();
  /// Evaluations of f that the measurements took.
  long long evaluations() const { return evaluations_; }

  /// As Integrator::integrate(), for the steps between two checks of energy: takes the measurements that are
  /// due within each.
  ode::Outcome integrate(ode::Integrator& integrator, ode::State& state, double end, double longestStep);
  /// Returns the measurements that were delivered by the time of this state.
  std::vector<Measurement> measure(const ode::State& state);
  /// Takes the measurements that are due by the time of this state.
  void measureAt(const ode::State& state);

 private:
  std::unique_ptr<ode::Integrator> makeIntegrator(const char* method) const;
  /// Takes the measurements that are due within a step, and at its end. method: of the step.
  void measureWithin(const ode::State& from, const ode::State& to, const std::string& method);
  /// Allocates nothing.
  void moveTo(double t, const ode::State& from, const ode::State& to, bool isStiff);
  void take(const ode::State& state);

  const Scene& scene_;
  Dynamics& dynamics_;
  const Turns& turns_;
  const Coordinates coordinates_ = scene_.chain.coordinates();
  SensorBank bank_{scene_};
  long long evaluations_ = 0;
  std::unique_ptr<ode::Integrator> explicit_, stiff_;  ///< of steps to the times of measurements
  ode::State start_, at_;
  Eigen::VectorXd y_;
  std::vector<double> q_, qd_;
  std::vector<LinkMotion> motions_;
};

}  // namespace planar_chain
