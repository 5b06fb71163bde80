#pragma once

/// Checks the energy balance. A method that makes or loses energy opens a gap that no error estimate of a
/// step shows:
///
///     gap = T + V − (T + V before) − W_s + W_d
///
/// Gaps of about the last second are added up. A gap is accepted while the tolerance explains it. Angles off
/// by ε and rates off by ε (1 + max|ω|) change the energy by at most
///
///     2 √(T T_ε) + T_ε + 2 √(V_e V_ε) + V_ε + ε Σ m |g| ρ + ε W_1
///
///     T_ε         kinetic energy of that rate error, at worst
///     V_e, V_ε    elastic energy; 2 ε² Σ k, with k ρ² of a spring to the ground
///     ρ_j         |r_j| + Σ_{k<j} |p_k|, the largest distance of body j from the ground
///     ε           10 tolerances, and rounding
///     W_1         1 J or Σ (m ρ² + I)/s², whichever is more: the error control lets works err by so much of
///                 the tolerance; 0 without works
///
/// Prismatic joints move all bodies by ε R more, R: the chain's reach. So ρ counts R more, and their
/// stiffness R².
///
/// In addition, a share of the exchanged energy is allowed: a thousand tolerances, or a tenth for methods of
/// fixed step, which have no tolerance.
///
/// The ε of rates is ten times the rate_tolerance. Without one a step may change a rate by half a tolerance
/// (ode/integrator.h), so ε is half a tolerance for each step of about the last second if that is more.
/// Vibrations whose angles are below the tolerance may be damped; this energy is part of the gap.

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/dynamics.h"
#include "ode/methods.h"
#include "planar_chain/scene.h"

namespace planar_chain {

/// The bound. Allocates nothing.
class EnergyCheck {
 public:
  static constexpr int period = 32;  ///< steps between two checks

  explicit EnergyCheck(const Scene& scene) : n_(scene.chain.size()) {
    use(scene.integrator);
    const Coordinates& coordinates = scene.chain.coordinates();
    const double chainReach = scene.chain.reach();
    double pin = coordinates.leading() > 0 ? chainReach : 0;
    for (int j = 0; j < n_; ++j) {
      const Link& link = scene.chain.links()[index(j)];
      const double reach = pin + length(link.com);
      inertia_ += link.mass * reach * reach + link.inertia;
      weight_ += link.mass * length(scene.chain.gravity()) * reach;
      inertia_ += inertiaIn(scene.chain.joints()[index(j)]);
      const double unit = coordinates.isPrismatic(j) ? chainReach : 1;
      stiffness_ += unit * unit * stiffnessOf(scene.chain.joints()[index(j)]);
      const double farthest = pin + std::max(length(link.com), length(link.pin));
      stiffness_ += farthest * farthest * stiffnessOf(link);
      pin += length(link.pin);
    }
  }

  /// Sets the bound for these settings from now on.
  void use(const IntegratorSettings& settings) {
    constexpr double fixedShare = 0.1, tolerances = 10, sharePerTolerance = 1000;
    const bool isFixed = ode::hasFixedStep(settings.method);
    tolerance_ = isFixed ? 0 : tolerances * settings.tolerance;
    rateTolerance_ = isFixed ? 0 : tolerances * settings.rateTolerance.value_or(settings.tolerance);
    perStep_ = isFixed || settings.rateTolerance ? 0 : settings.tolerance / 2;
    share_ = isFixed ? fixedShare : std::min(fixedShare, sharePerTolerance * settings.tolerance);
  }

  /// Starts the balance. works: W_s and W_d.
  void begin(double t, const Energy& energy, const Eigen::Vector2d& works) {
    then_ = t;
    energyThen_ = energy;
    worksThen_ = works;
    gap_ = moved_ = steps_ = 0;
  }

