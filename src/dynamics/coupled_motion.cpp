#include "dynamics/coupled_motion.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace planar_chain {

CoupledMotion::CoupledMotion(const Mechanism& mechanism, Effects& effects)
    : mechanism_(mechanism),
      effects_(effects),
      n_(mechanism.size()),
      evaluator_(mechanism, effects),
      last_(evaluator_.none()),
      held_(n_),
      scratch_(index(n_)) {
  const std::vector<Coupler*>& couplers = effects.couplers();
  for (Coupler* coupler : couplers) coupler->attach(*this);
  const auto onlyHolds = [](const Coupler* coupler) { return coupler->onlyHolds(); };
  if (!couplers.empty() && std::all_of(couplers.begin(), couplers.end(), onlyHolds) &&
      Segments::areWorthwhile(n_)) {
    welded_.emplace(mechanism.chain(), index(n_));
  }
}

std::string CoupledMotion::recursion() const {
  return welded_ ? welded_->chain.name() : evaluator_.recursion();
}

void CoupledMotion::forget(bool holds) {
  last_.isKnown = false;
  if (holds) evaluator_.forgetCouplings();
  if (!welded_) return;
  welded_->isKnown = welded_->hasConstantMoments = false;
  if (holds) welded_->isWelded = false;
}

void CoupledMotion::prepareChange() {
  if (effects_.haveUncoupledSwitches()) forget();  // couplers do so themselves, if they change
}

// ---- Results -------------------------------------------------------------------------------------------

Powers CoupledMotion::weldedRates(double t, const double* y, double* slopes) {
  const Welded& at = weldedAt(t, y);
  std::copy_n(at.alpha.data(), n_, slopes);
  return at.powers;
}

Powers CoupledMotion::powers(double t, const double* y) {
  if (!isWelded()) return at(t, y).powers;
  // Nothing is driven, and no power depends on where the pins are.
  return weldedPowers({t, y, y + n_}, scratch_.data());
}

JointAnswer CoupledMotion::answer(double t, const double* y) {
  if (!isWelded()) {
    const Evaluation& at = this->at(t, y);
    return {at.moments.data(), at.slopes()};
  }
  weldedAt(t, y);
  if (!std::exchange(welded_->hasMoments, true)) {
    welded_->chain.moments(welded_->N.data(), welded_->moments.data());
  }
  return {welded_->moments.data(), welded_->alpha.data()};
}

void CoupledMotion::torques(double t, const double* y, double* tau) {
  const Evaluation& at = this->at(t, y);
  std::fill_n(tau, n_, 0.0);
  for (const auto& effect : effects_.all()) {
    if (effect->coupler()) effect->addTorques(at.state(), tau);
  }
  // Rotors are inertia, not torque.
  for (int i = 0; i < n_; ++i) {
    const Coupling<double>& joint = evaluator_.couplings().joints[index(i)];
    if (joint.isHeld) tau[i] += at.moments[index(i)] + joint.rotor * relative(at.slopes(), i);
  }
}

// ---- The welded chain ----------------------------------------------------------------------------------

bool CoupledMotion::Welded::isAt(double time, const double* state) const {
  return isKnown && time == t && std::memcmp(state, y.data(), y.size() * sizeof *state) == 0;
}

Powers CoupledMotion::weldedPowers(const ChainState& at, double* N) {
  Powers powers;
  if (N) std::fill_n(N, n_, 0.0);
  for (Effect* effect : effects_.active()) powers += effect->apply(at, {N, nullptr});
  return powers;
}

const CoupledMotion::Welded& CoupledMotion::weldedAt(double t, const double* y) {
  Welded& to = *welded_;
  if (to.isAt(t, y)) return to;
  ++evaluations_;
  if (!to.isWelded) {
    effects_.couple(t, 0, held_);
    to.chain.weld(held_);
    to.isWelded = true;
  }
  to.isKnown = true;
  to.hasMoments = false;
  to.t = t;
  std::copy_n(y, 2 * n_, to.y.begin());
  double* N = to.hasConstantMoments ? nullptr : to.N.data();
  to.powers = weldedPowers(to.state(), N);
  to.chain.accelerations(to.y.data(), to.y.data() + n_, N, to.alpha.data());
  to.hasConstantMoments = effects_.haveConstantMoments();
  return to;
}

// ---- Held joints ---------------------------------------------------------------------------------------

bool CoupledMotion::hold(double t, double* y) {
  effects_.couple(t, 0, held_);
  bool any = false;
  for (int i = 0; i < n_; ++i) {
    if (!held_.joints[index(i)].isHeld) continue;
    any = true;
    const GivenMotion& motion = held_.held[index(i)];
    y[i] = (i > 0 ? y[i - 1] : 0) + motion.value;
    y[n_ + i] = (i > 0 ? y[n_ + i - 1] : 0) + motion.rate;
  }
  return any;
}

void CoupledMotion::hold(double t, double* q, double* qd) {
  effects_.couple(t, 0, held_);
  for (int i = 0; i < n_; ++i) {
    if (!held_.joints[index(i)].isHeld) continue;
    q[i] = held_.held[index(i)].value;
    qd[i] = held_.held[index(i)].rate;
  }
}

}  // namespace planar_chain
