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

EnergyGuard::EnergyGuard(const Chain& chain, const IntegratorSettings& settings, int works)
    : chain_(chain),
      kinds_(storingKinds(chain)),
      n_(chain.size()),
      works_(works),
      tolerance_(ode::hasFixedStep(settings.method) ? 0 : tolerances * settings.tolerance),
      share_(ode::hasFixedStep(settings.method) ? share
                                                : std::min(share, sharePerTolerance * settings.tolerance)) {
  double pin = 0;
  for (int j = 0; j < n_; ++j) {
    const Link& link = chain.links()[index(j)];
    const double reach = pin + length(link.com);
    inertia_ += link.mass * reach * reach + link.inertia;
    weight_ += link.mass * length(chain.gravity()) * reach;
    for (const EffectKind* kind : kinds_) stiffness_ += kind->stiffnessOf(chain.joints()[index(j)]);
    pin += length(link.pin);
  }
}

void EnergyGuard::begin(const ode::State& state, const double* y) {
  good_ = state;
  energyThen_ = energyAt(y);
  worksThen_ = worksOf(y);
  gap_ = moved_ = 0;
}

bool EnergyGuard::accept(const ode::State& state, const double* y) {
  const Energy now = energyAt(y);
  const Eigen::Vector2d works = worksOf(y);
  const double in = works[0] - worksThen_[0];
  const double out = works[1] - worksThen_[1];
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

Eigen::Vector2d EnergyGuard::worksOf(const double* y) const {
  if (works_ == 0) return Eigen::Vector2d::Zero();
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
