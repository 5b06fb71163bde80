#include "dynamics/coupled_dynamics.h"

#include <algorithm>

namespace planar_chain {

bool isCoupled(const Scene& scene) {
  const auto& joints = scene.chain.joints();
  return scene.base || !scene.drives.empty() ||
         std::any_of(joints.begin(), joints.end(), [](const Joint& joint) {
           return joint.other("rotor_inertia") > 0 || joint.other("friction") > 0;
         });
}

std::unique_ptr<Dynamics> makeDynamics(const Scene& scene, std::unique_ptr<Effect> more) {
  if (isCoupled(scene)) return std::make_unique<CoupledDynamics>(scene, std::move(more));
  return std::make_unique<Dynamics>(scene, std::move(more));
}

CoupledDynamics::CoupledDynamics(const Scene& scene, std::unique_ptr<Effect> more)
    : Dynamics(scene, std::move(more), true),
      base_(scene.base),
      recursion_(scene.chain),
      bodies_(scene.chain),
      solver_{CoupledLinearized<double>(bodies_)} {
  const auto n = index(n_);
  couplings_.joints.resize(n);
  couplings_.held.resize(n);
  for (auto* numbers : {&omega_, &N_, &alpha_, &moments_, &torques_, &relative_}) numbers->resize(n);
  e_.resize(n);
  F_.resize(n);
  pinVelocity_.resize(n);
  state_.resize(2 * n);
  rates_.resize(index(size()));
  for (const auto& effect : effects_.all()) {
    if (!effect->couples()) continue;
    coupling_.push_back(effect.get());
    effect->attach(*this);
  }
  for (const Joint& joint : scene.chain.joints()) {
    double inertia = 0;
    for (const EffectKind* kind : effectKinds()) inertia += kind->inertiaIn(joint);
    rotors_.push_back(inertia);
  }
}

// ---- The recursion ---------------------------------------------------------------------------------

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
void CoupledDynamics::collect(double t, int order) {
  std::fill(couplings_.joints.begin(), couplings_.joints.end(), Coupling<double>{});
  for (const Effect* effect : coupling_) effect->couple(t, order, couplings_);
}

Powers CoupledDynamics::run(double t, const double* y) {
  ++evaluations_;
  collect(t);
  const auto& [joints, held, x, yBase, angle] = couplings_;
  baseNow_ = {{x.value, yBase.value}, {x.rate, yBase.rate}, angle.value, angle.rate};
  ground_ = Vec2d{x.acceleration, yBase.acceleration} - mechanism_.chain().gravity();

  // Rotations and rates against the ground.
  mechanism_.rotate(y, e_.data(), n_);
  std::copy_n(y + n_, n_, omega_.begin());
  if (base_) {
    const Rotation<double> turn = plainRotation(baseNow_.angle);
    for (Rotation<double>& e : e_) e = {turn.c * e.c - turn.s * e.s, turn.s * e.c + turn.c * e.s};
    for (double& omega : omega_) omega += baseNow_.rate;
  }

  // Moments and forces of the effects.
  std::fill(N_.begin(), N_.end(), 0.0);
  at_ = {t, y, y + n_, e_.data(), pinVelocity_.data(), baseNow_.rate};
  const bool hasForces = effects_.acting() == LoadKind::forces;
  if (hasForces) {
    std::fill(F_.begin(), F_.end(), Vec2d{});
    mechanism_.findPinVelocities(e_.data(), omega_.data(), effects_.reach(), pinVelocity_.data());
    for (int j = 0; j < effects_.reach(); ++j) pinVelocity_[index(j)] += baseNow_.velocity;
  }
  Powers powers;
  for (Effect* effect : effects_.active()) powers += effect->apply(at_, {N_.data(), F_.data()});

  pinForce_ =
      recursion_.accelerations(e_.data(), omega_.data(), N_.data(), hasForces ? F_.data() : nullptr,
                               joints.data(), ground_, angle.acceleration, alpha_.data(), moments_.data());
  return powers;
}

/// The torque of the effects in joint i, N m.
double CoupledDynamics::torqueIn(int i) {
  std::fill(torques_.begin(), torques_.end(), 0.0);
  for (Effect* effect : effects_.active()) effect->addTorques(at_, torques_.data());
  return torques_[index(i)];
}

/// The power of drives and base at the last run(), W.
double CoupledDynamics::couplingPower() {
  double power = 0;
  for (int i = 0; i < n_; ++i) {
    const Coupling<double>& joint = couplings_.joints[index(i)];
    if (!joint.isHeld) continue;
    power += (moments_[index(i)] + joint.rotor * joint.acceleration) * couplings_.held[index(i)].rate;
  }
  if (!base_) return power;
  if (baseNow_.rate != 0) power += (moments_[0] + torqueIn(0)) * baseNow_.rate;
  return power + dot(pinForce_, baseNow_.velocity);
}

JointAnswer CoupledDynamics::answer(double t, const double* y) {
  run(t, y);
  toRelative(alpha_.data(), n_, relative_.data());
  relative_[0] -= couplings_.angle.acceleration;
  return {moments_.data(), relative_.data()};
}

// ---- ode::System -----------------------------------------------------------------------------------

void CoupledDynamics::derivative(double t, const double* y, double* dydt) {
  std::copy_n(y + n_, n_, dydt);
  rates(t, y, dydt + n_);
}

void CoupledDynamics::rates(double t, const double* y, double* out) {
  const Powers powers = run(t, y);
  for (int i = 0; i < n_; ++i) out[i] = alpha_[index(i)] - couplings_.angle.acceleration;
  if (works_ == 0) return;
  out[n_] = powers.supplied + couplingPower();
  out[n_ + 1] = powers.dissipated;
}

// ---- Switches and held joints ------------------------------------------------------------------------

void CoupledDynamics::reconsider(double t, const double* y) {
  if (effects_.haveSwitches()) change(t, y);
}

bool CoupledDynamics::hold(double t, double* y) {
  collect(t);
  bool any = false;
  for (int i = 0; i < n_; ++i) {
    if (!couplings_.joints[index(i)].isHeld) continue;
    any = true;
    const GivenMotion& motion = couplings_.held[index(i)];
    y[i] = (i > 0 ? y[i - 1] : 0) + motion.value;
    y[n_ + i] = (i > 0 ? y[n_ + i - 1] : 0) + motion.rate;
  }
  return any;
}

void CoupledDynamics::hold(double t, double* q, double* qd) {
  collect(t);
  for (int i = 0; i < n_; ++i) {
    if (!couplings_.joints[index(i)].isHeld) continue;
    q[i] = couplings_.held[index(i)].value;
    qd[i] = couplings_.held[index(i)].rate;
  }
}

// ---- ode::LinearizedSystem ---------------------------------------------------------------------------

void CoupledDynamics::reserve(int complexCount) {
  const auto n = index(n_);
  for (auto* numbers : {&alphaThen_, &tangentK_, &tangentD_, &XF_}) numbers->resize(n);
  eThen_.resize(n);
  omegaThen_.resize(n);
  FThen_.resize(n);
  pinVelocityAlong_.resize(n);
  part_.resize(2 * n);
  while (complexSolvers_.size() < index(complexCount)) {
    complexSolvers_.push_back({CoupledLinearized<std::complex<double>>(bodies_)});
  }
}

void CoupledDynamics::linearize(double t, const double* y, double* dydt) {
  derivative(t, y, dydt);
  // Keep the state, which later calls need.
  std::copy_n(y, 2 * n_, state_.begin());
  eThen_ = e_;
  omegaThen_ = omega_;
  alphaThen_ = alpha_;
  FThen_ = F_;
  heldThen_ = couplings_;
  baseThen_ = baseNow_;
  then_ = {t, state_.data(), state_.data() + n_, eThen_.data(), pinVelocityAlong_.data(), baseNow_.rate};

  // What the effects add to J.
  sumStiffness();
  tangentK_ = k_;
  tangentD_ = d_;
  const bool hasForces = effects_.acting() == LoadKind::forces;
  std::fill(XF_.begin(), XF_.end(), 0.0);
  for (Effect* effect : effects_.active()) {
    effect->addTangents(then_, tangentK_.data(), tangentD_.data());
    if (hasForces) effect->addForceStiffness(then_, XF_.data());
  }
  bodies_.take(linearized());
}

CoupledState CoupledDynamics::linearized() const {
  const bool hasForces = effects_.acting() == LoadKind::forces;
  return {eThen_.data(), omegaThen_.data(), alphaThen_.data(), hasForces ? FThen_.data() : nullptr,
          XF_.data(),    tangentK_.data(),  tangentD_.data(),  heldThen_.joints.data(),
          ground_};
}

bool CoupledDynamics::timeDerivative(double* ft) {
  if (!effects_.varyWithTime()) return false;
  // A difference of fourth order, of steps that change what varies with time by about 0.003: its error is
  // below 1e-11 of ∂f/∂t.
  const double h = std::min(2e-3 * effects_.longestStep(), 1e-4);
  std::fill_n(ft, size(), 0.0);
  for (const auto& [steps, weight] :
       {std::pair{-2, 1.0 / 12}, std::pair{-1, -8.0 / 12}, std::pair{1, 8.0 / 12}, std::pair{2, -1.0 / 12}}) {
    rates(then_.t + steps * h, state_.data(), rates_.data());
    for (int i = 0; i < n_ + works_; ++i) ft[n_ + i] += weight / h * rates_[index(i)];
  }
  return true;
}

template <class Scalar>
void CoupledDynamics::solveWith(Solver<Scalar>& solver, const Scalar* rhs, Scalar* x) {
  solver.of.solve(rhs, rhs + n_, x, x + n_);
  if (works_ == 0) return;
  // The powers of drives and base, then of the effects.
  Scalar supplied{}, dissipated{};
  for (int i = 0; i < n_; ++i) {
    if (!heldThen_.joints[index(i)].isHeld) continue;
    supplied += heldThen_.held[index(i)].rate * solver.of.moments()[index(i)];
  }
  if (base_) {
    const Vec2<Scalar> change = solver.of.pinForce();
    supplied += baseThen_.rate * solver.of.moments()[0] + baseThen_.velocity.x * change.x +
                baseThen_.velocity.y * change.y;
  }
  if constexpr (std::is_same_v<Scalar, double>) {
    const Powers change = powersAlong(x);
    supplied += change.supplied;
    dissipated += change.dissipated;
  } else {
    const auto along = [&](auto part) {
      for (int i = 0; i < 2 * n_; ++i) part_[index(i)] = part(x[i]);
      return powersAlong(part_.data());
    };
    const Powers real = along([](Scalar z) { return z.real(); });
    const Powers imaginary = along([](Scalar z) { return z.imag(); });
    supplied += Scalar(real.supplied, imaginary.supplied);
    dissipated += Scalar(real.dissipated, imaginary.dissipated);
  }
  x[2 * n_] = (rhs[2 * n_] + supplied) / solver.s;
  x[2 * n_ + 1] = (rhs[2 * n_ + 1] + dissipated) / solver.s;
}

/// How the powers of the effects change along x = [u v].
Powers CoupledDynamics::powersAlong(const double* x) {
  Powers powers;
  Vec2d change;
  for (int j = 0; j < effects_.reach(); ++j) {
    pinVelocityAlong_[index(j)] = change;
    const Vec2d P = eThen_[index(j)] * mechanism_.chain().links()[index(j)].pin;
    change += x[n_ + j] * perp(P) - (omegaThen_[index(j)] * x[j]) * P;
  }
  for (Effect* effect : effects_.active()) {
    powers += effect->worksInLanes() ? effect->powersAlongInLanes(then_.omega, x + n_)
                                     : effect->powersAlong(then_, {x, x + n_, pinVelocityAlong_.data()});
  }
  return powers;
}

// ---- Taylor series ---------------------------------------------------------------------------------

void CoupledDynamics::reserveSeries(int order) {
  if (series_ && series_->orders() >= order) return;
  series_.emplace(mechanism_.chain(), order);
  for (const auto& effect : effects_.all()) effect->reserveSeries(order);
}

void CoupledDynamics::series(double t, const double* y, int order, double* c) {
  sumStiffness();
  run(t, y);
  std::copy_n(y, 2 * n_, c);
  const bool hasForces = effects_.acting() == LoadKind::forces;
  const Vec2d* F = hasForces ? F_.data() : nullptr;
  series_->begin(e_.data(), omega_.data(), alpha_.data(), ground_, F);
  const Series known{t, n_, c, series_->rotations(), n_};
  for (int k = 0; k < order; ++k) {
    double *row = c + std::ptrdiff_t{2} * n_ * k, *next = row + std::ptrdiff_t{2} * n_;
    if (k > 0) {
      collect(t, k);
      const auto& [joints, held, x, yBase, angle] = couplings_;
      for (int i = 0; i < n_; ++i) omega_[index(i)] = row[n_ + i] + angle.rate;
      findOrder(k, known, {N_.data(), F_.data()});
      series_->find(k, omega_.data(), N_.data(), F, joints.data(), {x.acceleration, yBase.acceleration},
                    angle.acceleration, alpha_.data());
    }
    for (int i = 0; i < n_; ++i) {
      next[i] = row[n_ + i] / (k + 1);
      next[n_ + i] = (alpha_[index(i)] - couplings_.angle.acceleration) / (k + 1);
    }
  }
}

void CoupledDynamics::integrands(double t, const double* y, double* rates) {
  const Powers powers = run(t, y);
  rates[0] = powers.supplied + couplingPower();
  rates[1] = powers.dissipated;
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
  const Vec2d acceleration = ground_ + mechanism_.chain().gravity();
  moveLinks({baseNow_.pin, baseNow_.velocity, acceleration, baseNow_.angle, y, e_.data(), omega_.data(),
             alpha_.data(), effects_.acting() == LoadKind::forces ? F_.data() : nullptr},
            motions);
}

void CoupledDynamics::couplingTorques(double t, const double* y, double* tau) {
  answer(t, y);
  std::fill_n(tau, n_, 0.0);
  for (Effect* effect : coupling_) effect->addTorques(at_, tau);
  // Rotors are inertia, not torque.
  for (int i = 0; i < n_; ++i) {
    const Coupling<double>& joint = couplings_.joints[index(i)];
    if (joint.isHeld) tau[i] += moments_[index(i)] + joint.rotor * relative_[index(i)];
  }
}

void CoupledDynamics::jointTorques(double t, const double* y, double* tau) {
  couplingTorques(t, y, tau);
  for (Effect* effect : effects_.active()) {
    if (!effect->couples()) effect->addTorques(at_, tau);
  }
}

void CoupledDynamics::inverse(double t, const double* y, const double* qdd, double* tau) {
  run(t, y);
  // Without the friction that was found: it follows the motion that is asked for.
  std::fill(torques_.begin(), torques_.end(), 0.0);
  for (Effect* effect : coupling_) effect->addTorques(at_, torques_.data());
  std::vector<Coupling<double>> joints(index(n_));
  for (int i = 0; i < n_; ++i) {
    addJointTorque(-torques_[index(i)], i, N_.data());
    joints[index(i)] = {0, true, qdd[i]};
  }
  const Vec2d* F = effects_.acting() == LoadKind::forces ? F_.data() : nullptr;
  recursion_.accelerations(e_.data(), omega_.data(), N_.data(), F, joints.data(), ground_,
                           couplings_.angle.acceleration, alpha_.data(), tau);
  for (int i = 0; i < n_; ++i) {
    const double rate = relative(y + n_, i), way = rate != 0 ? rate : qdd[i];
    const double friction = mechanism_.chain().joints()[index(i)].other("friction");
    tau[i] += rotors_[index(i)] * qdd[i] + friction * ((way > 0) - (way < 0));
  }
}

}  // namespace planar_chain
