#include "dynamics/exact_solve.h"

#include <algorithm>

#include "recursion/general_linearized.h"

namespace planar_chain {

template <class Scalar>
ExactSolve::Solver<Scalar> ExactSolve::makeSolver() const {
  Solver<Scalar> solver;
  if (!general_) {
    if constexpr (std::is_same_v<Scalar, double>) {
      solver.plain.emplace(mechanism_.chain(), mechanism_.lanes() != nullptr, mechanism_.kernel());
    } else {
      solver.plain.emplace(*solver_.plain);
    }
  } else {
    const ForceTangent* tangents = tangents_.bodies.empty() ? nullptr : tangents_.bodies.data();
    solver.general =
        makeGeneralSolve<Scalar>(general_->bodies, tangents, effects_.holdTip(), effects_.base() != nullptr);
  }
  return solver;
}

ExactSolve::ExactSolve(const Mechanism& mechanism, const Effects& effects, EffectTangents& tangents,
                       bool isBare)
    : mechanism_(mechanism),
      effects_(effects),
      tangents_(tangents),
      n_(mechanism.size()),
      paddedSize_(mechanism.paddedSize()),
      hasPower_(effects.any(&Effect::hasPower)),
      isNonlinear_(effects.any(&Effect::isNonlinear)),
      hasForces_(effects.mostActing() == LoadKind::forces),
      keepsState_(hasPower_ || isNonlinear_ || hasForces_),
      isPlain_(isBare && !hasPower_),
      general_(isBare ? std::nullopt : std::make_optional<General>(mechanism, effects)),
      solver_(makeSolver<double>()),
      room_(index(2 * paddedSize_)) {
  pinVelocity_.resize(hasForces_ ? index(n_) : 0);
  pin_.resize(tangents.bodies.size());
  inOrder_.resize(index(2 * n_));
  bool needsOrder = hasForces_ || isNonlinear_;
  for (const auto& effect : effects.all()) {
    if (!effect->hasPower()) continue;
    if (effect->inLanes()) omegaInLanes_.resize(index(paddedSize_));
    needsOrder = needsOrder || !effect->inLanes();
  }
  if (!isBare || !needsOrder) return;
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
  if (general_) return {2.9, 1, 3.2, 2.8};
  if (!mechanism_.lanes()) return {2.9, 0.7, 3.2, 2.3};
  if (n_ <= isShort) return {3, 0.65, 6, 2.6};
  if (n_ <= staysInCache) return {2.8, 0.7, 4, 3};
  return {2.8, 0.8, 5, 5};
}

// ---- The state that J is of ------------------------------------------------------------------------

void ExactSolve::takeStiffness() {
  if (!general_) setJoints(tangents_.constantK, tangents_.constantD);
}

void ExactSolve::setJoints(const std::vector<double>& k, const std::vector<double>& d) {
  const double* kInLanes = mechanism_.quantityInLanes(k.data(), room_.data());
  const double* dInLanes = mechanism_.quantityInLanes(d.data(), room_.data() + paddedSize_);
  solver_.plain->setJoints(kInLanes, dInLanes);
}

void ExactSolve::findPinVelocities() {
  mechanism_.findPinVelocities(at_.e, at_.omega, effects_.reach(), pinVelocity_.data());
}

const double* ExactSolve::keep(double t, const double* y) {
  at_.t = t;
  std::copy_n(y + paddedSize_, omegaInLanes_.size(), omegaInLanes_.begin());
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
  general_->at = at;
  effects_.couple(at.t, 0, general_->couplings);
  const Evaluation& kept = general_->at;
  at_ = kept.state();
  std::copy_n(at_.omega, omegaInLanes_.size(), omegaInLanes_.begin());
  tangents_.takeJoints(effects_, at_);
  tangents_.takeForces(effects_, at_);
  general_->bodies.take({kept.e.data(), kept.omega(), kept.y.data() + n_, kept.xdd.data(),
                         kept.displaced.data(), forces(),
                         tangents_.XF.empty() ? nullptr : tangents_.XF.data(), tangents_.k.data(),
                         tangents_.d.data(), general_->couplings.joints.data(), kept.ground,
                         kept.groundTurning, kept.ends.tip.force, kept.ends.tip.acting});
}

/// The chain's own motion stays. The base moves on, and laws of prescribed joints and loads change.
///
///     δθ = φ̇      δω = φ̈      and of the ground pin velocity, acceleration and jerk
Powers ExactSolve::timeDerivative(double* slopes) {
  const Evaluation& at = general_->at;
  const Couplings& now = general_->couplings;
  Couplings& next = general_->rates;
  MotionChange& change = general_->change;
  effects_.couple(at.t, 1, next);  // coefficient 1 of x, ẋ, ẍ: their rates
  const Coordinates& coordinates = mechanism_.coordinates();
  change.angle = now.angle.rate;
  change.rate = now.angle.acceleration;
  for (int i = 0; i < n_; ++i) {
    change.turn[index(i)] = coordinates.isPrismatic(i) ? 0 : change.angle;
    change.speed[index(i)] = coordinates.isPrismatic(i) ? 0 : change.rate;
  }
  change.pin = at.base.velocity;
  change.velocity = now.pinAcceleration();
  change.acceleration = next.pinAcceleration();
  change.turning = next.angle.acceleration;
  change.tip = next.tip.acceleration;
  for (int i = 0; i < n_; ++i) change.prescribed[index(i)] = next.joints[index(i)].acceleration;
  std::fill(change.N.begin(), change.N.end(), 0.0);
  std::fill(change.F.begin(), change.F.end(), Vec2d{});
  Powers power = effects_.applyRates(at_, {change.N.data(), change.F.data()});
  change.find(at, forces() != nullptr, now, tangents_);
  for (int j = 0; j < n_; ++j)
    slopes[j] = change.xdd[index(j)] - (coordinates.isPrismatic(j) ? 0 : change.turning);
  if (!hasPower_) return power;

  // The powers of the effects as the base moves on, and those of drives and base.
  std::fill(inOrder_.begin(), inOrder_.end(), 0.0);
  const StateChange along{inOrder_.data(),    inOrder_.data() + n_, change.pinVelocities.data(),
                          change.pins.data(), now.angle.rate,       now.angle.acceleration};
  power += Effects::powersAlong(effects_.active(), at_, along);
  for (int i = 0; i < n_; ++i) {
    const JointLaw<double>& joint = now.joints[index(i)];
    if (!joint.isPrescribed) continue;
    const GivenMotion& motion = now.prescribed[index(i)];
    power.supplied +=
        (change.moments[index(i)] + joint.armature * change.prescribed[index(i)]) * motion.rate +
        (at.moments[index(i)] + joint.armature * motion.acceleration) * motion.acceleration;
  }
  if (at.isPlain) return power;
  power.supplied += dot(change.tipForce, now.tipVelocity) + dot(at.ends.tip.force, now.tip.acceleration);
  power.supplied += dot(change.baseForce, at.base.velocity) + dot(at.ends.baseForce, now.pinAcceleration()) +
                    (change.baseMoment + firstTorqueRate()) * now.angle.rate +
                    (at.ends.baseMoment + firstTorque(at.t)) * now.angle.acceleration;
  return power;
}

/// The torque of the effects in the first revolute joint at the state of the last linearize() and another
/// time.
double ExactSolve::firstTorque(double t) {
  ChainState at = at_;
  at.t = t;
  std::fill_n(inOrder_.begin(), n_, 0.0);
  effects_.addTorques(at, inOrder_.data());
  const int first = mechanism_.coordinates().leading();
  return first < n_ ? inOrder_[index(first)] : 0;
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
  if (hasForces_) movePins(u, v);
  return Effects::powersAlong(effects_.activeInOrder(), at_, {u, v, pinVelocity_.data(), pin_.data()});
}

/// How the own points of the bodies move along (u, v), and their velocities.
void ExactSolve::movePins(const double* u, const double* v) {
  const Chain& chain = mechanism_.chain();
  const Coordinates& coordinates = chain.coordinates();
  const double* omega = general_ ? general_->at.omega() : at_.omega;
  const int count = pin_.empty() ? effects_.reach() : n_;
  Vec2d dx, dv;
  for (int j = 0; j < count; ++j) {
    const double turn = coordinates.angle(u, j), speed = coordinates.angle(v, j), rate = omega[j];
    // A point at X from one that moves: dx + turn iX, dv + speed iX − rate turn X.
    const auto add = [&](Vec2d X) {
      dx += turn * perp(X);
      dv += speed * perp(X) - (rate * turn) * X;
    };
    if (coordinates.isPrismatic(j)) {
      const auto& [d, S, gamma] = general_->at.displaced[index(j)];
      const double ownRate = general_->at.y[index(n_ + j)];
      add(S);
      dx += u[j] * d;
      dv += v[j] * d + (rate * u[j] + ownRate * turn) * perp(d);
    }
    if (!pin_.empty()) pin_[index(j)] = dx;
    pinVelocity_[index(j)] = dv;
    add(at_.e[j] * chain.links()[index(j)].pin);
  }
}

template <class Scalar>
Scalar ExactSolve::couplingPowerAlong(const Solver<Scalar>& solver) const {
  const GeneralSolve<Scalar>& along = *solver.general;
  Scalar supplied{};
  for (int i = 0; i < n_; ++i) {
    if (!general_->couplings.joints[index(i)].isPrescribed) continue;
    supplied += general_->couplings.prescribed[index(i)].rate * along.moment(i);
  }
  if (general_->at.isPlain) return supplied;
  const BaseState& base = general_->at.base;
  return supplied + dotMixed(general_->couplings.tipVelocity, along.tipForce()) +
         base.rate * along.baseMoment() + dotMixed(base.velocity, along.baseForce());
}

// ---- Real and complex solves -----------------------------------------------------------------------

void ExactSolve::reserve(int complexCount) {
  while (complexSolvers_.size() < index(complexCount)) complexSolvers_.push_back(makeSolver<Complex>());
  part_.resize(complexSolvers_.empty() ? 0 : index(2 * paddedSize_));
}

template double ExactSolve::couplingPowerAlong(const Solver<double>&) const;

void ExactSolve::solveComplex(int k, const Complex* rhs, Complex* x) {
  Solver<Complex>& solver = complexSolvers_[index(k)];
  if (isPlain_) return solver.plain->solve(rhs, rhs + paddedSize_, x, x + paddedSize_);
  solver.solve(rhs, x, paddedSize_);
  if (!hasPower_) return;

  // The powers change linearly: real and imaginary parts one by one.
  const auto powersOf = [&](auto part) {
    for (int i = 0; i < 2 * paddedSize_; ++i) part_[index(i)] = part(x[i]);
    return powersAlong(part_.data());
  };
  const Powers real = powersOf([](Complex z) { return z.real(); });
  const Powers imaginary = powersOf([](Complex z) { return z.imag(); });
  Complex supplied(real.supplied, imaginary.supplied);
  if (general_) supplied += couplingPowerAlong(solver);
  solver.solveWorks(rhs, supplied, {real.dissipated, imaginary.dissipated}, x, paddedSize_);
}

}  // namespace planar_chain
