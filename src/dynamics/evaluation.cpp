#include "dynamics/evaluation.h"

#include <algorithm>

namespace planar_chain {

Evaluation::Evaluation(const Mechanism& mechanism, const Effects& effects)
    : isPlain(!effects.base() && !effects.holdTip()), ground(-1.0 * mechanism.chain().gravity()) {
  const auto n = index(mechanism.size());
  const bool isMixed = mechanism.coordinates().anyIsPrismatic(), moves = effects.base();
  y.resize(2 * n);
  e.resize(index(ShortChain::roomFor(mechanism.size())));
  for (auto* numbers : {&N, &xdd, &moments}) numbers->resize(n);
  if (effects.mostActing() == LoadKind::forces) {
    for (auto* vectors : {&F, &pinVelocity}) vectors->resize(n);
  }
  if (effects.anyForces(&Forces::dependOnPosition)) pin.resize(n);
  if (isMixed) displaced.resize(n);
  if (isMixed || moves) bodyRates.resize(n);
  if (moves) slopesOnBase.resize(n);
}

Evaluator::Evaluator(const Mechanism& mechanism, const Effects& effects)
    : mechanism_(mechanism),
      effects_(effects),
      n_(mechanism.size()),
      recursion_(mechanism.makeGeneralRecursion(effects.base() != nullptr)),
      couplings_(n_),
      torques_(index(n_)),
      angles_(mechanism.coordinates().anyIsPrismatic() ? index(n_) : 0) {}

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
                            [](const JointLaw<double>& joint) { return joint.isPrescribed; });
  takeLaws();
}

void Evaluator::takeLaws() {
  recursion_.take(couplings_.joints.data());
  tip_ = couplings_.tip;
  tip_.acceleration -= mechanism_.chain().gravity();
}

void Evaluator::evaluate(double t, const double* y, Evaluation& to) {
  to.isKnown = true;
  to.t = t;
  std::copy_n(y, 2 * n_, to.y.begin());

  // Take the prescribed motions at t.
  takeCouplings(t);
  if (!to.isPlain) {
    to.base = couplings_.base();
    to.ground = couplings_.pinAcceleration() - mechanism_.chain().gravity();
    to.groundTurning = couplings_.angle.acceleration;
  }

  const bool turnsThere = to.isPlain && angles_.empty() && effects_.acting() != LoadKind::forces;
  const double* angles = turnsThere ? to.y.data() : pose(to);
  if (effects_.acting() == LoadKind::forces) findPins(to);
  std::fill(to.N.begin(), to.N.end(), 0.0);
  to.powers = effects_.act() ? effects_.apply(to.state(), {to.N.data(), to.F.data()}) : Powers{};
  run(to, angles);
  for (std::size_t i = 0; i < to.slopesOnBase.size(); ++i) {
    const bool isAngle = !mechanism_.coordinates().isPrismatic(static_cast<int>(i));
    to.slopesOnBase[i] = to.xdd[i] - (isAngle ? to.groundTurning : 0);
  }
  if (anyIsGiven_) to.powers.supplied += couplingPower(to);
}

/// The rates and rotations of the bodies, and prismatic joints. Returns the angles if the recursion may
/// rotate the bodies itself.
const double* Evaluator::pose(Evaluation& to) {
  const Coordinates& coordinates = mechanism_.coordinates();
  const double *x = to.y.data(), *rates = x + n_;
  const double* angles = x;
  if (!to.bodyRates.empty()) mechanism_.toBodies(rates, to.base.rate, to.bodyRates.data());
  if (to.base.angle != 0 || effects_.acting() == LoadKind::forces || coordinates.anyIsInside()) {
    mechanism_.rotate(x, to.base.angle, to.e.data());
    angles = nullptr;
  } else if (!angles_.empty()) {
    mechanism_.toBodies(x, 0, angles_.data());
    std::fill_n(to.e.begin(), coordinates.leading(), Rotation<double>{});
    angles = angles_.data();
  }
  const int end = coordinates.anyIsInside() ? n_ : coordinates.leading();
  for (int j = 0; j < end; ++j) {
    const auto i = index(j);
    if (coordinates.isPrismatic(j))
      to.displaced[i] =
          displacementOf(mechanism_.chain().joints()[i].axis, to.e[i], to.bodyRates[i], x[j], rates[j]);
  }
  return angles;
}

/// The positions and velocities of the pins, where forces act.
void Evaluator::findPins(Evaluation& to) const {
  std::fill(to.F.begin(), to.F.end(), Vec2d{});
  const int count = to.pin.empty() ? effects_.reach() : n_;
  sweepOutwards(mechanism_.chain(), 0, count, PointAt<double>{to.base.pin, to.base.velocity}, to.e.data(),
                to.omega(), to.y.data(), to.y.data() + n_, [&](int j, const PointAt<double>& pin) {
                  to.pinVelocity[index(j)] = pin.velocity;
                  if (!to.pin.empty()) to.pin[index(j)] = pin.position;
                });
}

inline void Evaluator::run(Evaluation& to, const double* angles) {
  recursion_.accelerations({to.e.data(), to.N.data(), forces(to), to.ground}, angles, to.omega(),
                           to.displaced.data(), to.groundTurning, tip_, to.xdd.data(), to.moments.data(),
                           to.ends);
}

/// The power of drives and base, W.
double Evaluator::couplingPower(const Evaluation& at) {
  double power = 0;
  for (int i = 0; i < n_; ++i) {
    const JointLaw<double>& joint = couplings_.joints[index(i)];
    if (!joint.isPrescribed) continue;
    power +=
        (at.moments[index(i)] + joint.armature * joint.acceleration) * couplings_.prescribed[index(i)].rate;
  }
  if (at.isPlain) return power;
  power += dot(at.ends.tip.force, couplings_.tipVelocity);
  if (at.base.rate != 0) {
    std::fill(torques_.begin(), torques_.end(), 0.0);
    effects_.addTorques(at.state(), torques_.data());
    const int first = mechanism_.coordinates().leading();
    power += (at.ends.baseMoment + (first < n_ ? torques_[index(first)] : 0)) * at.base.rate;
  }
  return power + dot(at.ends.baseForce, at.base.velocity);
}

void Evaluator::invert(const Evaluation& at, const double* less, const double* qdd, double* moments) {
  Evaluation asked = at;
  for (int i = 0; i < n_; ++i) {
    mechanism_.coordinates().addTorque(-less[i], i, asked.N.data());
    couplings_.joints[index(i)] = {0, true, qdd[i]};
  }
  takeLaws();
  run(asked, nullptr);
  std::copy(asked.moments.begin(), asked.moments.end(), moments);
  forgetCouplings();
}

}  // namespace planar_chain
