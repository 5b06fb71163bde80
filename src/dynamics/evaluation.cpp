#include "dynamics/evaluation.h"

#include <algorithm>

#include "dynamics/inner_end.h"
#include "recursion/coupled.h"

namespace planar_chain {

Evaluation::Evaluation(const Mechanism& mechanism, const Effects& effects)
    : isPlain(!effects.base() && !mechanism.hasEnds()), ground(-1.0 * mechanism.chain().gravity()) {
  const auto n = index(mechanism.size());
  y.resize(2 * n);
  e.resize(index(ShortChain::roomFor(mechanism.size())));
  for (auto* numbers : {&N, &alpha, &moments}) numbers->resize(n);
  for (auto* vectors : {&F, &pinVelocity}) vectors->resize(n);
  if (effects.anyForces(&Forces::dependOnPlace)) pin.resize(n);
  if (!effects.base()) return;
  for (auto* numbers : {&turning, &slopesOnBase}) numbers->resize(n);
}

Evaluator::Evaluator(const Mechanism& mechanism, Effects& effects)
    : mechanism_(mechanism),
      effects_(effects),
      n_(mechanism.size()),
      recursion_(mechanism.bodies()),
      couplings_(n_),
      torques_(index(n_)) {}

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
  coupleRecursion();
}

void Evaluator::coupleRecursion() {
  recursion_.couple(couplings_.joints.data() + mechanism_.slides());
  if (!mechanism_.hasEnds()) return;
  inner_ = innerEndOf(mechanism_.chain(), couplings_.joints.data());
  tip_ = couplings_.tip;
  tip_.acceleration -= mechanism_.chain().gravity();
}

void Evaluator::evaluate(double t, const double* y, Evaluation& to) {
  to.isKnown = true;
  to.t = t;
  std::copy_n(y, 2 * n_, to.y.begin());

  // What is given at t.
  takeCouplings(t);
  if (!to.isPlain) {
    to.base = couplings_.base();
    to.ground = couplings_.pinAcceleration() - mechanism_.chain().gravity();
    to.groundTurning = couplings_.angle.acceleration;
  }

  const bool areTurned = effects_.acting() == LoadKind::forces;
  const double* theta = to.isPlain && !areTurned ? to.y.data() : turn(to);
  if (areTurned) placePins(to);
  std::fill(to.N.begin(), to.N.end(), 0.0);
  to.powers = effects_.act() ? effects_.apply(to.state(), {to.N.data(), to.F.data()}) : Powers{};
  run(to, theta);
  for (std::size_t i = 0; i < to.slopesOnBase.size(); ++i) {
    to.slopesOnBase[i] = to.alpha[i] - (i < index(mechanism_.slides()) ? 0 : to.groundTurning);
  }
  if (anyIsGiven_) to.powers.supplied += couplingPower(to);
}

/// The places and velocities of the pins, where forces act.
void Evaluator::placePins(Evaluation& to) const {
  std::fill(to.F.begin(), to.F.end(), Vec2d{});
  Vec2d x = to.base.pin, v = to.base.velocity;
  const auto slides = index(mechanism_.slides());
  if (slides > 0) {
    const Rails<double> rails = railsOf(mechanism_.chain(), to.turn(), to.y.data(), to.y.data() + n_);
    for (std::size_t i = 0; i < slides; ++i) {
      to.pinVelocity[i] = v + rails.own[i].velocity;
      if (!to.pin.empty()) to.pin[i] = x + rails.own[i].place;
    }
    x += rails.first.place;
    v += rails.first.velocity;
  }
  mechanism_.findPinVelocities(to.e.data(), to.omega(), effects_.reach(), to.pinVelocity.data(), v);
  for (std::size_t j = slides; j < to.pin.size(); ++j) {
    to.pin[j] = x;
    x += to.e[j] * mechanism_.chain().links()[j].pin;
  }
}

