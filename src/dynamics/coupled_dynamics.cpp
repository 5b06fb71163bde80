#include "dynamics/coupled_dynamics.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace planar_chain {

bool isCoupled(const Scene& scene) {
  const auto& joints = scene.chain.joints();
  return scene.base || !scene.drives.empty() ||
         std::any_of(joints.begin(), joints.end(),
                     [](const Joint& joint) { return joint.other("rotor_inertia") > 0 || joint.mayStick(); });
}

std::unique_ptr<Dynamics> makeDynamics(const Scene& scene, std::unique_ptr<Effect> more) {
  if (isCoupled(scene)) return std::make_unique<CoupledDynamics>(scene, std::move(more));
  return std::make_unique<Dynamics>(scene, std::move(more));
}

CoupledDynamics::Evaluation::Evaluation(int n) {
  couplings.joints.resize(index(n));
  couplings.held.resize(index(n));
  y.resize(2 * index(n));
  e.resize(index(ShortChain::roomFor(n)));
  for (auto* numbers : {&N, &alpha, &moments}) numbers->resize(index(n));
  for (auto* vectors : {&F, &pinVelocity}) vectors->resize(index(n));
}

[[gnu::noinline]] bool CoupledDynamics::Evaluation::isAt(const double* state) const {
  return std::memcmp(state, y.data(), y.size() * sizeof *state) == 0;
}

CoupledDynamics::CoupledDynamics(const Scene& scene, std::unique_ptr<Effect> more)
    : Dynamics(scene, std::move(more), true),
      base_(scene.base),
      recursion_(scene.chain),
      now_(n_),
      aside_(n_),
      then_(n_),
      torques_(index(n_)),
      rates_(index(size())),
      bodies_(scene.chain),
      solver_{CoupledLinearized<double>(bodies_)} {
  for (const auto& effect : effects_.all()) {
    if (!effect->couples()) continue;
    coupling_.push_back(effect.get());
    effect->attach(*this);
  }
  varying_.reserve(coupling_.size());
  if (base_) {
    for (Evaluation* evaluation : {&now_, &aside_, &then_}) {
      evaluation->turning.resize(index(n_));
      evaluation->slopesOnBase.resize(index(n_));
    }
  }
  for (const Joint& joint : scene.chain.joints()) {
    double inertia = 0;
    for (const EffectKind* kind : effectKinds()) inertia += kind->inertiaIn(joint);
    rotors_.push_back(inertia);
  }
  const bool onlyRubs = !scene.base && scene.drives.empty() &&
                        std::all_of(rotors_.begin(), rotors_.end(), [](double J) { return J == 0; });
  if (onlyRubs && Segments::areWorthwhile(n_)) welded_.emplace(scene.chain);
}

// ---- The recursion ---------------------------------------------------------------------------------

namespace {

/// True if two states differ by rounding alone.
bool areEqual(const double* y, const double* other, int n) {
  constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();
  using Numbers = Eigen::Map<const Eigen::ArrayXd>;
  const auto areNear = [&](int from, int count, double least) {
    const Numbers a(y + from, count), b(other + from, count);
    const double most = ((a - b).abs() - rounding * (a.abs() + b.abs())).maxCoeff();
    return most <= rounding * least && std::isfinite(a.sum());
  };
  return areNear(0, 1, 1) && areNear(0, n, 1) && areNear(n, n, 0);
}

}  // namespace

BaseState CoupledDynamics::baseAt(double t) const {
  if (!base_) return {};
  const GivenMotion x = base_->x.at(t), y = base_->y.at(t), angle = base_->angle.at(t);
  return {{x.value, y.value}, {x.rate, y.rate}, angle.value, angle.rate};
}

void CoupledDynamics::followBase(const BaseLaws& laws) {
  base_ = laws;
  for (Effect* effect : coupling_) effect->followBase(laws);
}

/// Takes what couples at t, or this order of it.
void CoupledDynamics::collect(double t, int order, Couplings& to) const {
  std::fill(to.joints.begin(), to.joints.end(), Coupling<double>{});
  for (const Effect* effect : coupling_) effect->couple(t, order, to);
}

void CoupledDynamics::run(double t, const double* y, Known wanted, Evaluation& to) {
  const bool isSame = to.known != Known::nothing && t == to.t && to.isAt(y);
  if (isSame && to.known >= wanted) return;
  if (!isSame) {
    ++evaluations_;
    to.known = Known::nothing;
    to.t = t;
    std::copy_n(y, 2 * n_, to.y.begin());
  }
  if (welded_ && wanted != Known::all && effects_.acting() != LoadKind::forces) {
    runWelded(wanted, to);
  } else {
    wanted = Known::all;
    runCoupled(to);
  }
  for (std::size_t i = 0; i < to.slopesOnBase.size(); ++i) {
    to.slopesOnBase[i] = to.alpha[i] - to.couplings.angle.acceleration;
  }
  to.known = wanted;
}

