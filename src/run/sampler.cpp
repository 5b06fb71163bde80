#include "run/sampler.h"

#include <algorithm>

#include "ode/methods.h"
#include "run/ladder.h"

namespace planar_chain {

Sampler::Sampler(const Scene& scene, Dynamics& dynamics, const Turns& turns)
    : scene_(scene),
      dynamics_(dynamics),
      turns_(turns),
      explicit_(makeIntegrator("dop853")),
      stiff_(makeIntegrator("rodas5p")),
      start_(dynamics.arrangedSize()),
      at_(start_),
      y_(dynamics.size()),
      q_(scene.q.size()),
      qd_(scene.q.size()),
      motions_(scene.q.size()) {}

std::unique_ptr<ode::Integrator> Sampler::makeIntegrator(const char* method) const {
  return ode::makeMethod(method, dynamics_, scene_.integrator.step, toleranceOf(scene_, 0, dynamics_));
}

void Sampler::useTolerance() {
  for (const auto* each : {&explicit_, &stiff_}) {
    (*each)->setTolerance(toleranceOf(scene_, 0, dynamics_).arrangedBy(dynamics_));
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
    outcome = integrator.integrate(state, end, longestStep, 1);
    if (!ode::hasFailed(outcome)) measureWithin(start_, state, integrator.name());
  }
  return outcome;
}

std::vector<Measurement> Sampler::measure(const ode::State& state) {
  measureAt(state);
  bank_.confirm();
  return bank_.deliver(state.t);
}

void Sampler::measureAt(const ode::State& state) {
  const long long before = dynamics_.evaluations();
  while (bank_.next() <= state.t) take(state);
  evaluations_ += dynamics_.evaluations() - before;
}

void Sampler::measureWithin(const ode::State& from, const ode::State& to, const std::string& method) {
  if (bank_.next() > to.t) return;
  const long long before = dynamics_.evaluations();
  while (bank_.next() < to.t) {
    moveTo(bank_.next(), from, to, !ode::isExplicit(method));
    take(at_);
  }
  evaluations_ += dynamics_.evaluations() - before;
  measureAt(to);
}

/// Sets at_ to the state at t within a step. A straight line if the integrator fails.
void Sampler::moveTo(double t, const ode::State& from, const ode::State& to, bool isStiff) {
  ode::Integrator& integrator = isStiff ? *stiff_ : *explicit_;
  integrator.begin();
  at_ = from;
  if (integrator.integrate(at_, t, t - from.t) == ode::Outcome::arrived) return;
  at_ = to;
  at_.t = t;
  at_.y = from.y + (t - from.t) / (to.t - from.t) * (to.y - from.y);
}

/// Takes the values of what is due now at a state.
void Sampler::take(const ode::State& state) {
  const Eigen::Index n = scene_.chain.size();
  dynamics_.restore(state.y.data(), y_.data());
  dynamics_.hold(state.t, y_.data());
  coordinates_.toRelative(y_.data(), q_.data());
  coordinates_.toRelative(y_.data() + n, qd_.data());
  dynamics_.hold(state.t, q_.data(), qd_.data());
  turns_.addTo(q_);
  if (bank_.nextNeedsMotions()) dynamics_.linkMotions(state.t, y_.data(), motions_.data());
  bank_.take(q_, motions_.data());
}

}  // namespace planar_chain
