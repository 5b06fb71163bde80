#include "dynamics/general_motion.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

namespace planar_chain {

GeneralMotion::GeneralMotion(const Mechanism& mechanism, Effects& effects)
    : coordinates_(mechanism.coordinates()),
      effects_(effects),
      n_(mechanism.size()),
      evaluator_(mechanism, effects),
      stepped_(mechanism, effects),
      asked_(stepped_),
      whole_(stepped_),
      queried_(stepped_),
      couplingsNow_(n_),
      scratch_(index(n_)),
      snapped_(2 * scratch_.size()) {
  const std::vector<JointConstraint*>& jointConstraints = effects.jointConstraints();
  for (JointConstraint* jointConstraint : jointConstraints) jointConstraint->attach(*this);
  if (effects.holdTip()) closure_.emplace(mechanism);
  if (!mechanism.coordinates().anyIsPrismatic() && effects.onlyHold() && n_ > ShortChain::most) {
    welded_.emplace(mechanism);
  }
}

std::string GeneralMotion::recursion() const {
  return welded_ ? welded_->chain.name() : evaluator_.recursion();
}

void GeneralMotion::forget(bool holds) {
  stepped_.isKnown = asked_.isKnown = whole_.isKnown = queried_.isKnown = false;
  if (holds) evaluator_.forgetCouplings();
  if (!welded_) return;
  welded_->hasConstantMoments = false;
  if (holds) welded_->isWelded = false;
}

void GeneralMotion::prepareChange() {
  if (effects_.haveUncoupledEvents()) forget();  // joint constraints do so themselves, if they change
}

void GeneralMotion::saveOrRestore(Snapshot& snapshot) {
  if (snapshot.isReading()) forget();
  for (Evaluation* known : {&stepped_, &asked_}) {
    bool isKnown = known->isKnown;
    snapshot(isKnown);
    if (!isKnown) continue;
    snapshot(known->t, known->y);
    if (!snapshot.isReading()) continue;
    snapped_ = known->y;
    isWelded() ? runWelded(known->t, snapped_.data(), *known)
               : evaluator_.evaluate(known->t, snapped_.data(), *known);
  }
  snapshot(evaluations_);
}

// ---- Results -------------------------------------------------------------------------------------------

namespace {

/// True if two states differ by rounding alone.
bool areEqual(const double* y, const double* other, int n) {
  constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();
  using Part = Eigen::Map<const Eigen::ArrayXd>;
  const auto areNear = [&](int from, int count, double least) {
    const Part a(y + from, count), b(other + from, count);
    const double most = ((a - b).abs() - rounding * (a.abs() + b.abs())).maxCoeff();
    return most <= rounding * least && std::isfinite(a.sum());
  };
  return areNear(0, 1, 1) && areNear(0, n, 1) && areNear(n, n, 0);
}

}  // namespace

void GeneralMotion::endedAt(ode::State& state) const {
  if (!stepped_.isKnown || state.t != stepped_.t || !areEqual(stepped_.y.data(), state.y.data(), n_)) return;
  const Eigen::Map<const Eigen::VectorXd> there(stepped_.y.data(), 2 * n_);
  state.carry.head(2 * n_) += state.y.head(2 * n_) - there;  // exact, as they are so near
  state.y.head(2 * n_) = there;
}

const Evaluation& GeneralMotion::at(double t, const double* y) {
  if (!isWelded()) return at(t, y, asked_, stepped_);
  if (whole_.isAt(t, y)) return whole_;
  ++evaluations_;
  evaluator_.evaluate(t, y, whole_);
  return whole_;
}

const Evaluation& GeneralMotion::query(double t, const double* y) {
  for (const Evaluation* known : {&stepped_, &asked_}) {
    if (!isWelded() && known->isAt(t, y)) return *known;
  }
  if (!queried_.isAt(t, y)) evaluator_.evaluate(t, y, queried_);
  return queried_;
}

Powers GeneralMotion::powers(double t, const double* y) {
  if (!isWelded()) return at(t, y).powers;
  // Nothing is driven, and no power depends on where the pins are.
  return weldedPowers({t, y, y + n_}, scratch_.data());
}

JointAnswer GeneralMotion::answer(double t, const double* y) {
  const Evaluation& known = at(t, y, asked_, stepped_);
  if (isWelded() && !known.hasMoments) {
    Evaluation& own = &known == &asked_ ? asked_ : stepped_;
    if (welded_->last != &own) {
      ++evaluations_;
      runWelded(t, y, own);
    }
    welded_->chain.moments(own.N.data(), own.moments.data());
    own.hasMoments = true;
  }
  return {known.moments.data(), known.slopes()};
}

void GeneralMotion::torques(double t, const double* y, double* tau) {
  const Evaluation& at = query(t, y);
  const std::vector<JointLaw<double>>& joints = couplings(t).joints;
  std::fill_n(tau, n_, 0.0);
  for (const auto& effect : effects_.all()) {
    if (effect->jointConstraint()) effect->addTorques(at.state(), tau);
  }
  // Rotors are inertia, not torque.
  for (int i = 0; i < n_; ++i) {
    const JointLaw<double>& joint = joints[index(i)];
    if (joint.isPrescribed)
      tau[i] += at.moments[index(i)] + joint.armature * coordinates_.relative(at.slopes(), i);
  }
}

// ---- The welded chain ----------------------------------------------------------------------------------

Powers GeneralMotion::weldedPowers(const ChainState& at, double* N) {
  if (N) std::fill_n(N, n_, 0.0);
  return effects_.apply(at, {N, nullptr});
}

void GeneralMotion::runWelded(double t, const double* y, Evaluation& to) {
  Welded& welded = *welded_;
  if (!welded.isWelded) {
    welded.chain.weld(couplings(t));
    welded.isWelded = true;
  }
  to.isKnown = true;
  to.hasMoments = false;
  to.t = t;
  std::copy_n(y, 2 * n_, to.y.begin());
  // Moments that are the same in every state are summed once.
  if (welded.hasConstantMoments && welded.last != &to) to.N = welded.last->N;
  double* N = welded.hasConstantMoments ? nullptr : to.N.data();
  to.powers = weldedPowers({t, y, y + n_}, N);
  welded.chain.accelerations(to.y.data(), to.y.data() + n_, N, to.xdd.data());
  welded.hasConstantMoments = effects_.haveConstantMoments();
  welded.last = &to;
}

// ---- Prescribed joints: driven or stuck ----------------------------------------------------------------

const Couplings& GeneralMotion::couplings(double t) {
  effects_.couple(t, 0, couplingsNow_);
  return couplingsNow_;
}

bool GeneralMotion::hold(double t, double* y) {
  const Couplings& given = couplings(t);
  bool any = false;
  for (int i = 0; i < n_; ++i) {
    if (!given.joints[index(i)].isPrescribed) continue;
    any = true;
    const GivenMotion& motion = given.prescribed[index(i)];
    const int inner = coordinates_.inner(i);
    y[i] = (inner >= 0 ? y[inner] : 0) + motion.value;
    y[n_ + i] = (inner >= 0 ? y[n_ + inner] : 0) + motion.rate;
  }
  return any;
}

void GeneralMotion::snapPrescribed(double t, double* y, double most) {
  if (!closure_) {
    hold(t, y);
    return;
  }
  std::copy_n(y, 2 * n_, snapped_.begin());
  if (!project(t, snapped_.data(), nullptr)) return;
  const Eigen::Map<const Eigen::ArrayXd> before(y, 2 * n_), after(snapped_.data(), 2 * n_);
  if (((after - before).abs() <= most * (1 + before.abs())).all()) std::copy_n(after.data(), 2 * n_, y);
}

bool GeneralMotion::project(double t, double* y, double* carry) {
  hold(t, y);
  return !closure_ || closure_->project(couplingsNow_, y, carry);
}

}  // namespace planar_chain
