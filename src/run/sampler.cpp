#include "run/sampler.h"

#include <algorithm>
#include <limits>

#include "ode/methods.h"
#include "run/fallbacks.h"

namespace planar_chain {

Sampler::Sampler(const Scene& scene, Dynamics& dynamics, const Windings& windings)
    : scene_(scene),
      dynamics_(dynamics),
      windings_(windings),
      integrators_{makeIntegrator("dop853"), makeIntegrator("rodas5p"),
                   makeIntegrator(ode::hasFixedStep(scene.integrator.method) ? scene.integrator.method
                                                                             : "ros34pw2_fixed")},
      start_(dynamics.sizeInLaneOrder()),
      at_(start_),
      y_(dynamics.size()),
      q_(scene.q.size()),
      qd_(scene.q.size()),
      motions_(scene.q.size()) {}

std::unique_ptr<ode::Integrator> Sampler::makeIntegrator(const std::string& method) const {
  constexpr double longest = std::numeric_limits<double>::infinity();
  return ode::makeMethod(method, dynamics_, longest, toleranceOf(scene_, 0, dynamics_));
}

void Sampler::useTolerance() {
  for (const auto& each : integrators_) {
    each->setTolerance(toleranceOf(scene_, 0, dynamics_).inLaneOrder(dynamics_));
  }
}

void Sampler::countSteps(long long& accepted, long long& rejected) const {
  for (const auto& each : integrators_) {
    accepted += each->count().accepted;
    rejected += each->count().rejected;
  }
}

ode::Outcome Sampler::integrate(ode::Integrator& integrator, ode::State& state, double end,
                                double longestStep) {
  // Samples. A chain at rest takes steps of years, in which nobody could interrupt it.
  constexpr double mostAtOnce = 1e5;
  const double soon = bank_.timeOf(mostAtOnce), latest = state.t + soon;
  longestStep = std::min(longestStep, soon);
  ode::Outcome outcome = ode::Outcome::underway;
  for (int k = 0; outcome == ode::Outcome::underway && k < EnergyCheck::period && state.t < latest; ++k) {
    start_ = state;
    const long long leaps = integrator.count().leaps;
    outcome = integrator.integrate(state, end, longestStep, 1);
    if (!ode::hasFailed(outcome)) measureWithin(start_, state, integrator, integrator.count().leaps > leaps);
  }
  return outcome;
}

std::vector<Measurement> Sampler::measure(const ode::State& state) {
  measureAt(state);
  bank_.confirm();
  return bank_.deliver(state.t);
}

void Sampler::measureAt(const ode::State& state) {
  while (bank_.next() <= state.t) take(state);
}

void Sampler::measureWithin(const ode::State& from, const ode::State& to, ode::Integrator& last,
                            bool isLeap) {
  if (bank_.next() > to.t) return;
  while (bank_.next() < to.t) {
    at_ = from;
    if (!isLeap || !last.lookTo(at_, bank_.next())) moveTo(bank_.next(), from, to, last.name());
    take(at_);
  }
  measureAt(to);
}

/// Sets at_ to the state at t within a step of this method.
void Sampler::moveTo(double t, const ode::State& from, const ode::State& to, const std::string& method) {
  const std::size_t first = ode::hasFixedStep(method) ? 2 : ode::isExplicit(method) ? 0 : 1;
  for (std::size_t k = first; k < integrators_.size(); ++k) {
    integrators_[k]->begin();
    at_ = from;
    if (integrators_[k]->integrate(at_, t, t - from.t, mostSteps) == ode::Outcome::arrived) return;
  }
  at_ = to;
  at_.t = t;
  at_.y = from.y + (t - from.t) / (to.t - from.t) * (to.y - from.y);
}

/// Takes the values of what is due now at a state.
void Sampler::take(const ode::State& state) {
  const Eigen::Index n = scene_.chain.size();
  dynamics_.toChainOrder(state.y.data(), y_.data());
  dynamics_.hold(state.t, y_.data());
  coordinates_.toRelative(y_.data(), q_.data());
  coordinates_.toRelative(y_.data() + n, qd_.data());
  dynamics_.hold(state.t, q_.data(), qd_.data());
  windings_.addTo(q_);
  if (bank_.nextNeedsMotions()) dynamics_.linkMotions(state.t, y_.data(), motions_.data());
  bank_.take(q_, motions_.data());
}

}  // namespace planar_chain
