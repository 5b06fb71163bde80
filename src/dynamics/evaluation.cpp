#include "dynamics/evaluation.h"

#include <algorithm>

#include "recursion/coupled.h"

namespace planar_chain {

Evaluation::Evaluation(int n, bool baseMoves, bool hasPlaces) {
  y.resize(2 * index(n));
  e.resize(index(ShortChain::roomFor(n)));
  for (auto* numbers : {&N, &alpha, &moments}) numbers->resize(index(n));
  for (auto* vectors : {&F, &pinVelocity}) vectors->resize(index(n));
  if (hasPlaces) pin.resize(index(n));
  if (!baseMoves) return;
  for (auto* numbers : {&turning, &slopesOnBase}) numbers->resize(index(n));
}

Evaluator::Evaluator(const Mechanism& mechanism, Effects& effects)
    : mechanism_(mechanism),
      effects_(effects),
      n_(mechanism.size()),
      recursion_(mechanism.chain()),
      couplings_(n_),
      torques_(index(n_)) {}

Evaluation Evaluator::none() const {
  Evaluation none(n_, effects_.base() != nullptr, effects_.anyForces(&Forces::dependOnPlace));
  none.ground = -1.0 * mechanism_.chain().gravity();
  return none;
}

// ---- A state -----------------------------------------------------------------------------------------

/// Effects that do not vary with time couple the same until forgetCouplings().
inline void Evaluator::takeCouplings(double t) {
  if (!hasCouplings_) {
    effects_.couple(t, 0, couplings_);
  } else if (effects_.coupleInTime()) {
    effects_.coupleInTime(t, couplings_);
  } else {
    return;
  }
  hasCouplings_ = true;
  anyIsGiven_ = effects_.base() || std::any_of(couplings_.joints.begin(), couplings_.joints.end(),
                                               [](const Coupling<double>& joint) { return joint.isHeld; });
  recursion_.couple(couplings_.joints.data());
}

inline void Evaluator::applyEffects(Evaluation& to) {
  std::fill(to.N.begin(), to.N.end(), 0.0);
  to.powers = {};
  for (Effect* effect : effects_.active()) to.powers += effect->apply(to.state(), {to.N.data(), to.F.data()});
}

void Evaluator::evaluate(double t, const double* y, Evaluation& to) {
  to.isKnown = true;
  to.t = t;
  std::copy_n(y, 2 * n_, to.y.begin());

  // What is given at t.
  takeCouplings(t);
  const bool baseMoves = !to.turning.empty(), hasForces = effects_.acting() == LoadKind::forces;
  if (baseMoves) {
    to.base = couplings_.base();
    to.ground = couplings_.pinAcceleration() - mechanism_.chain().gravity();
    to.groundTurning = couplings_.angle.acceleration;
  }

  // Rotations and rates against the ground. The recursion computes rotations that nothing else needs.
  const double* theta = to.y.data();
  if (baseMoves || hasForces) {
    mechanism_.rotate(theta, to.e.data(), n_);
    theta = nullptr;
  }
  if (baseMoves) {
    const Rotation<double> turn = plainRotation(to.base.angle);
    for (Rotation<double>& e : to.e) e = turn * e;
    for (int j = 0; j < n_; ++j) to.turning[index(j)] = to.y[index(n_ + j)] + to.base.rate;
  }
  if (hasForces) {
    std::fill(to.F.begin(), to.F.end(), Vec2d{});
    mechanism_.findPinVelocities(to.e.data(), to.omega(), effects_.reach(), to.pinVelocity.data());
    for (int j = 0; j < effects_.reach(); ++j) to.pinVelocity[index(j)] += to.base.velocity;
    Vec2d x = to.base.pin;
    for (std::size_t j = 0; j < to.pin.size(); ++j) {
      to.pin[j] = x;
      x += to.e[j] * mechanism_.chain().links()[j].pin;
    }
  }

  applyEffects(to);
  to.pinForce = recursion_.accelerations({to.e.data(), to.N.data(), forces(to), to.ground}, theta, to.omega(),
                                         to.groundTurning, to.alpha.data(), to.moments.data());
  for (std::size_t i = 0; i < to.slopesOnBase.size(); ++i) {
    to.slopesOnBase[i] = to.alpha[i] - to.groundTurning;
  }
  if (anyIsGiven_) to.powers.supplied += couplingPower(to);
}

/// The power of drives and base, W.
double Evaluator::couplingPower(const Evaluation& at) {
  double power = 0;
  for (int i = 0; i < n_; ++i) {
    const Coupling<double>& joint = couplings_.joints[index(i)];
    if (!joint.isHeld) continue;
    power += (at.moments[index(i)] + joint.rotor * joint.acceleration) * couplings_.held[index(i)].rate;
  }
  if (at.turning.empty()) return power;
  if (at.base.rate != 0) {
    std::fill(torques_.begin(), torques_.end(), 0.0);
    for (Effect* effect : effects_.active()) effect->addTorques(at.state(), torques_.data());
    power += (at.moments[0] + torques_[0]) * at.base.rate;
  }
  return power + dot(at.pinForce, at.base.velocity);
}

void Evaluator::invert(const Evaluation& at, const double* less, const double* qdd, double* moments) {
  std::vector<double> N = at.N, alpha(at.alpha.size());
  std::vector<Rotation<double>> e = at.e;
  std::vector<Coupling<double>> joints(index(n_));
  for (int i = 0; i < n_; ++i) {
    addJointTorque(-less[i], i, N.data());
    joints[index(i)] = {0, true, qdd[i]};
  }
  recursion_.couple(joints.data());
  recursion_.accelerations({e.data(), N.data(), forces(at), at.ground}, nullptr, at.omega(), at.groundTurning,
                           alpha.data(), moments);
  forgetCouplings();
}

}  // namespace planar_chain
