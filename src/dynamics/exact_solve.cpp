#include "dynamics/exact_solve.h"

#include <algorithm>

#include "dynamics/inner_end.h"

namespace planar_chain {

namespace {

/// kinds: see coupled_linearized.h. ends: nullptr if the chain has none.
template <class Scalar, std::size_t kinds>
std::unique_ptr<CoupledSolve<Scalar>> coupledSolve(const CoupledBodies& bodies, const EndsTangent* ends,
                                                   const ForceTangent* tangents) {
  if (ends) return std::make_unique<EndedLinearized<Scalar, kinds>>(bodies, tangents, *ends);
  return std::make_unique<CoupledLinearized<Scalar, kinds>>(bodies, tangents);
}

}  // namespace

template <class Scalar>
ExactSolve::Solver<Scalar> ExactSolve::makeSolver() const {
  Solver<Scalar> solver;
  if (!coupled_) {
    if constexpr (std::is_same_v<Scalar, double>) {
      solver.plain.emplace(mechanism_.chain(), mechanism_.lanes() != nullptr);
    } else {
      solver.plain.emplace(*solver_.plain);
    }
  } else {
    const bool takesForces = !tangents_.bodies.empty();
    const auto make = takesForces ? coupledSolve<Scalar, 3> : coupledSolve<Scalar, 1>;
    solver.coupled = make(coupled_->bodies, mechanism_.hasEnds() ? &coupled_->ends : nullptr,
                          takesForces ? tangents_.bodies.data() + mechanism_.slides() : nullptr);
  }
  return solver;
}

ExactSolve::ExactSolve(const Mechanism& mechanism, Effects& effects, EffectTangents& tangents, bool isCoupled)
    : mechanism_(mechanism),
      effects_(effects),
      tangents_(tangents),
      n_(mechanism.size()),
      places_(mechanism.places()),
      hasPower_(effects.any(&Effect::hasPower)),
      isNonlinear_(effects.any(&Effect::isNonlinear)),
      hasForces_(effects.mostActing() == LoadKind::forces),
      keepsState_(hasPower_ || isNonlinear_ || hasForces_),
      isPlain_(!isCoupled && !hasPower_),
      coupled_(isCoupled ? std::make_optional<Coupled>(mechanism, effects) : std::nullopt),
      solver_(makeSolver<double>()),
      room_(index(2 * places_)) {
  pinVelocity_.resize(hasForces_ ? index(n_) : 0);
  pin_.resize(tangents.bodies.size());
  inOrder_.resize(index(2 * n_));
  bool needsOrder = hasForces_ || isNonlinear_;
  for (const auto& effect : effects.all()) {
    if (!effect->hasPower()) continue;
    if (effect->inLanes()) omegaInLanes_.resize(index(places_));
    needsOrder = needsOrder || !effect->inLanes();
  }
  if (isCoupled || !needsOrder) return;
  stateAt_.resize(index(2 * n_));
  at_.theta = stateAt_.data();
  at_.omega = stateAt_.data() + n_;
  if (!hasForces_) return;
  eAt_.resize(index(n_));
  at_.e = eAt_.data();
  at_.pinVelocity = pinVelocity_.data();
}

ode::LinearCosts ExactSolve::costs() const {
  // By clock, of evaluations as this chain has them; between chains with springs and without. Joining
  // segments is dear for short ones; where factorizations do not stay in cache, solves wait for memory. Wrong
  // costs make auto choose a slower method, and change no result beyond its tolerance.
  constexpr int isShort = 200, staysInCache = 2500;
  if (!tangents_.bodies.empty()) return {4.5, 1, 5, 2.8};
  if (coupled_) return {2.9, 1, 3.2, 2.8};
  if (!mechanism_.lanes()) return {2.9, 0.7, 3.2, 2.3};
  if (n_ <= isShort) return {3, 0.65, 6, 2.6};
  if (n_ <= staysInCache) return {2.8, 0.7, 4, 3};
  return {2.8, 0.8, 5, 5};
}

// ---- The state that J is of ------------------------------------------------------------------------

void ExactSolve::takeStiffness() {
  if (!coupled_) setJoints(tangents_.constantK, tangents_.constantD);
}

void ExactSolve::setJoints(const std::vector<double>& k, const std::vector<double>& d) {
  const double* kInLanes = mechanism_.quantityInLanes(k.data(), room_.data());
  const double* dInLanes = mechanism_.quantityInLanes(d.data(), room_.data() + places_);
  solver_.plain->setJoints(kInLanes, dInLanes);
}

void ExactSolve::findPinVelocities() {
  mechanism_.findPinVelocities(at_.e, at_.omega, effects_.reach(), pinVelocity_.data());
}

const double* ExactSolve::keep(double t, const double* y) {
  at_.t = t;
  std::copy_n(y + places_, omegaInLanes_.size(), omegaInLanes_.begin());
  if (stateAt_.empty()) return nullptr;
  const double* ordered = mechanism_.stateInOrder(y, inOrder_.data());
  std::copy_n(ordered, 2 * n_, stateAt_.begin());
  if (!eAt_.empty()) mechanism_.rotate(at_.theta, eAt_.data(), n_);

  if (isNonlinear_) {
    tangents_.takeJoints(effects_, at_);
    setJoints(tangents_.k, tangents_.d);
  }
  if (eAt_.empty() || effects_.reach() == 0) return nullptr;
  tangents_.takeForces(effects_, at_);
  return mechanism_.quantityInLanes(tangents_.XF.data(), room_.data());
}

void ExactSolve::linearize(const Evaluation& at) {
  coupled_->at = at;
  effects_.couple(at.t, 0, coupled_->couplings);
  const Evaluation& kept = coupled_->at;
  at_ = kept.state();
  std::copy_n(at_.omega, omegaInLanes_.size(), omegaInLanes_.begin());
  tangents_.takeJoints(effects_, at_);
  tangents_.takeForces(effects_, at_);
  const int slides = mechanism_.slides();
  const auto ofBodies = [slides](const auto* values) { return values ? values + slides : nullptr; };
  coupled_->bodies.take({kept.e.data() + slides, kept.omega() + slides, kept.alpha.data() + slides,
                         ofBodies(forces()), ofBodies(tangents_.XF.empty() ? nullptr : tangents_.XF.data()),
                         tangents_.k.data() + slides, tangents_.d.data() + slides,
                         coupled_->couplings.joints.data() + slides,
                         mechanism_.hasEnds() ? kept.ends.pinAcceleration : kept.ground, kept.ends.tipForce});
  if (mechanism_.hasEnds()) takeEnds();
}

void ExactSolve::takeEnds() {
  EndsTangent& ends = coupled_->ends;
  ends.inner = innerEndOf(mechanism_.chain(), coupled_->couplings.joints.data());
  std::copy_n(tangents_.k.begin(), mechanism_.slides(), ends.stiffness.begin());
  std::copy_n(tangents_.d.begin(), mechanism_.slides(), ends.damping.begin());
  ends.tip = coupled_->at.ends.acting;
  const Evaluation& at = coupled_->at;
  for (std::size_t i = 0; i < index(mechanism_.slides()) && !tangents_.bodies.empty(); ++i) {
    ends.ofPlace[i] = tangents_.bodies[i].K.forcePlace;
    ends.ofVelocity[i] = tangents_.bodies[i].D.forcePlace;
  }
  ends.turns = mechanism_.slides() > 0 && at.turnsRails();
  if (ends.turns) turnEnds();
}

void ExactSolve::turnEnds() {
  EndsTangent& ends = coupled_->ends;
  const Evaluation& at = coupled_->at;
  const Rails<double> rails = railsOf(mechanism_.chain(), at.turn(), at.y.data(), at.omega());
  for (std::size_t i = 0; i < index(mechanism_.slides()); ++i) {
    ends.inner.slide[i].d = rails.d[i];
    ends.place[i] = rails.own[i].place;
    ends.com[i] = rails.com[i].place - rails.own[i].place;
  }
  ends.rate = at.base.rate;
  ends.turning = at.groundTurning;
  ends.force = ofBase(ends.inner, at.ends, at.ground, forces(), rails).slides;
  ends.firstPin = rails.first.place;
  ends.pinForce = at.ends.pinForce;
}

/// The chain's own motion stays. The base moves on, laws of held joints and loads change.
///
///     δθ = φ̇      δω = φ̈      and of the ground pin velocity, acceleration and jerk
Powers ExactSolve::timeDerivative(double* slopes) {
  const Evaluation& at = coupled_->at;
  const Couplings& now = coupled_->couplings;
  Couplings& next = coupled_->rates;
  MotionChange& change = coupled_->change;
  effects_.couple(at.t, 1, next);  // coefficient 1 of x, ẋ, ẍ: their rates
  const int first = mechanism_.slides();
  change.angle = now.angle.rate;
  change.rate = now.angle.acceleration;
  std::fill(change.turn.begin() + first, change.turn.end(), change.angle);
  std::fill(change.speed.begin() + first, change.speed.end(), change.rate);
  change.pin = at.base.velocity;
  change.velocity = now.pinAcceleration();
  change.acceleration = next.pinAcceleration();
  change.turning = next.angle.acceleration;
  change.tip = next.tip.acceleration;
  for (int i = 0; i < n_; ++i) change.held[index(i)] = next.joints[index(i)].acceleration;
  std::fill(change.N.begin(), change.N.end(), 0.0);
  std::fill(change.F.begin(), change.F.end(), Vec2d{});
  Powers power = effects_.applyRates(at_, {change.N.data(), change.F.data()});
  change.find(at, forces() != nullptr, now, tangents_);
  for (int j = 0; j < n_; ++j) slopes[j] = change.alpha[index(j)] - (j < first ? 0 : change.turning);
  if (!hasPower_) return power;

  // The powers of the effects as the base moves on, and those of drives and base.
  std::fill(inOrder_.begin(), inOrder_.end(), 0.0);
  const StateChange along{inOrder_.data(),    inOrder_.data() + n_, change.pinVelocities.data(),
                          change.pins.data(), now.angle.rate,       now.angle.acceleration};
  power += Effects::powersAlong(effects_.active(), at_, along);
  for (int i = 0; i < n_; ++i) {
    const Coupling<double>& joint = now.joints[index(i)];
    if (!joint.isHeld) continue;
    const GivenMotion& motion = now.held[index(i)];
    power.supplied += (change.moments[index(i)] + joint.rotor * change.held[index(i)]) * motion.rate +
                      (at.moments[index(i)] + joint.rotor * motion.acceleration) * motion.acceleration;
  }
  if (at.isPlain) return power;
  power.supplied += dot(change.tipForce, now.tipVelocity) + dot(at.ends.tipForce, now.tip.acceleration);
  power.supplied +=
      dot(change.pinForce, at.base.velocity) + dot(at.pinForce, now.pinAcceleration()) +
      (change.moments[index(first)] + firstTorqueRate() + change.slidesMoment) * now.angle.rate +
      (at.moments[index(first)] + firstTorque(at.t) + at.slidesMoment) * now.angle.acceleration;
  return power;
}

/// The torque of the effects in joint 1 at the state of the last linearize() and another time.
double ExactSolve::firstTorque(double t) {
  ChainState at = at_;
  at.t = t;
  std::fill_n(inOrder_.begin(), n_, 0.0);
  effects_.addTorques(at, inOrder_.data());
  return inOrder_[index(mechanism_.slides())];
}

/// By a difference: it counts in the work of a turning base alone, not in the motion.
double ExactSolve::firstTorqueRate() {
  // s: the error of the formula, (ωh)⁴, and that of rounding, which grows with 1/h, are near 1e-11 then.
  constexpr double longest = 1e-4, share = 1e-3;
  const double h = std::min(share * effects_.longestStep(), longest);
  return (8 * (firstTorque(at_.t + h) - firstTorque(at_.t - h)) -
          (firstTorque(at_.t + 2 * h) - firstTorque(at_.t - 2 * h))) /
         (12 * h);
}

// ---- Powers along a solution -----------------------------------------------------------------------

Powers ExactSolve::powersAlongInOrder(const double* uv) {
  const double* u = mechanism_.stateInOrder(uv, inOrder_.data());
  const double* v = u + n_;
  const double* omega = coupled_ ? coupled_->at.omega() : at_.omega;
  const int count = pin_.empty() ? effects_.reach() : n_;
  if (hasForces_ && mechanism_.slides() > 0) {
    const Evaluation& at = coupled_->at;
    const auto [e, rate, turning] = at.turn();
    rails_ = changingRails(mechanism_.chain(), {planar_chain::turning(e, 0), rate, turning}, at.y.data(),
                           omega, u, v);
  }
  mechanism_.findPinChanges(at_.e, omega, u, v, count, rails_, pin_.empty() ? nullptr : pin_.data(),
                            pinVelocity_.data());
  return Effects::powersAlong(effects_.activeInOrder(), at_, {u, v, pinVelocity_.data(), pin_.data()});
}

template <class Scalar>
Scalar ExactSolve::couplingPowerAlong(const Solver<Scalar>& solver) const {
  const CoupledSolve<Scalar>& along = *solver.coupled;
  Scalar supplied{};
  for (int i = 0; i < n_; ++i) {
    if (!coupled_->couplings.joints[index(i)].isHeld) continue;
    supplied += coupled_->couplings.held[index(i)].rate * along.moment(i);
  }
  if (coupled_->at.isPlain) return supplied;
  const BaseState& base = coupled_->at.base;
  return supplied + dotMixed(coupled_->couplings.tipVelocity, along.tipForce()) +
         base.rate * (along.moment(mechanism_.slides()) + along.baseMoment()) +
         dotMixed(base.velocity, along.pinForce());
}

// ---- Real and complex solves -----------------------------------------------------------------------

void ExactSolve::reserve(int complexCount) {
  while (complexSolvers_.size() < index(complexCount)) complexSolvers_.push_back(makeSolver<Complex>());
  part_.resize(complexSolvers_.empty() ? 0 : index(2 * places_));
}

template double ExactSolve::couplingPowerAlong(const Solver<double>&) const;

void ExactSolve::solveComplex(int k, const Complex* rhs, Complex* x) {
  Solver<Complex>& solver = complexSolvers_[index(k)];
  if (isPlain_) return solver.plain->solve(rhs, rhs + places_, x, x + places_);
  solver.solve(rhs, x, places_);
  if (!hasPower_) return;

  // The powers change linearly: real and imaginary parts one by one.
  const auto powersOf = [&](auto part) {
    for (int i = 0; i < 2 * places_; ++i) part_[index(i)] = part(x[i]);
    return powersAlong(part_.data());
  };
  const Powers real = powersOf([](Complex z) { return z.real(); });
  const Powers imaginary = powersOf([](Complex z) { return z.imag(); });
  Complex supplied(real.supplied, imaginary.supplied);
  if (coupled_) supplied += couplingPowerAlong(solver);
  solver.solveWorks(rhs, supplied, {real.dissipated, imaginary.dissipated}, x, places_);
}

}  // namespace planar_chain
