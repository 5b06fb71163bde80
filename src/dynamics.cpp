#include "planar_chain/dynamics.h"

#include <algorithm>

namespace planar_chain {

namespace {

std::size_t index(int j) {
  return static_cast<std::size_t>(j);
}

std::variant<ShortChain, Articulated<double>, Segments> recursionFor(const Chain& chain) {
  if (Segments::areWorthwhile(chain.size())) return Segments(chain);
  if (chain.size() <= ShortChain::most) return ShortChain(chain);
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
      positions_(std::holds_alternative<ShortChain>(recursion_) ? 0 : n_) {
  if (springs_.dissipate() || !loads.empty() || stops_.dissipate()) works_ = 2;

  const auto n = index(n_);
  e_.resize(index(ShortChain::roomFor(n_)));
  motion_.resize(index(size()));
  if (!springs_.empty() || !loads.empty() || !stops_.empty()) N_.resize(n);
  if (!loads.empty()) {
    F_.resize(n);
    pinVelocity_.resize(n);
  }
  outside_ = {e_.data(), N_.data(), F_.data(), -1.0 * chain.gravity()};
  effects_.reserve(4);
  findLoads();
}

std::string Dynamics::recursion() const {
  return std::visit([](const auto& recursion) { return recursion.name(); }, recursion_);
}

void Dynamics::enter(double t) {
  loads_.enter(t);
  findLoads();
}

void Dynamics::findLoads() {
  loadsAct_ = loads_.acting();
  varies_ = loads_.varies();
  listEffects();
}

void Dynamics::enterStops(const double* y) {
  stops_.enter(y);
  changedStops();
}

void Dynamics::changeStops(const double* y) {
  stops_.change(y);
  changedStops();
}

void Dynamics::changedStops() {
  listEffects();
  findStiffness();
}

void Dynamics::listEffects() {
  effects_.clear();
  effects_.push_back(&Dynamics::clearMoments);
  if (loadsAct_ == Acting::forces) effects_.push_back(&Dynamics::applyForces);
  if (loadsAct_ == Acting::moments) effects_.push_back(&Dynamics::applyTorques);
  if (!springs_.empty()) effects_.push_back(&Dynamics::applySprings);
  if (stops_.act()) effects_.push_back(&Dynamics::applyStops);
  if (effects_.size() == 1) effects_.clear();
  isBare_ = effects_.empty() && works_ == 0;
  acting_ = effects_.empty() ? Acting::nothing : std::max(loadsAct_, Acting::moments);
}

Dynamics::Powers Dynamics::clearMoments(double /*t*/, const double* /*theta*/, const double* /*omega*/) {
  std::fill(N_.begin(), N_.end(), 0.0);
  return {};
}

Dynamics::Powers Dynamics::applyForces(double t, const double* theta, const double* omega) {
  rotations(theta, e_.data(), n_);
  std::fill(F_.begin(), F_.end(), Vec2d{});
  findPinVelocities(e_.data(), omega);
  return {loads_.apply(t, e_.data(), omega, pinVelocity_.data(), N_.data(), F_.data()), 0};
}

Dynamics::Powers Dynamics::applyTorques(double t, const double* /*theta*/, const double* omega) {
  return {loads_.apply(t, nullptr, omega, nullptr, N_.data(), nullptr), 0};
}

Dynamics::Powers Dynamics::applySprings(double /*t*/, const double* theta, const double* omega) {
  return {0, springs_.apply(theta, omega, N_.data())};
}

Dynamics::Powers Dynamics::applyStops(double /*t*/, const double* theta, const double* omega) {
  return {0, stops_.apply(theta, omega,
                          [&](int joint, double torque) { addJointTorque(torque, joint, N_.data()); })};
}

void Dynamics::findPinVelocities(const Rotation<double>* e, const double* omega) {
  Vec2d v;
  for (int j = 0; j < loads_.reach(); ++j) {
    pinVelocity_[index(j)] = v;
    v += omega[j] * perp(e[j] * chain_.links()[index(j)].pin);
  }
}

inline void Dynamics::run(Acting acting, const Outside& outside, const double* y, double* rates) {
  if (auto* chain = std::get_if<ShortChain>(&recursion_)) return chain->derivative(acting, outside, y, rates);

  if (acting != Acting::forces) rotations(y, outside.e, n_);
  const double* omega = y + n_;
  const double* N = acting == Acting::nothing ? nullptr : outside.N;
  const Vec2d* F = acting == Acting::forces ? outside.F : nullptr;
  if (auto* segments = std::get_if<Segments>(&recursion_)) {
    segments->accelerations(outside.e, omega, N, F, outside.ground, rates);
  } else {
    std::get_if<Articulated<double>>(&recursion_)
        ->accelerations(outside.e, omega, N, F, outside.ground, rates);
  }
}

inline Dynamics::Powers Dynamics::applyEffects(double t, const double* y) {
  Powers powers;
  for (const Effect effect : effects_) {
    const Powers own = (this->*effect)(t, y, y + n_);
    powers.supplied += own.supplied;
    powers.dissipated += own.dissipated;
  }
  return powers;
}

inline void Dynamics::evaluateRates(double t, const double* y, double* out) {
  if (isBare_) return run(Acting::nothing, outside_, y, out);
  evaluateEffects(t, y, out);
}

[[gnu::noinline]] void Dynamics::evaluateEffects(double t, const double* y, double* out) {
  const Powers powers = applyEffects(t, y);
  run(acting_, outside_, y, out);
  if (works_ > 0) {
    double* works = out + 2 * n_ - positions_;
    works[0] = powers.supplied;
    works[1] = powers.dissipated;
  }
}

void Dynamics::evaluate(double t, const double* y, double* dydt) {
  std::copy(y + n_, y + n_ + positions_, dydt);
  evaluateRates(t, y, dydt + positions_);
}

void Dynamics::rates(double t, const double* y, double* out) {
  ++evaluations_;
  evaluateRates(t, y, out);
}

void Dynamics::derivative(double t, const double* y, double* dydt) {
  ++evaluations_;
  evaluate(t, y, dydt);
}

void Dynamics::linearize(double t, const double* y, double* dydt) {
  derivative(t, y, dydt);
  tAt_ = t;
  std::copy(y, y + static_cast<std::ptrdiff_t>(thetaAt_.size()), thetaAt_.begin());
  std::copy(y + n_, y + 2 * n_, omegaAt_.begin());
  std::copy(e_.begin(), e_.begin() + static_cast<std::ptrdiff_t>(eAt_.size()), eAt_.begin());
  const bool pushed = loads_.reach() > 0;
  if (pushed) {
    std::fill(XF_.begin(), XF_.end(), 0.0);
    loads_.addStiffness(t, e_.data(), XF_.data());
  }
  std::visit(
      [&](auto& solver) {
        solver.linearize(e_.data(), y + n_, dydt + n_, forces(), pushed ? XF_.data() : nullptr);
      },
      *linearized_);
}

bool Dynamics::timeDerivative(double* ft) {
  if (!varies_) return false;
  // M ∂α/∂t = ∂f/∂t: the recursion without gravity and at rest.
  std::fill(N_.begin(), N_.end(), 0.0);
  std::fill(F_.begin(), F_.end(), Vec2d{});
  findPinVelocities(eAt_.data(), omegaAt_.data());
  const double power =
      loads_.applyRates(tAt_, eAt_.data(), omegaAt_.data(), pinVelocity_.data(), N_.data(), F_.data());
  std::copy(eAt_.begin(), eAt_.end(), e_.begin());
  std::fill(motion_.begin(), motion_.end(), 0.0);
  std::fill(ft, ft + n_, 0.0);
  run(Acting::forces, {e_.data(), N_.data(), F_.data(), {}}, motion_.data(), ft + positions_);
  ft[2 * n_] = power;
  ft[2 * n_ + 1] = 0;
  return true;
}

ode::LinearCosts Dynamics::linearCosts() const {
  // By clock, of evaluations as this chain has them; between chains with springs and without. Where the
  // factorizations do not stay in cache, complex solves wait for memory.
  constexpr int staysInCache = 2500;
  if (n_ > staysInCache && LinearizedSegments<double>::areWorthwhile(n_)) return {3, 1.3, 3.4, 3.4};
  if (LinearizedSegments<double>::areWorthwhile(n_)) return {2.4, 0.95, 3, 2.5};
  if (std::holds_alternative<Segments>(recursion_)) return {3.5, 1.2, 4, 2.7};
  return {2.9, 1, 3.2, 2.8};
}

void Dynamics::factor(double s) {
  s_ = s;
  std::visit([s](auto& solver) { solver.factor(s); }, *linearized_);
}

void Dynamics::solve(const double* rhs, double* x) {
  double* u = x;
  double* v = x + n_;
  std::visit([&](auto& solver) { solver.solve(rhs, rhs + n_, u, v); }, *linearized_);
  if (works_ == 0) return;

  // s x_W = rhs_W + the change of the powers along (u, v).
  const Powers change = powersAlong(u, v);
  x[2 * n_] = (rhs[2 * n_] + change.supplied) / s_;
  x[2 * n_ + 1] = (rhs[2 * n_ + 1] + change.dissipated) / s_;
}

void Dynamics::reserve(int complexCount) {
  if (!linearized_) {
    linearized_.emplace(solverFor(chain_));
    const auto n = index(n_);
    thetaAt_.resize(stops_.empty() ? 0 : n);
    omegaAt_.resize(n);
    if (!loads_.empty()) {
      eAt_.resize(n);
      XF_.resize(n);
    }
    findStiffness();
  }
  while (complexLinearized_.size() < index(complexCount))
    complexLinearized_.push_back(complexOf(*linearized_));
  complexS_.resize(complexLinearized_.size());
  part_.resize(complexLinearized_.empty() ? 0 : index(2 * n_));
}

void Dynamics::findStiffness() {
  if (!linearized_ && !series_) return;
  kAt_.resize(index(n_));
  dAt_.resize(index(n_));
  std::fill(kAt_.begin(), kAt_.end(), 0.0);
  std::fill(dAt_.begin(), dAt_.end(), 0.0);
  springs_.addStiffness(kAt_.data(), dAt_.data());
  stops_.addStiffness(kAt_.data(), dAt_.data());
  if (linearized_) {
    std::visit([&](auto& solver) { solver.setJoints(kAt_.data(), dAt_.data()); }, *linearized_);
  }
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

// ---- Taylor series ---------------------------------------------------------------------------------

void Dynamics::reserveSeries(int order) {
  if (series_ && series_->orders() >= order) return;
  series_.emplace(chain_, order);
  loads_.reserveSeries(order);
  findStiffness();
}

void Dynamics::series(double t, const double* y, int order, double* c) {
  evaluations_ += order;
  tAt_ = t;
  std::copy(y, y + 2 * n_, c);
  applyEffects(t, y);
  const bool acts = !effects_.empty();
  series_->find(order, {nullptr, acts ? N_.data() : nullptr, forces(), outside_.ground},
                acts ? this : nullptr, c);
}

void Dynamics::findOrder(int k, const double* theta, const double* omega) {
  std::fill(N_.begin(), N_.end(), 0.0);
  for (int i = 0; i < n_; ++i) {
    const double torque = -kAt_[index(i)] * relative(theta, i) - dAt_[index(i)] * relative(omega, i);
    addJointTorque(torque, i, N_.data());
  }
  if (loadsAct_ == Acting::nothing) return;
  std::fill(F_.begin(), F_.end(), Vec2d{});
  loads_.applyCoefficients(k, tAt_, series_->rotations(), series_->rotationsPerOrder(), N_.data(), F_.data());
}

void Dynamics::integrands(double t, const double* y, double* rates) {
  const Powers powers = applyEffects(t, y);
  rates[0] = powers.supplied;
  rates[1] = powers.dissipated;
}

double Dynamics::seriesCost(int order) const {
  return series_->cost(order);
}

void Dynamics::linkMotions(double t, const double* y, LinkMotion* motions) {
  evaluate(t, y, motion_.data());
  const double* theta = y;
  const double* omega = y + n_;
  const double* alpha = motion_.data() + n_;

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
    body.acceleration = a + alpha[j] * perp(R) - (w * w) * R;
    body.alpha = alpha[j];
    x += P;
    v += w * perp(P);
    a += alpha[j] * perp(P) - (w * w) * P;
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