/// Rates and rotations against the ground. Returns the angles if the recursion may turn by them itself.
const double* Evaluator::turn(Evaluation& to) const {
  const int slides = mechanism_.slides();
  for (std::size_t j = 0; j < to.turning.size(); ++j) {
    to.turning[j] = to.y[index(n_) + j] + (j < index(slides) ? 0 : to.base.rate);
  }
  if (!to.turning.empty() && slides > 0) std::fill_n(to.e.begin(), slides, plainRotation(to.base.angle));
  if (to.base.angle == 0 && effects_.acting() != LoadKind::forces) return to.y.data() + slides;
  mechanism_.rotate(to.y.data(), to.base.angle, to.e.data());
  return nullptr;
}

/// theta: of the bodies, or nullptr if they are turned.
inline void Evaluator::run(Evaluation& to, const double* theta) {
  if (mechanism_.hasEnds()) return runBetweenEnds(to, theta);
  to.pinForce = recursion_.accelerations({to.e.data(), to.N.data(), forces(to), to.ground}, theta, to.omega(),
                                         to.groundTurning, to.alpha.data(), to.moments.data());
}

void Evaluator::runBetweenEnds(Evaluation& to, const double* theta) {
  const bool onBase = !to.turning.empty();
  if (onBase && mechanism_.slides() > 0) return runOnRails(to, theta);
  setForces(to.N.data(), forces(to), inner_);
  sweepBetweenEnds(to, theta, to.ground);
  if (onBase) to.pinForce = to.ends.pinForce;
}

/// The base moves slides.
[[gnu::noinline]] void Evaluator::runOnRails(Evaluation& to, const double* theta) {
  const Chain& chain = mechanism_.chain();
  const Rails<double> rails = railsOf(chain, to.turn(), to.y.data(), to.y.data() + n_);
  setForces(to.N.data(), forces(to), inner_, to.turnsRails() ? &rails : nullptr);
  sweepBetweenEnds(to, theta, to.ground + rails.first.drift);
  const OfBase<double> by = ofBase(inner_, to.ends, to.ground, forces(to), rails);
  to.pinForce = by.force;
  to.slidesMoment = by.moment;
  for (int i = 0; i < chain.slides(); ++i)
    to.slidesMoment += chain.links()[index(i)].inertia * to.groundTurning;
}

inline void Evaluator::sweepBetweenEnds(Evaluation& to, const double* theta, Vec2d ground) {
  const int slides = mechanism_.slides();
  const Vec2d* F = forces(to);
  recursion_.accelerations({to.e.data() + slides, to.N.data() + slides, F ? F + slides : nullptr, ground},
                           theta, to.omega() + slides, to.groundTurning, inner_, tip_,
                           to.alpha.data() + slides, to.moments.data() + slides, to.ends);
  std::copy_n(to.ends.acceleration.begin(), slides, to.alpha.begin());
  writeHolding(inner_, to.ends, to.moments.data());
}

/// The power of drives and base, W.
double Evaluator::couplingPower(const Evaluation& at) {
  double power = 0;
  for (int i = 0; i < n_; ++i) {
    const Coupling<double>& joint = couplings_.joints[index(i)];
    if (!joint.isHeld) continue;
    power += (at.moments[index(i)] + joint.rotor * joint.acceleration) * couplings_.held[index(i)].rate;
  }
  if (at.isPlain) return power;
  power += dot(at.ends.tipForce, couplings_.tipVelocity);
  if (at.base.rate != 0) {
    std::fill(torques_.begin(), torques_.end(), 0.0);
    effects_.addTorques(at.state(), torques_.data());
    const std::size_t first = index(mechanism_.slides());
    power += (at.moments[first] + torques_[first] + at.slidesMoment) * at.base.rate;
  }
  return power + dot(at.pinForce, at.base.velocity);
}

void Evaluator::invert(const Evaluation& at, const double* less, const double* qdd, double* moments) {
  Evaluation asked = at;
  for (int i = 0; i < n_; ++i) {
    mechanism_.coordinates().addTorque(-less[i], i, asked.N.data());
    couplings_.joints[index(i)] = {0, true, qdd[i]};
  }
  coupleRecursion();
  run(asked, nullptr);
  std::copy(asked.moments.begin(), asked.moments.end(), moments);
  forgetCouplings();
}

}  // namespace planar_chain
