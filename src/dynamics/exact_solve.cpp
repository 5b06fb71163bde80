#include "dynamics/exact_solve.h"

#include <algorithm>

namespace planar_chain {

namespace {

std::variant<Linearized<double>, LinearizedSegments<double>> solverFor(const Mechanism& mechanism) {
  if (mechanism.lanes()) return LinearizedSegments<double>(mechanism.chain());
  return Linearized<double>(mechanism.chain());
}

/// Another solver at the same state.
std::variant<Linearized<std::complex<double>>, LinearizedSegments<std::complex<double>>> complexOf(
    const std::variant<Linearized<double>, LinearizedSegments<double>>& solver) {
  if (const auto* segments = std::get_if<LinearizedSegments<double>>(&solver)) {
    return LinearizedSegments<std::complex<double>>(*segments);
  }
  return Linearized<std::complex<double>>(std::get<Linearized<double>>(solver));
}

}  // namespace

ExactSolve::ExactSolve(const Mechanism& mechanism, Effects& effects)
    : mechanism_(mechanism),
      effects_(effects),
      n_(mechanism.size()),
      places_(mechanism.places()),
      hasPower_(effects.havePower()),
      isNonlinear_(effects.areNonlinear()),
      keepsState_(hasPower_ || isNonlinear_ || effects.mostActing() == Acting::forces),
      solver_(solverFor(mechanism)),
      k_(index(n_)),
      d_(index(n_)),
      room_(index(2 * places_)) {
  const bool hasForces = effects.mostActing() == Acting::forces;
  if (hasPower_ && effects.havePowerInLanes()) omegaInLanes_.resize(index(places_));
  if ((hasPower_ && effects.havePowerInOrder()) || hasForces || isNonlinear_) {
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
  findStiffness();
}

ode::LinearCosts ExactSolve::costs() const {
  // By clock, of evaluations as this chain has them; between chains with springs and without. Joining
  // segments is dear for short ones; where factorizations do not stay in cache, solves wait for memory.
  constexpr int isShort = 200, staysInCache = 2500;
  if (!mechanism_.lanes()) return {2.9, 1, 3.2, 2.8};
  if (n_ <= isShort) return {3, 0.6, 6, 2.3};
  if (n_ <= staysInCache) return {2.6, 0.6, 3, 1.8};
  return {3.4, 1, 3.6, 3.2};
}

// ---- The state that J is of ------------------------------------------------------------------------

void ExactSolve::findStiffness() {
  std::fill(k_.begin(), k_.end(), 0.0);
  std::fill(d_.begin(), d_.end(), 0.0);
  effects_.findStiffness(k_.data(), d_.data());
  setJoints(k_, d_);
}

void ExactSolve::setJoints(const std::vector<double>& k, const std::vector<double>& d) {
  const double* kInLanes = mechanism_.quantityInLanes(k.data(), room_.data());
  const double* dInLanes = mechanism_.quantityInLanes(d.data(), room_.data() + places_);
  std::visit([&](auto& solver) { solver.setJoints(kInLanes, dInLanes); }, solver_);
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
  if (!eAt_.empty()) rotations(at_.theta, eAt_.data(), n_);

  if (isNonlinear_) {
    tangentK_ = k_;
    tangentD_ = d_;
    effects_.addTangents(at_, tangentK_.data(), tangentD_.data());
    setJoints(tangentK_, tangentD_);
  }
  if (eAt_.empty() || effects_.reach() == 0) return nullptr;
  std::fill(XF_.begin(), XF_.end(), 0.0);
  effects_.addForceStiffness(at_, XF_.data());
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
  return effects_.powersAlong(at_, {u, v, pinVelocity_.data()});
}

// ---- Real and complex solves -----------------------------------------------------------------------

void ExactSolve::reserve(int complexCount) {
  while (complexSolvers_.size() < index(complexCount)) complexSolvers_.push_back(complexOf(solver_));
  complexS_.resize(complexSolvers_.size());
  part_.resize(complexSolvers_.empty() ? 0 : index(2 * places_));
}

void ExactSolve::factorComplex(int k, std::complex<double> s) {
  complexS_[index(k)] = s;
  std::visit([s](auto& solver) { solver.factor(s); }, complexSolvers_[index(k)]);
}

void ExactSolve::solveComplex(int k, const std::complex<double>* rhs, std::complex<double>* x) {
  std::visit([&](auto& solver) { solver.solve(rhs, rhs + places_, x, x + places_); },
             complexSolvers_[index(k)]);
  if (!hasPower_) return;

  // The powers change linearly: real and imaginary parts one by one.
  const auto powersOf = [&](auto part) {
    for (int i = 0; i < 2 * places_; ++i) part_[index(i)] = part(x[i]);
    return powersAlong(part_.data());
  };
  const Powers real = powersOf([](std::complex<double> z) { return z.real(); });
  const Powers imaginary = powersOf([](std::complex<double> z) { return z.imag(); });
  const std::complex<double> s = complexS_[index(k)];
  const int works = 2 * places_;
  x[works] = (rhs[works] + std::complex<double>(real.supplied, imaginary.supplied)) / s;
  x[works + 1] = (rhs[works + 1] + std::complex<double>(real.dissipated, imaginary.dissipated)) / s;
}

}  // namespace planar_chain