  /// Returns true if the balance closes over these steps, from the last good state to that of absolute angles
  /// and rates y, which then is the last good state.
  bool accept(double t, const double* y, const Energy& now, const Eigen::Vector2d& works, long long steps) {
    const double in = works[0] - worksThen_[0];
    const double out = works[1] - worksThen_[1];
    const double fading = std::max(0.0, 1 - (t - then_));
    const bool hasWorks = works != Eigen::Vector2d::Zero();
    const double gap = gap_ * fading + (now.kinetic - energyThen_.kinetic) +
                       (now.potential - energyThen_.potential) - in + out;
    const double moved = std::max(moved_ * fading, now.kinetic + energyThen_.kinetic +
                                                       std::abs(now.potential - energyThen_.potential) +
                                                       std::abs(in) + std::abs(out));
    const double lately = steps_ * fading + static_cast<double>(steps);
    const double allowed = errorEnergy(t, y, now, lately, hasWorks) + share_ * moved;
    if (!std::isfinite(gap) || !(std::abs(gap) <= allowed)) {
      refused_ = gap;
      return false;
    }
    then_ = t;
    energyThen_ = now;
    worksThen_ = works;
    gap_ = gap;
    moved_ = moved;
    steps_ = lately;
    return true;
  }
  /// The gap that was last refused, J: positive if there was too much energy.
  double gap() const { return refused_; }
  void saveOrRestore(Snapshot& snapshot) {
    snapshot(then_, energyThen_, worksThen_, gap_, moved_, steps_, refused_);
  }

 private:
  double errorEnergy(double t, const double* y, const Energy& now, double steps, bool hasWorks) const {
    constexpr double mostAngle = 1e6;  // rad; beyond, rounding explains no gap
    const Eigen::Map<const Eigen::ArrayXd> theta(y, n_), omega(y + n_, n_);
    const double rounding = std::numeric_limits<double>::epsilon() * std::max(32, n_);
    const double seconds = std::max(1.0, t - then_);
    const double ofWorks = hasWorks ? (tolerance_ * seconds + rounding) * std::max(1.0, inertia_) : 0;
    const double angle = tolerance_ * seconds + rounding * (pi + std::min(theta.abs().maxCoeff(), mostAngle));
    const double ofRates = std::max(rateTolerance_ * seconds, perStep_ * steps);
    const double rate = (ofRates + rounding) * (1 + omega.abs().maxCoeff());

    const double kinetic = 0.5 * inertia_ * rate * rate;
    const double elastic = 2 * stiffness_ * angle * angle;
    const double mostKinetic = std::max(now.kinetic, energyThen_.kinetic);
    const double mostElastic = std::max(now.elastic, energyThen_.elastic);
    // Root by root: a product of energies may overflow.
    return 2 * std::sqrt(mostKinetic) * std::sqrt(kinetic) + kinetic +
           2 * std::sqrt(mostElastic) * std::sqrt(elastic) + elastic + weight_ * angle + ofWorks;
  }

  int n_;
  double tolerance_, rateTolerance_;  ///< ε of angles and rates without rounding; 0 for fixed steps
  double perStep_;                    ///< the least ε of rates for each step of about the last second
  double share_;                      ///< of the exchanged energy
  double inertia_ = 0;                ///< Σ m ρ² + I
  double stiffness_ = 0;              ///< Σ k
  double weight_ = 0;                 ///< Σ m |g| ρ
  double then_ = 0;                   ///< the time of the last good state, s
  Energy energyThen_;
  Eigen::Vector2d worksThen_;
  double gap_ = 0, moved_ = 0, steps_ = 0;  ///< of about the last second
  double refused_ = 0;
};

/// The check of a simulation. Only the constructor allocates.
class EnergyGuard : public EnergyCheck {
 public:
  /// The scene and its dynamics must outlive this object.
  EnergyGuard(const Scene& scene, const Dynamics& dynamics) : EnergyCheck(scene), dynamics_(dynamics) {}

  /// W_s and W_d in a state in chain order.
  Eigen::Vector2d worksOf(const double* y) const {
    if (dynamics_.works() == 0) return Eigen::Vector2d::Zero();
    const double* works = y + dynamics_.size() - dynamics_.works();
    return {works[0], works[1]};
  }

  /// y: the same state in chain order.
  void begin(const ode::State& state, const double* y) {
    good_ = state;
    EnergyCheck::begin(state.t, dynamics_.energy(state.t, y), worksOf(y));
  }
  bool accept(const ode::State& state, const double* y, long long steps) {
    if (!EnergyCheck::accept(state.t, y, dynamics_.energy(state.t, y), worksOf(y), steps)) return false;
    good_ = state;
    return true;
  }
  const ode::State& lastGood() const { return good_; }
  /// The last good state, of the same energy and motion, but with other angles.
  void moveTo(const ode::State& state) { good_ = state; }
  void saveOrRestore(Snapshot& snapshot) {
    EnergyCheck::saveOrRestore(snapshot);
    snapshot(good_);
  }

 private:
  const Dynamics& dynamics_;
  ode::State good_;
};

}  // namespace planar_chain
