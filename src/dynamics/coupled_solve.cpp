/// The exact solve and the Taylor series of coupled chains.

#include <algorithm>

#include "dynamics/coupled_dynamics.h"

namespace planar_chain {

// ---- ode::LinearizedSystem ---------------------------------------------------------------------------

void CoupledDynamics::reserve(int complexCount) {
  const auto n = index(n_);
  for (auto* numbers : {&tangentK_, &tangentD_, &XF_}) numbers->resize(n);
  pinVelocityAlong_.resize(n);
  part_.resize(2 * n);
  while (complexSolvers_.size() < index(complexCount)) {
    complexSolvers_.push_back({CoupledLinearized<std::complex<double>>(bodies_)});
  }
}

void CoupledDynamics::linearize(double t, const double* y, double* dydt) {
  run(t, y);
  derivative(t, y, dydt);
  then_ = now_;  // later calls need it

  // What the effects add to J.
  sumStiffness();
  tangentK_ = k_;
  tangentD_ = d_;
  const bool hasForces = effects_.acting() == LoadKind::forces;
  std::fill(XF_.begin(), XF_.end(), 0.0);
  for (Effect* effect : effects_.active()) {
    effect->addTangents(then_.state(), tangentK_.data(), tangentD_.data());
    if (hasForces) effect->addForceStiffness(then_.state(), XF_.data());
  }
  bodies_.take(linearized());
}

CoupledState CoupledDynamics::linearized() const {
  const bool hasForces = effects_.acting() == LoadKind::forces;
  return {then_.e.data(), then_.omega(),    then_.alpha.data(), hasForces ? then_.F.data() : nullptr,
          XF_.data(),     tangentK_.data(), tangentD_.data(),   then_.couplings.joints.data(),
          then_.ground};
}

bool CoupledDynamics::timeDerivative(double* ft) {
  if (!effects_.varyWithTime()) return false;
  // A difference of fourth order, of steps that change what varies with time by about 0.003: its error is
  // below 1e-11 of ∂f/∂t.
  const double h = std::min(2e-3 * effects_.longestStep(), 1e-4);
  std::fill_n(ft, size(), 0.0);
  for (const auto& [steps, weight] :
       {std::pair{-2, 1.0 / 12}, std::pair{-1, -8.0 / 12}, std::pair{1, 8.0 / 12}, std::pair{2, -1.0 / 12}}) {
    rates(then_.t + steps * h, then_.y.data(), rates_.data());
    for (int i = 0; i < n_ + works_; ++i) ft[n_ + i] += weight / h * rates_[index(i)];
  }
  return true;
}

template <class Scalar>
void CoupledDynamics::solveWith(Solver<Scalar>& solver, const Scalar* rhs, Scalar* x) {
  solver.of.solve(rhs, rhs + n_, x, x + n_);
  if (works_ == 0) return;
  // The powers of drives and base, then of the effects.
  Scalar supplied{}, dissipated{};
  for (int i = 0; i < n_; ++i) {
    if (!then_.couplings.joints[index(i)].isHeld) continue;
    supplied += then_.couplings.held[index(i)].rate * solver.of.moments()[index(i)];
  }
  if (base_) {
    const Vec2<Scalar> change = solver.of.pinForce();
    supplied += then_.base.rate * solver.of.moments()[0] + then_.base.velocity.x * change.x +
                then_.base.velocity.y * change.y;
  }
  if constexpr (std::is_same_v<Scalar, double>) {
    const Powers change = powersAlong(x);
    supplied += change.supplied;
    dissipated += change.dissipated;
  } else {
    const auto along = [&](auto part) {
      for (int i = 0; i < 2 * n_; ++i) part_[index(i)] = part(x[i]);
      return powersAlong(part_.data());
    };
    const Powers real = along([](Scalar z) { return z.real(); });
    const Powers imaginary = along([](Scalar z) { return z.imag(); });
    supplied += Scalar(real.supplied, imaginary.supplied);
    dissipated += Scalar(real.dissipated, imaginary.dissipated);
  }
  x[2 * n_] = (rhs[2 * n_] + supplied) / solver.s;
  x[2 * n_ + 1] = (rhs[2 * n_ + 1] + dissipated) / solver.s;
}

void CoupledDynamics::solve(const double* rhs, double* x) {
  solveWith(solver_, rhs, x);
}

void CoupledDynamics::solveComplex(int k, const std::complex<double>* rhs, std::complex<double>* x) {
  solveWith(complexSolvers_[index(k)], rhs, x);
}

/// How the powers of the effects change along x = [u v].
Powers CoupledDynamics::powersAlong(const double* x) {
  Powers powers;
  Vec2d change;
  for (int j = 0; j < effects_.reach(); ++j) {
    pinVelocityAlong_[index(j)] = change;
    const Vec2d P = then_.e[index(j)] * mechanism_.chain().links()[index(j)].pin;
    change += x[n_ + j] * perp(P) - (then_.omega()[j] * x[j]) * P;
  }
  for (Effect* effect : effects_.active()) {
    powers += effect->worksInLanes()
                  ? effect->powersAlongInLanes(then_.y.data() + n_, x + n_)
                  : effect->powersAlong(then_.state(), {x, x + n_, pinVelocityAlong_.data()});
  }
  return powers;
}

// ---- Taylor series ---------------------------------------------------------------------------------

void CoupledDynamics::reserveSeries(int order) {
  if (series_ && series_->orders() >= order) return;
  series_.emplace(mechanism_.chain(), order);
  for (const auto& effect : effects_.all()) effect->reserveSeries(order);
}

void CoupledDynamics::series(double t, const double* y, const double* /*carry*/, int order, double* c) {
  sumStiffness();
  run(t, y);
  aside_ = now_;  // the orders, one after the other
  aside_.hasCouplings = false;
  std::copy_n(y, 2 * n_, c);
  const Vec2d* F = effects_.acting() == LoadKind::forces ? aside_.F.data() : nullptr;
  series_->begin(now_.e.data(), now_.omega(), now_.alpha.data(), now_.ground, F);
  const Series known{t, n_, c, series_->rotations(), n_};
  const auto& [joints, held, x, yBase, angle] = aside_.couplings;
  for (int k = 0; k < order; ++k) {
    double *row = c + std::ptrdiff_t{2} * n_ * k, *next = row + std::ptrdiff_t{2} * n_;
    if (k > 0) {
      collect(t, k, aside_.couplings);
      for (int i = 0; i < n_; ++i) rates_[index(i)] = row[n_ + i] + angle.rate;
      findOrder(k, known, {aside_.N.data(), aside_.F.data()});
      series_->find(k, rates_.data(), aside_.N.data(), F, joints.data(), {x.acceleration, yBase.acceleration},
                    angle.acceleration, aside_.alpha.data());
    }
    for (int i = 0; i < n_; ++i) {
      next[i] = row[n_ + i] / (k + 1);
      next[n_ + i] = (aside_.alpha[index(i)] - angle.acceleration) / (k + 1);
    }
  }
}

void CoupledDynamics::integrands(double t, const double* y, double* rates) {
  if (!welded_ || effects_.acting() == LoadKind::forces) {
    run(t, y);
    rates[0] = now_.powers.supplied + couplingPower();
    rates[1] = now_.powers.dissipated;
    return;
  }
  // Nothing is driven, and no power depends on where the pins are.
  aside_.t = t;
  std::copy_n(y, 2 * n_, aside_.y.begin());
  applyEffects(aside_);
  rates[0] = aside_.powers.supplied;
  rates[1] = aside_.powers.dissipated;
}

}  // namespace planar_chain
