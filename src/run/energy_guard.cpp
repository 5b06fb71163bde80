#include "run/energy_guard.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ode/methods.h"

namespace planar_chain {

namespace {

constexpr double tolerances = 10;
constexpr double mostAngle = 1e6;           // rad; beyond, rounding explains no gap
constexpr double share = 0.1;               // of the energy that moves, for fixed steps
constexpr double sharePerTolerance = 1000;  // the same for adaptive ones

}  // namespace

EnergyGuard::EnergyGuard(const Scene& scene, const Dynamics& dynamics)
    : dynamics_(dynamics), n_(scene.chain.size()) {
  const double tolerance = scene.integrator.tolerance;
  const bool isFixed = ode::hasFixedStep(scene.integrator.method);
  tolerance_ = isFixed ? 0 : tolerances * tolerance;
  share_ = isFixed ? share : std::min(share, sharePerTolerance * tolerance);
  double pin = 0;
  for (int j = 0; j < n_; ++j) {
    const Link& link = scene.chain.links()[index(j)];
    const double reach = pin + length(link.com);
    inertia_ += link.mass * reach * reach + link.inertia;
    weight_ += link.mass * length(scene.chain.gravity()) * reach;
    for (const EffectKind* kind : effectKinds()) {
      inertia_ += kind->inertiaIn(scene.chain.joints()[index(j)]);
      stiffness_ += kind->stiffnessOf(scene.chain.joints()[index(j)]);
    }
    pin += length(link.pin);
  }
}

void EnergyGuard::begin(const ode::State& state, const double* y) {
  good_ = state;
  energyThen_ = dynamics_.energy(state.t, y);
  worksThen_ = worksOf(y);
  gap_ = moved_ = 0;
}

bool EnergyGuard::accept(const ode::State& state, const double* y) {
  const Energy now = dynamics_.energy(state.t, y);
  const Works works = worksOf(y);
  const double in = works.in - worksThen_.in;
  const double out = works.out - worksThen_.out;
  const double fading = std::max(0.0, 1 - (state.t - good_.t));
  const double gap = gap_ * fading + (now.kinetic - energyThen_.kinetic) +
                     (now.potential - energyThen_.potential) - in + out;
  const double moved = std::max(moved_ * fading, now.kinetic + energyThen_.kinetic +
                                                     std::abs(now.potential - energyThen_.potential) +
                                                     std::abs(in) + std::abs(out));
  if (!std::isfinite(gap) || !(std::abs(gap) <= errorEnergy(state.t, y, now) + share_ * moved)) {
    refused_ = gap;
    return false;
  }
  good_ = state;
  energyThen_ = now;
  worksThen_ = works;
  gap_ = gap;
  moved_ = moved;
  return true;
}

EnergyGuard::Works EnergyGuard::worksOf(const double* y) const {
  if (dynamics_.works() == 0) return {};
  return {y[2 * n_], y[2 * n_ + 1]};
}

double EnergyGuard::errorEnergy(double t, const double* y, const Energy& now) const {
  const Eigen::Map<const Eigen::ArrayXd> theta(y, n_), omega(y + n_, n_);
  const double rounding = std::numeric_limits<double>::epsilon() * std::max(32, n_);
  const double error = tolerance_ * std::max(1.0, t - good_.t);
  const double angle = error + rounding * (pi + std::min(theta.abs().maxCoeff(), mostAngle));
  const double rate = (error + rounding) * (1 + omega.abs().maxCoeff());

  const double kinetic = 0.5 * inertia_ * rate * rate;
  const double elastic = 2 * stiffness_ * angle * angle;
  const double mostKinetic = std::max(now.kinetic, energyThen_.kinetic);
  const double mostElastic = std::max(now.elastic, energyThen_.elastic);
  // Root by root: a product of energies may be past what a double holds.
  return 2 * std::sqrt(mostKinetic) * std::sqrt(kinetic) + kinetic +
         2 * std::sqrt(mostElastic) * std::sqrt(elastic) + elastic + weight_ * angle;
}

}  // namespace planar_chain
