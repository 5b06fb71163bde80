#include "effects/timed_terms.h"

#include <algorithm>
#include <cmath>

#include "lanes/segments.h"

namespace planar_chain {

Line lineAt(const Ramp& ramp, double t) {
  const auto after = std::upper_bound(ramp.times.begin(), ramp.times.end(), t);
  Line line;
  if (after != ramp.times.end()) line.end = *after;
  if (after == ramp.times.begin()) {
    line.value = ramp.values.front();
  } else if (after == ramp.times.end()) {
    line.value = ramp.values.back();
  } else {
    const auto i = static_cast<std::size_t>(after - ramp.times.begin() - 1);
    line.t0 = ramp.times[i];
    line.value = ramp.values[i];
    line.slope = (ramp.values[i + 1] - ramp.values[i]) / (ramp.times[i + 1] - ramp.times[i]);
  }
  return line;
}

TimedTerms::TimedTerms(const Coordinates& coordinates, std::size_t terms, std::size_t factors)
    : coordinates_(coordinates) {
  factors_.reserve(factors + 1);
  sines_.reserve(factors);
  lines_.reserve(factors);
  jointTerms_.reserve(terms);
  bodyTerms_.reserve(terms);
}

// ---- What acts ---------------------------------------------------------------------------------

void TimedTerms::enter(double t) {
  until_ = longestStep_ = std::numeric_limits<double>::infinity();
  reach_ = 0;
  factors_.assign(1, 1.0);
  sines_.clear();
  lines_.clear();
  jointTerms_.clear();
  bodyTerms_.clear();
  list(t);
}

int TimedTerms::factorOf(const TimeLaw& law, double t) {
  if (std::holds_alternative<Constant>(law)) return 0;
  const int next = static_cast<int>(factors_.size());
  factors_.push_back(0);
  if (const auto* sine = std::get_if<Sine>(&law)) {
    sines_.push_back({2 * pi * sine->frequency, sine->phase, next});
    longestStep_ = std::min(longestStep_, 0.25 / std::abs(sine->frequency));
  } else {
    const Line line = lineAt(std::get<Ramp>(law), t);
    lines_.push_back({line, next});
    endBy(line.end);
  }
  return next;
}

// ---- Moments and forces --------------------------------------------------------------------------

void TimedTerms::evaluate(double t, bool rates) {
  factors_[0] = rates ? 0 : 1;
  for (const auto& [pulsation, phase, factor] : sines_) {
    const double angle = pulsation * t + phase;
    factors_[index(factor)] = rates ? pulsation * plainRotation(angle).c : plainRotation(angle).s;
  }
  for (const auto& [line, factor] : lines_) factors_[index(factor)] = rates ? line.slope : line.at(t);
}

Powers TimedTerms::applyFactors(const ChainState& at, const Actions& to, bool rates) {
  evaluate(at.t, rates);
  double power = 0;
  for (const JointTerm& term : jointTerms_) {
    const double tau = times(term.factor, term.torque);
    coordinates_.addTorque(tau, term.q.joint, to.N);
    power += tau * at.omega[term.q.joint];
    if (term.q.inner >= 0) power -= tau * at.omega[term.q.inner];
  }
  for (const BodyTerm& term : bodyTerms_) {
    const double factor = factors_[index(term.factor)];
    const int j = term.body;
    const Vec2d force = factor * term.force;
    if (const int turner = coordinates_.turner(j); turner >= 0) {
      const double moment = factor * term.moment + cross(at.e[j] * term.point, force);
      to.N[turner] += moment;
      power += moment * (at.omega[turner] + at.baseRate);
    }
    if (j < reach_) {
      to.F[j] += force;
      power += dot(force, at.pinVelocity[j]);
    }
  }
  return {power, 0};
}

void TimedTerms::addTorques(const ChainState& at, double* tau) {
  evaluate(at.t);
  for (const JointTerm& term : jointTerms_) tau[term.q.joint] += times(term.factor, term.torque);
}

// ---- Derivatives -----------------------------------------------------------------------------------

void TimedTerms::addForceStiffness(const ChainState& at, double* XF) {
  evaluate(at.t);
  for (const BodyTerm& term : bodyTerms_) {
    const int turner = coordinates_.turner(term.body);
    if (turner >= 0) XF[turner] += times(term.factor, dot(at.e[term.body] * term.point, term.force));
  }
}

Powers TimedTerms::powersAlong(const ChainState& at, const StateChange& along) {
  evaluate(at.t);
  double change = 0;
  for (const JointTerm& term : jointTerms_) {
    change += times(term.factor, term.torque) * term.q(along.v);
  }
  for (const BodyTerm& term : bodyTerms_) {
    const int j = term.body;
    const Vec2d X = at.e[j] * term.point;
    double rate = 0;
    if (const int turner = coordinates_.turner(j); turner >= 0) {
      rate = (term.moment + cross(X, term.force)) * (along.v[turner] + along.speed) -
             dot(X, term.force) * (at.omega[turner] + at.baseRate) * (along.u[turner] + along.turn);
    }
    if (j < reach_) rate += dot(term.force, along.pinVelocity[j]);
    change += times(term.factor, rate);
  }
  return {change, 0};
}

// ---- Taylor series -----------------------------------------------------------------------------------

void TimedTerms::reserveSeries(int orders) {
  factorSeries_.resize(index(orders) * factors_.capacity());
}

void TimedTerms::addOrder(int k, const Series& known, const Actions& to) {
  const auto coefficient = [this](int order, int factor) -> double& {
    return factorSeries_[index(order) * factors_.capacity() + index(factor)];
  };

  // Order k of the factors.
  if (k == 1) {
    evaluate(known.t);
    std::copy(factors_.begin(), factors_.end(), factorSeries_.begin());
    evaluate(known.t, true);
    std::copy(factors_.begin(), factors_.end(), &coefficient(1, 0));
  } else {
    for (std::size_t i = 0; i < factors_.size(); ++i) coefficient(k, static_cast<int>(i)) = 0;
    for (const SineFactor& sine : sines_) {  // f̈ = −pulsation² f
      coefficient(k, sine.factor) =
          -sine.pulsation * sine.pulsation / (k * (k - 1)) * coefficient(k - 2, sine.factor);
    }
  }

  // Order k of what they multiply.
  for (const JointTerm& term : jointTerms_) {
    coordinates_.addTorque(coefficient(k, term.factor) * term.torque, term.q.joint, to.N);
  }
  for (const BodyTerm& term : bodyTerms_) {
    const int j = term.body;
    if (j < reach_) to.F[j] += coefficient(k, term.factor) * term.force;
    const int turner = coordinates_.turner(j);
    if (turner < 0) continue;
    to.N[turner] += coefficient(k, term.factor) * term.moment;
    for (int i = 0; i <= (term.factor == 0 ? 0 : k); ++i) {
      const Vec2d X = known.rotation(k - i)[turner] * term.point;
      to.N[turner] += coefficient(i, term.factor) * cross(X, term.force);
    }
  }
}

}  // namespace planar_chain
