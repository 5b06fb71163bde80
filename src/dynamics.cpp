#include "planar_chain/dynamics.h"

#include <algorithm>

namespace planar_chain {

namespace {

std::size_t index(int j) {
  return static_cast<std::size_t>(j);
}

std::variant<Articulated<double>, Segments> recursionFor(const Chain& chain) {
  if (Segments::areWorthwhile(chain.size())) return Segments(chain);
  return Articulated<double>(chain);
}

std::variant<Linearized<double>, LinearizedSegments<double>> solverFor(const Chain& chain) {
  if (LinearizedSegments<double>::areWorthwhile(chain.size())) return LinearizedSegments<double>(chain);
  return Linearized<double>(chain);
}

/// Another solver at the same state.
std::variant<Linearized<std::complex<double>>, LinearizedSegments<std::complex<double>>> complexOf(
    const std::variant<Linearized<double>, LinearizedSegments<double>>& solver) {
  if (const auto* segments = std::get_if<LinearizedSegments<double>>(&solver)) {
    return LinearizedSegments<std::complex<double>>(*segments);
  }
  return Linearized<std::complex<double>>(std::get<Linearized<double>>(solver));
}

/// +τ on body i, −τ on the body before.
void addJointTorque(double tau, int i, double* N) {
  N[i] += tau;
  if (i > 0) N[i - 1] -= tau;
}

}  // namespace

Dynamics::Dynamics(const Chain& chain, Loads& loads)
    : chain_(chain),
      loads_(loads),
      n_(chain.size()),
      works_(0),
      springs_(chain),
      stops_(chain),
      recursion_(recursionFor(chain)),
      linearized_(solverFor(chain)) {
  if (springs_.dissipate() || !loads.empty() || stops_.dissipate()) works_ = 2;

  const auto n = index(n_);
  e_.resize(n);
  N_.resize(n);
  alpha_.resize(n);
  omegaAt_.resize(n);
  kAt_.resize(n);
  dAt_.resize(n);
  eAt_.resize(n);
  if (loads.mayPush()) {
    F_.resize(n);
    pinVelocity_.resize(n);
    XF_.resize(n);
  }
  thetaAt_.resize(stops_.empty() ? 0 : n);
  findStiffness();
}

void Dynamics::findStiffness() {
  std::fill(kAt_.begin(), kAt_.end(), 0.0);
  std::fill(dAt_.begin(), dAt_.end(), 0.0);
  springs_.addStiffness(kAt_.data(), dAt_.data());
  stops_.addStiffness(kAt_.data(), dAt_.data());
}

void Dynamics::enterStops(const double* y) {
  stops_.enter(y);
  findStiffness();
}

void Dynamics::changeStops(const double* y) {
  stops_.change(y);
  findStiffness();
}

void Dynamics::findPinVelocities(const Rotation<double>* e, const double* omega) {
  Vec2d v;
  for (int j = 0; j < loads_.reach(); ++j) {
    pinVelocity_[index(j)] = v;
    v += omega[j] * perp(e[j] * chain_.links()[index(j)].pin);
  }
}

Dynamics::Powers Dynamics::gather(double t, const double* theta, const double* omega) {
  rotations(theta, e_.data(), n_);

  // Loads: forces, moments and torques, and what they supply.
  std::fill(N_.begin(), N_.end(), 0.0);
  if (loads_.reach() > 0) std::fill(F_.begin(), F_.end(), Vec2d{});
  findPinVelocities(e_.data(), omega);
  Powers powers{loads_.apply(t, e_.data(), omega, pinVelocity_.data(), N_.data(), F_.data()), 0};

  powers.dissipated += springs_.apply(theta, omega, N_.data());
  powers.dissipated +=
      stops_.apply(theta, omega, [&](int joint, double torque) { addJointTorque(torque, joint, N_.data()); });
  return powers;
}

void Dynamics::accelerations(const Rotation<double>* e, const double* omega, Vec2d ground, double* alpha) {
  std::visit([&](auto& recursion) { recursion.accelerations(e, omega, N_.data(), forces(), ground, alpha); },
             recursion_);
}

void Dynamics::derivative(double t, const double* y, double* dydt) {
  ++evaluations_;
  const double* theta = y;
  const double* omega = y + n_;
  const Powers powers = gather(t, theta, omega);
  std::copy(omega, omega + n_, dydt);
  accelerations(e_.data(), omega, -1.0 * chain_.gravity(), dydt + n_);
  if (works_ > 0) {
    dydt[2 * n_] = powers.supplied;
    dydt[2 * n_ + 1] = powers.dissipated;
  }
}

void Dynamics::linearize(double t, const double* y, double* dydt) {
  derivative(t, y, dydt);
  tAt_ = t;
  std::copy(y, y + static_cast<std::ptrdiff_t>(thetaAt_.size()), thetaAt_.begin());
  std::copy(y + n_, y + 2 * n_, omegaAt_.begin());
  std::copy(e_.begin(), e_.end(), eAt_.begin());
  const bool pushed = loads_.reach() > 0;
  if (pushed) {
    std::fill(XF_.begin(), XF_.end(), 0.0);
    loads_.addStiffness(t, e_.data(), XF_.data());
  }
  std::visit(
      [&](auto& solver) {
        solver.linearize(e_.data(), y + n_, dydt + n_, forces(), pushed ? XF_.data() : nullptr, kAt_.data(),
                         dAt_.data());
      },
      linearized_);
}

bool Dynamics::timeDerivative(double* ft) {
  if (!loads_.varies()) return false;
  // M ∂α/∂t = ∂f/∂t: the recursion without gravity and at rest.
  std::fill(N_.begin(), N_.end(), 0.0);
  if (loads_.reach() > 0) std::fill(F_.begin(), F_.end(), Vec2d{});
  findPinVelocities(eAt_.data(), omegaAt_.data());
  const double power =
      loads_.applyRates(tAt_, eAt_.data(), omegaAt_.data(), pinVelocity_.data(), N_.data(), F_.data());
  std::fill(ft, ft + 2 * n_, 0.0);
  accelerations(eAt_.data(), ft, {}, ft + n_);
  ft[2 * n_] = power;
  ft[2 * n_ + 1] = 0;
  return true;
}

ode::LinearCosts Dynamics::linearCosts() const {
  // By clock, of evaluations as this chain has them; between chains with springs and without.
  if (std::holds_alternative<LinearizedSegments<double>>(linearized_)) return {2.7, 0.8, 3.1, 2.5};
  if (std::holds_alternative<Segments>(recursion_)) return {3, 1, 2, 2.2};
  return {2.2, 0.9, 1.5, 1.9};
}

void Dynamics::factor(double s) {
  s_ = s;
  std::visit([s](auto& solver) { solver.factor(s); }, linearized_);
}

void Dynamics::solve(const double* rhs, double* x) {
  double* u = x;
  double* v = x + n_;
  std::visit([&](auto& solver) { solver.solve(rhs, rhs + n_, u, v); }, linearized_);
  if (works_ == 0) return;

  // s x_W = rhs_W + the change of the powers along (u, v).
  const Powers change = powersAlong(u, v);
  x[2 * n_] = (rhs[2 * n_] + change.supplied) / s_;
  x[2 * n_ + 1] = (rhs[2 * n_ + 1] + change.dissipated) / s_;
}

void Dynamics::reserveComplex(int count) {
  while (complexLinearized_.size() < index(count)) complexLinearized_.push_back(complexOf(linearized_));
  complexS_.resize(complexLinearized_.size());
  part_.resize(index(2 * n_));
}

void Dynamics::factorComplex(int k, std::complex<double> s) {
  complexS_[index(k)] = s;
  std::visit([s](auto& solver) { solver.factor(s); }, complexLinearized_[index(k)]);
}

void Dynamics::solveComplex(int k, const std::complex<double>* rhs, std::complex<double>* x) {
  std::visit([&](auto& solver) { solver.solve(rhs, rhs + n_, x, x + n_); }, complexLinearized_[index(k)]);
  if (works_ == 0) return;

  // The powers change linearly: real and imaginary parts one by one.
  double* u = part_.data();
  double* v = u + n_;
  for (int i = 0; i < 2 * n_; ++i) u[i] = x[i].real();
  const Powers real = powersAlong(u, v);
  for (int i = 0; i < 2 * n_; ++i) u[i] = x[i].imag();
  const Powers imaginary = powersAlong(u, v);
  const std::complex<double> s = complexS_[index(k)];
  x[2 * n_] = (rhs[2 * n_] + std::complex<double>(real.supplied, imaginary.supplied)) / s;
  x[2 * n_ + 1] = (rhs[2 * n_ + 1] + std::complex<double>(real.dissipated, imaginary.dissipated)) / s;
}

Dynamics::Powers Dynamics::powersAlong(const double* u, const double* v) {
  Vec2d change;
  for (int j = 0; j < loads_.reach(); ++j) {
    pinVelocity_[index(j)] = change;
    const Vec2d P = eAt_[index(j)] * chain_.links()[index(j)].pin;
    change += v[j] * perp(P) - (omegaAt_[index(j)] * u[j]) * P;
  }
  Powers powers{loads_.powerAlong(tAt_, eAt_.data(), omegaAt_.data(), u, v, pinVelocity_.data()), 0};
  powers.dissipated += springs_.dissipationAlong(omegaAt_.data(), v);
  powers.dissipated += stops_.dissipationAlong(thetaAt_.data(), omegaAt_.data(), u, v);
  return powers;
}

void Dynamics::linkMotions(double t, const double* y, LinkMotion* motions) {
  const double* theta = y;
  const double* omega = y + n_;
  gather(t, theta, omega);
  accelerations(e_.data(), omega, -1.0 * chain_.gravity(), alpha_.data());

  // Outwards: positions, velocities, accelerations of the pins and of the centres of mass.
  Vec2d x, v, a;
  for (int j = 0; j < n_; ++j) {
    const auto i = index(j);
    const double w = omega[j];
    const Vec2d R = e_[i] * chain_.links()[i].com;
    const Vec2d P = e_[i] * chain_.links()[i].pin;
    LinkMotion& body = motions[j];
    body.innerPin = x;
    body.angle = theta[j];
    body.com = x + R;
    body.velocity = v + w * perp(R);
    body.omega = w;
    body.acceleration = a + alpha_[i] * perp(R) - (w * w) * R;
    body.alpha = alpha_[i];
    x += P;
    v += w * perp(P);
    a += alpha_[i] * perp(P) - (w * w) * P;
  }

  // Inwards: F_pin,j = m (a_j − g) − F_j + F_pin,j+1.
  Vec2d next;
  for (int j = n_ - 1; j >= 0; --j) {
    const auto i = index(j);
    next += chain_.links()[i].mass * (motions[j].acceleration - chain_.gravity());
    if (forces()) next -= F_[i];
    motions[j].pinForce = next;
  }
}

void Dynamics::jointTorques(double t, const double* y, double* tau) {
  std::fill(tau, tau + n_, 0.0);
  loads_.addJointTorques(t, tau);
  springs_.addTorques(y, y + n_, tau);
  stops_.apply(y, y + n_, [&](int joint, double torque) { tau[joint] += torque; });
}

}  // namespace planar_chain
