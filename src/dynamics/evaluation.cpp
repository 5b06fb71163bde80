#include "dynamics/evaluation.h"

#include <algorithm>

#include "dynamics/inner_end.h"
#include "recursion/coupled.h"

namespace planar_chain {

Evaluation::Evaluation(int n, bool isPlain, bool hasPlaces) {
  y.resize(2 * index(n));
  e.resize(index(ShortChain::roomFor(n)));
  for (auto* numbers : {&N, &alpha, &moments}) numbers->resize(index(n));
  for (auto* vectors : {&F, &pinVelocity}) vectors->resize(index(n));
  if (hasPlaces) pin.resize(index(n));
  if (isPlain) return;
  for (auto* numbers : {&turning, &slopesOnBase}) numbers->resize(index(n));
}

Evaluator::Evaluator(const Mechanism& mechanism, Effects& effects)
    : mechanism_(mechanism),
      effects_(effects),
      n_(mechanism.size()),
      recursion_(mechanism.bodies()),
      couplings_(n_),
      torques_(index(n_)) {
  if (mechanism.hasEnds()) ended_.emplace(mechanism.bodies());
}

Evaluation Evaluator::none() const {
  Evaluation none(n_, isPlain(), effects_.anyForces(&Forces::dependOnPlace));
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
  anyIsGiven_ = effects_.base() || couplings_.tip.rows > 0 ||
                std::any_of(couplings_.joints.begin(), couplings_.joints.end(),
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
  if (!to.turning.empty()) return evaluateMoving(to);

  // Rotations. The recursion computes those that nothing else needs.
  const double* theta = to.y.data();
  if (effects_.acting() == LoadKind::forces) {
    mechanism_.rotate(theta, to.e.data(), n_);
    theta = nullptr;
    placePins(to);
  }
  applyEffects(to);
  to.pinForce = recursion_.accelerations({to.e.data(), to.N.data(), forces(to), to.ground}, theta, to.omega(),
                                         to.groundTurning, to.alpha.data(), to.moments.data());
  if (anyIsGiven_) to.powers.supplied += couplingPower(to);
}

/// The places and velocities of the pins, where forces act.
void Evaluator::placePins(Evaluation& to) const {
  std::fill(to.F.begin(), to.F.end(), Vec2d{});
  const Chain& chain = mechanism_.chain();
  const int slides = mechanism_.slides(), reach = effects_.reach();
  Vec2d x = to.base.pin, v;
  for (int i = 0; i < slides; ++i) {
    const Vec2d axis = chain.joints()[index(i)].axis;
    x += to.y[index(i)] * axis;
    v += to.y[index(n_ + i)] * axis;
    to.pinVelocity[index(i)] = v;
    if (!to.pin.empty()) to.pin[index(i)] = x;
    x += chain.links()[index(i)].pin;
  }
  mechanism_.findPinVelocities(to.e.data(), to.omega(), reach, to.pinVelocity.data(), slides, v);
  for (int j = 0; j < reach; ++j) to.pinVelocity[index(j)] += to.base.velocity;
  for (std::size_t j = index(slides); j < to.pin.size(); ++j) {
    to.pin[j] = x;
    x += to.e[j] * chain.links()[j].pin;
  }
}

/// The base moves, or the chain has ends. Rotations and rates against the ground.
[[gnu::noinline]] void Evaluator::evaluateMoving(Evaluation& to) {
  to.base = couplings_.base();
  to.ground = couplings_.pinAcceleration() - mechanism_.chain().gravity();
  to.groundTurning = couplings_.angle.acceleration;

  const int slides = mechanism_.slides();
  mechanism_.rotate(to.y.data() + slides, to.e.data() + slides, n_ - slides);
  const Rotation<double> turn = plainRotation(to.base.angle);
  for (int j = slides; j < n_; ++j) to.e[index(j)] = turn * to.e[index(j)];
  for (int j = 0; j < n_; ++j) {
    to.turning[index(j)] = to.y[index(n_ + j)] + (j < slides ? 0 : to.base.rate);
  }
  if (effects_.acting() == LoadKind::forces) placePins(to);

  applyEffects(to);
  if (ended_) {
    runEnded(to);
  } else {
    to.pinForce = recursion_.accelerations({to.e.data(), to.N.data(), forces(to), to.ground}, nullptr,
                                           to.omega(), to.groundTurning, to.alpha.data(), to.moments.data());
  }
  for (int i = 0; i < n_; ++i) {
    to.slopesOnBase[index(i)] = to.alpha[index(i)] - (i < slides ? 0 : to.groundTurning);
  }
  if (anyIsGiven_) to.powers.supplied += couplingPower(to);
}

void Evaluator::runEnded(Evaluation& to) {
  const int slides = mechanism_.slides();
  const Vec2d* F = forces(to);
  const Coupling<double>* joints = couplings_.joints.data();
  const InnerEnd<double> inner = innerEndOf(mechanism_.chain(), joints, to.N.data(), F);
  to.ends = ended_->accelerations(
      to.e.data() + slides, to.omega() + slides,
      {to.N.data() + slides, F ? F + slides : nullptr, joints + slides, to.ground, to.groundTurning}, inner,
      tipOf(mechanism_.chain(), couplings_), to.alpha.data() + slides, to.moments.data() + slides);
  std::copy_n(to.ends.acceleration.begin(), slides, to.alpha.begin());
  writeHolding(inner, to.ends, to.moments.data());
  to.pinForce = to.ends.pinForce;
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
  power += dot(at.ends.tipForce, couplings_.tipVelocity);
  if (at.base.rate != 0) {
    std::fill(torques_.begin(), torques_.end(), 0.0);
    for (Effect* effect : effects_.active()) effect->addTorques(at.state(), torques_.data());
    power += (at.moments[0] + torques_[0]) * at.base.rate;
  }
  return power + dot(at.pinForce, at.base.velocity);
}

void Evaluator::invert(const Evaluation& at, const double* less, const double* qdd, double* moments) {
  Evaluation asked = at;
  for (int i = 0; i < n_; ++i) {
    mechanism_.coordinates().addTorque(-less[i], i, asked.N.data());
    couplings_.joints[index(i)] = {0, true, qdd[i]};
  }
  if (ended_) {
    runEnded(asked);
    std::copy(asked.moments.begin(), asked.moments.end(), moments);
  } else {
    recursion_.couple(couplings_.joints.data());
    recursion_.accelerations({asked.e.data(), asked.N.data(), forces(asked), asked.ground}, nullptr,
                             asked.omega(), asked.groundTurning, asked.alpha.data(), moments);
  }
  forgetCouplings();
}

}  // namespace planar_chain