void CoupledDynamics::runWelded(Known wanted, Evaluation& to) {
  if (!isWelded_) {
    collect(to.t, 0, aside_.couplings);
    welded_->weld(aside_.couplings);
    isWelded_ = true;
  }
  const double *theta = to.y.data(), *omega = theta + n_;
  if (to.known == Known::nothing) {
    const double* N = to.hasConstantMoments ? nullptr : to.N.data();
    if (N) {
      applyEffects(to);
    } else {
      to.powers = {};
      for (Effect* effect : effects_.active()) to.powers += effect->apply(to.state(), {});
    }
    welded_->accelerations(theta, omega, N, to.alpha.data());
    to.hasConstantMoments = effects_.haveConstantMoments();
  }
  if (wanted < Known::moments) return;
  welded_->moments(to.N.data(), to.moments.data());
}

/// Takes what couples at to.t. Effects that do not vary with time couple the same until forget().
void CoupledDynamics::takeCouplings(Evaluation& to) {
  if (!to.hasCouplings) {
    collect(to.t, 0, to.couplings);
    varying_.clear();
    std::copy_if(coupling_.begin(), coupling_.end(), std::back_inserter(varying_),
                 [](const Effect* effect) { return effect->variesWithTime(); });
    to.hasCouplings = true;
  } else if (varying_.empty()) {
    return;
  }
  for (const Effect* effect : varying_) effect->couple(to.t, 0, to.couplings);
  const auto& [joints, held, x, y, angle] = to.couplings;
  recursion_.couple(joints.data());
  to.base = {{x.value, y.value}, {x.rate, y.rate}, angle.value, angle.rate};
  to.ground = Vec2d{x.acceleration, y.acceleration} - mechanism_.chain().gravity();
}

void CoupledDynamics::runCoupled(Evaluation& to) {
  takeCouplings(to);

  // Rotations and rates against the ground. The recursion computes rotations that nothing else needs.
  const double* theta = to.y.data();
  const bool hasForces = effects_.acting() == LoadKind::forces;
  if (base_ || hasForces) {
    mechanism_.rotate(theta, to.e.data(), n_);
    theta = nullptr;
  }
  if (base_) {
    const Rotation<double> turn = plainRotation(to.base.angle);
    for (Rotation<double>& e : to.e) e = turn * e;
    for (int j = 0; j < n_; ++j) to.turning[index(j)] = to.y[index(n_ + j)] + to.base.rate;
  }
  if (hasForces) {
    std::fill(to.F.begin(), to.F.end(), Vec2d{});
    mechanism_.findPinVelocities(to.e.data(), to.omega(), effects_.reach(), to.pinVelocity.data());
    for (int j = 0; j < effects_.reach(); ++j) to.pinVelocity[index(j)] += to.base.velocity;
  }
  applyEffects(to);
  to.pinForce = recursion_.accelerations(
      {to.e.data(), to.N.data(), hasForces ? to.F.data() : nullptr, to.ground}, theta, to.omega(),
      to.couplings.angle.acceleration, to.alpha.data(), to.moments.data());
}

void CoupledDynamics::applyEffects(Evaluation& to) {
  std::fill(to.N.begin(), to.N.end(), 0.0);
  to.powers = {};
  for (Effect* effect : effects_.active()) to.powers += effect->apply(to.state(), {to.N.data(), to.F.data()});
}

/// The torque of the effects in joint i, N m.
double CoupledDynamics::torqueIn(int i) {
  std::fill(torques_.begin(), torques_.end(), 0.0);
  for (Effect* effect : effects_.active()) effect->addTorques(now_.state(), torques_.data());
  return torques_[index(i)];
}

/// The power of drives and base at the last run(), W.
double CoupledDynamics::couplingPower() {
  if (now_.known != Known::all) return 0;  // neither drives nor base
  double power = 0;
  for (int i = 0; i < n_; ++i) {
    const Coupling<double>& joint = now_.couplings.joints[index(i)];
    if (!joint.isHeld) continue;
    power += (now_.moments[index(i)] + joint.rotor * joint.acceleration) * now_.couplings.held[index(i)].rate;
  }
  if (!base_) return power;
  if (now_.base.rate != 0) power += (now_.moments[0] + torqueIn(0)) * now_.base.rate;
  return power + dot(now_.pinForce, now_.base.velocity);
}

JointAnswer CoupledDynamics::answer(double t, const double* y) {
  // The last stage of a step is often its end.
  if (now_.known != Known::nothing && t == now_.t && areEqual(now_.y.data(), y, n_)) {
    std::copy_n(y, 2 * n_, now_.y.begin());
  }
  run(t, y, Known::moments, now_);
  return {now_.moments.data(), now_.slopes()};
}

// ---- ode::System -----------------------------------------------------------------------------------

void CoupledDynamics::derivative(double t, const double* y, double* dydt) {
  std::copy_n(y + n_, n_, dydt);
  rates(t, y, dydt + n_);
}

