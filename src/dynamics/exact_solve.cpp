#include "dynamics/exact_solve.h"

#include <algorithm>

namespace planar_chain {

ExactSolve::ExactSolve(const Mechanism& mechanism, Effects& effects, const std::vector<double>& k,
                       const std::vector<double>& d)
    : mechanism_(mechanism),
      effects_(effects),
      n_(mechanism.size()),
      places_(mechanism.places()),
      hasPower_(effects.any(&Effect::hasPower)),
      isNonlinear_(effects.any(&Effect::isNonlinear)),
      keepsState_(hasPower_ || isNonlinear_ || effects.mostActing() == LoadKind::forces),
      solver_{{mechanism.chain(), mechanism.lanes() != nullptr}},
      k_(k),
      d_(d),
      room_(index(2 * places_)) {
  const bool hasForces = effects.mostActing() == LoadKind::forces;
  bool needsOrder = hasForces || isNonlinear_;
  for (const auto& effect : effects.all()) {
    if (!effect->hasPower()) continue;
    if (effect->worksInLanes()) omegaInLanes_.resize(index(places_));
    needsOrder = needsOrder || !effect->worksInLanes();
  }
  if (needsOrder) {
    stateAt_.resize(index(2 * n_));
    at_.theta = stateAt_.data();
    at_.omega = stateAt_.data() + n_;
    inOrder_.resize(index(2 * n_));
  }
  if (hasForces) {
    eAt_.resize(index(n_));
    XF_.resize(index(n_));
    pinVelocity_.resize(index(n_));
    at_.e = eAt_.data();
    at_.pinVelocity = pinVelocity_.data();
  }
  if (isNonlinear_) {
    tangentK_.resize(index(n_));
    tangentD_.resize(index(n_));
  }
}

ode::LinearCosts ExactSolve::costs() const {
  // By clock, of evaluations as this chain has them; between chains with springs and without. Joining
  // segments is dear for short ones; where factorizations do not stay in cache, solves wait for memory.
  constexpr int isShort = 200, staysInCache = 2500;
  if (!mechanism_.lanes()) return {2.9, 0.7, 3.2, 2.3};
  if (n_ <= isShort) return {3, 0.65, 6, 2.6};
  if (n_ <= staysInCache) return {2.8, 0.7, 4, 3};
  return {2.8, 0.8, 5, 5};
}

// ---- The state that J is of ------------------------------------------------------------------------

void ExactSolve::setJoints(const std::vector<double>& k, const std::vector<double>& d) {
  const double* kInLanes = mechanism_.quantityInLanes(k.data(), room_.data());
  const double* dInLanes = mechanism_.quantityInLanes(d.data(), room_.data() + places_);
  solver_.inverse.setJoints(kInLanes, dInLanes);
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
    tangentK_ = k_;
    tangentD_ = d_;
    for (Effect* effect : effects_.active()) effect->addTangents(at_, tangentK_.data(), tangentD_.data());
    setJoints(tangentK_, tangentD_);
  }
  if (eAt_.empty() || effects_.reach() == 0) return nullptr;
  std::fill(XF_.begin(), XF_.end(), 0.0);
  for (Effect* effect : effects_.active()) effect->addForceStiffness(at_, XF_.data());
  return mechanism_.quantityInLanes(XF_.data(), room_.data());
}

Powers ExactSolve::powersAlongInOrder(const double* uv) {
  // How the pins' velocities change: δ(ω iP) = δω iP − ω δθ P.
  const double* u = mechanism_.stateInOrder(uv, inOrder_.data());
  const double* v = u + n_;
  Vec2d change;
  for (int j = 0; j < effects_.reach(); ++j) {
    pinVelocity_[index(j)] = change;
    const Vec2d P = eAt_[index(j)] * mechanism_.chain().links()[index(j)].pin;
    change += v[j] * perp(P) - (at_.omega[j] * u[j]) * P;
  }
  Powers powers;
  for (Effect* effect : effects_.activeInOrder())
    powers += effect->powersAlong(at_, {u, v, pinVelocity_.data()});
  return powers;
}

// ---- Real and complex solves -----------------------------------------------------------------------

void ExactSolve::reserve(int complexCount) {
  while (complexSolvers_.size() < index(complexCount)) {
    complexSolvers_.push_back({LinearizedSegments<Complex>(solver_.inverse)});
  }
  part_.resize(complexSolvers_.empty() ? 0 : index(2 * places_));
}

void ExactSolve::solveComplex(int k, const Complex* rhs, Complex* x) {
  Solver<Complex>& solver = complexSolvers_[index(k)];
  solver.solve(rhs, x, places_);
  if (!hasPower_) return;

  // The powers change linearly: real and imaginary parts one by one.
  const auto powersOf = [&](auto part) {
    for (int i = 0; i < 2 * places_; ++i) part_[index(i)] = part(x[i]);
    return powersAlong(part_.data());
  };
  const Powers real = powersOf([](Complex z) { return z.real(); });
  const Powers imaginary = powersOf([](Complex z) { return z.imag(); });
  solver.solveWorks(rhs, {real.supplied, imaginary.supplied}, {real.dissipated, imaginary.dissipated}, x,
                    places_);
}

}  // namespace planar_chain