void CoupledDynamics::rates(double t, const double* y, double* out) {
  run(t, y, Known::rates, now_);
  std::copy_n(now_.slopes(), n_, out);
  if (works_ == 0) return;
  out[n_] = now_.powers.supplied + couplingPower();
  out[n_ + 1] = now_.powers.dissipated;
}

// ---- Switches and held joints ------------------------------------------------------------------------

void CoupledDynamics::enter(double t) {
  Dynamics::enter(t);
  forget();
}

void CoupledDynamics::enterState(double t, const double* y) {
  forget();
  Dynamics::enterState(t, y);
}

void CoupledDynamics::change(double t, double* y, const ode::Crossing& found) {
  if (effects_.haveUncoupledSwitches()) forget();  // those that couple do so themselves, if they change
  Dynamics::change(t, y, found);
}

void CoupledDynamics::reconsider(double t, double* y) {
  forget();
  if (effects_.haveSwitches()) change(t, y);
}

bool CoupledDynamics::hold(double t, double* y) {
  collect(t, 0, aside_.couplings);
  bool any = false;
  for (int i = 0; i < n_; ++i) {
    if (!aside_.couplings.joints[index(i)].isHeld) continue;
    any = true;
    const GivenMotion& motion = aside_.couplings.held[index(i)];
    y[i] = (i > 0 ? y[i - 1] : 0) + motion.value;
    y[n_ + i] = (i > 0 ? y[n_ + i - 1] : 0) + motion.rate;
  }
  return any;
}

void CoupledDynamics::hold(double t, double* q, double* qd) {
  collect(t, 0, aside_.couplings);
  for (int i = 0; i < n_; ++i) {
    if (!aside_.couplings.joints[index(i)].isHeld) continue;
    q[i] = aside_.couplings.held[index(i)].value;
    qd[i] = aside_.couplings.held[index(i)].rate;
  }
}

// ---- What others read ------------------------------------------------------------------------------

Energy CoupledDynamics::energy(double t, const double* y) const {
  Energy energy = energyOf(mechanism_.chain(), storing_, y, y + n_, baseAt(t));
  for (int i = 0; i < n_; ++i) {
    const double rate = relative(y + n_, i);
    energy.kinetic += 0.5 * rotors_[index(i)] * rate * rate;
  }
  return energy;
}

void CoupledDynamics::accelerations(double t, const double* y, double* alpha) {
  rates(t, y, rates_.data());
  std::copy_n(rates_.begin(), n_, alpha);
}

void CoupledDynamics::linkMotions(double t, const double* y, LinkMotion* motions) {
  run(t, y);
  const Vec2d acceleration = now_.ground + mechanism_.chain().gravity();
  moveLinks({now_.base.pin, now_.base.velocity, acceleration, now_.base.angle, y, now_.e.data(), now_.omega(),
             now_.alpha.data(), effects_.acting() == LoadKind::forces ? now_.F.data() : nullptr},
            motions);
  forgetQuery();
}

void CoupledDynamics::couplingTorques(double t, const double* y, double* tau) {
  run(t, y);
  std::fill_n(tau, n_, 0.0);
  for (Effect* effect : coupling_) effect->addTorques(now_.state(), tau);
  // Rotors are inertia, not torque.
  for (int i = 0; i < n_; ++i) {
    const Coupling<double>& joint = now_.couplings.joints[index(i)];
    if (joint.isHeld) tau[i] += now_.moments[index(i)] + joint.rotor * relative(now_.slopes(), i);
  }
  forgetQuery();
}

void CoupledDynamics::jointTorques(double t, const double* y, double* tau) {
  couplingTorques(t, y, tau);
  for (Effect* effect : effects_.active()) {
    if (!effect->couples()) effect->addTorques(now_.state(), tau);
  }
}

void CoupledDynamics::inverse(double t, const double* y, const double* qdd, double* tau) {
  run(t, y);
  // Without the friction that was found: it follows the motion that is asked for.
  std::fill(torques_.begin(), torques_.end(), 0.0);
  for (Effect* effect : coupling_) effect->addTorques(now_.state(), torques_.data());
  std::vector<Coupling<double>> joints(index(n_));
  for (int i = 0; i < n_; ++i) {
    addJointTorque(-torques_[index(i)], i, now_.N.data());
    joints[index(i)] = {0, true, qdd[i]};
  }
  const Vec2d* F = effects_.acting() == LoadKind::forces ? now_.F.data() : nullptr;
  recursion_.couple(joints.data());
  recursion_.accelerations({now_.e.data(), now_.N.data(), F, now_.ground}, nullptr, now_.omega(),
                           now_.couplings.angle.acceleration, now_.alpha.data(), tau);
  for (int i = 0; i < n_; ++i) {
    const double rate = relative(y + n_, i), way = rate != 0 ? rate : qdd[i];
    const double friction = mechanism_.chain().joints()[index(i)].other("friction");
    tau[i] += rotors_[index(i)] * qdd[i] + friction * ((way > 0) - (way < 0));
  }
  forget();
}

}  // namespace planar_chain
