#include "dynamics/dynamics.h"

#include <algorithm>

#include "lanes/kernel.h"

namespace planar_chain {

namespace {

std::variant<ShortChain, Articulated<double>, Segments> recursionFor(const Chain& chain) {
  if (Segments::areWorthwhile(chain.size())) return Segments(chain);
  if (chain.size() <= ShortChain::most) return ShortChain(chain);
  return Articulated<double>(chain);
}

std::variant<Linearized<double>, LinearizedSegments<double>> solverFor(const Chain& chain, bool inSegments) {
  if (inSegments) return LinearizedSegments<double>(chain);
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

std::optional<Arrangement> arrangementOf(
    const std::variant<ShortChain, Articulated<double>, Segments>& recursion) {
  if (const auto* segments = std::get_if<Segments>(&recursion)) return segments->arrangement();
  return std::nullopt;
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
      stops_(chain),
      recursion_(recursionFor(chain)),
      arrangement_(arrangementOf(recursion_)),
      springs_(chain),
      arrangedSprings_(chain, arrangement_ ? &*arrangement_ : nullptr),
      places_(arrangement_ ? arrangement_->places() : n_),
      positions_(std::holds_alternative<ShortChain>(recursion_) ? 0 : places_) {
  if (springs_.dissipate() || !loads.empty() || stops_.dissipate()) works_ = 2;

  const auto n = index(n_);
  const bool acts = !springs_.empty() || !loads.empty() || !stops_.empty();
  e_.resize(index(ShortChain::roomFor(n_)));
  motion_.resize(index(size()));
  if (acts) N_.resize(n);
  if (!loads.empty()) {
    F_.resize(n);
    pinVelocity_.resize(n);
  }
  outside_ = {e_.data(), N_.data(), F_.data(), -1.0 * chain.gravity()};
  if (arrangement_) {
    const auto places = index(places_);
    arrangedE_ = AlignedArray<Rotation<double>>(places);
    arrangedF_ = AlignedArray<Vec2d>(loads.empty() ? 0 : places);
    arrangedN_ = CacheLines(acts ? places : 0);
    arrangedY_ = CacheLines(index(arrangedSize()));
    arrangedRates_ = CacheLines(index(places_ + works_));
    inOrder_.resize(2 * n);
    outside_ = {arrangedE_.data(), arrangedN_.data(), arrangedF_.data(), outside_.ground};
  }
  effects_.reserve(4);
  effectsInOrder_.reserve(4);
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
  effectsInOrder_.clear();
  if (loadsAct_ == Acting::forces) effectsInOrder_.push_back(&Dynamics::applyForces);
  if (loadsAct_ == Acting::moments) effectsInOrder_.push_back(&Dynamics::applyTorques);
  if (stops_.act()) effectsInOrder_.push_back(&Dynamics::applyStops);

  effects_.clear();
  if (!arrangement_) {
    effects_ = effectsInOrder_;
    if (!springs_.empty()) effects_.push_back(&Dynamics::applySprings);
    if (!effects_.empty()) effects_.insert(effects_.begin(), &Dynamics::clearMoments);
  } else {
    if (!effectsInOrder_.empty()) {
      effects_.push_back(&Dynamics::applyInOrder);
    } else if (!springs_.empty()) {
      effects_.push_back(&Dynamics::clearArrangedMoments);
    }
    if (!springs_.empty()) effects_.push_back(&Dynamics::applyArrangedSprings);
  }
  isBare_ = effects_.empty() && works_ == 0;
  acting_ = effects_.empty() ? Acting::nothing : std::max(loadsAct_, Acting::moments);
}

Dynamics::Powers Dynamics::clearMoments(double /*t*/, const double* /*theta*/, const double* /*omega*/) {
  std::fill(N_.begin(), N_.end(), 0.0);
  return {};
}

Dynamics::Powers Dynamics::clearArrangedMoments(double /*t*/, const double* /*theta*/,
                                                const double* /*omega*/) {
  std::fill_n(arrangedN_.data(), places_, 0.0);
  return {};
}

Dynamics::Powers Dynamics::applyInOrder(double t, const double* y, const double* /*omega*/) {
  const double* ordered = inOrder(y);
  clearMoments(t, ordered, ordered + n_);
  const Powers powers = applyEffects(effectsInOrder_, t, ordered, ordered + n_);
  arrangeLoads(acting_);
  return powers;
}

Dynamics::Powers Dynamics::applyArrangedSprings(double /*t*/, const double* theta, const double* omega) {
  return {0, arrangedSprings_.apply(theta, omega, arrangedN_.data())};
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

void Dynamics::arrange(const double* y, double* arranged) const {
  if (!arrangement_) return System::arrange(y, arranged);
  arrangement_->arrange(y, arranged);
  arrangement_->arrange(y + n_, arranged + places_);
  std::copy_n(y + 2 * n_, works_, arranged + 2 * places_);
}

void Dynamics::restore(const double* arranged, double* y) const {
  if (!arrangement_) return System::restore(arranged, y);
  arrangement_->restore(arranged, y);
  arrangement_->restore(arranged + places_, y + n_);
  std::copy_n(arranged + 2 * places_, works_, y + 2 * n_);
}

const double* Dynamics::inOrder(const double* y) {
  if (!arrangement_) return y;
  arrangement_->restore(y, inOrder_.data());
  arrangement_->restore(y + places_, inOrder_.data() + n_);
  return inOrder_.data();
}

const double* Dynamics::arranged(const double* values, double* room) const {
  if (!arrangement_) return values;
  arrangement_->arrange(values, room);
  return room;
}

void Dynamics::arrangeLoads(Acting acting) {
  if (!arrangement_ || acting == Acting::nothing) return;
  arrangement_->arrange(N_.data(), arrangedN_.data());
  if (acting == Acting::forces) arrangement_->arrange(F_.data(), arrangedF_.data());
}

[[gnu::always_inline]] inline void Dynamics::run(Acting acting, const Outside& outside, const double* y,
                                                 double* rates, const simd::NystromSums* ahead) {
  if (auto* chain = std::get_if<ShortChain>(&recursion_)) return chain->derivative(acting, outside, y, rates);

  const double* omega = y + places_;
  const double* N = acting == Acting::nothing ? nullptr : outside.N;
  const Vec2d* F = acting == Acting::forces ? outside.F : nullptr;
  if (auto* segments = std::get_if<Segments>(&recursion_)) {
    rotations(y, outside.e, places_);
    segments->accelerations(outside.e, omega, N, F, outside.ground, rates, ahead);
  } else {
    if (acting != Acting::forces) rotations(y, outside.e, n_);
    std::get_if<Articulated<double>>(&recursion_)
        ->accelerations(outside.e, omega, N, F, outside.ground, rates);
  }
}

inline Dynamics::Powers Dynamics::applyEffects(const std::vector<Effect>& effects, double t,
                                               const double* theta, const double* omega) {
  Powers powers;
  for (const Effect effect : effects) {
    const Powers own = (this->*effect)(t, theta, omega);
    powers.supplied += own.supplied;
    powers.dissipated += own.dissipated;
  }
  return powers;
}

inline void Dynamics::evaluateRates(double t, const double* y, double* out, const simd::NystromSums* ahead) {
  if (isBare_) return run(Acting::nothing, outside_, y, out, ahead);
  evaluateEffects(t, y, out, ahead);
}

[[gnu::noinline]] void Dynamics::evaluateEffects(double t, const double* y, double* out,
                                                 const simd::NystromSums* ahead) {
  const Powers powers = applyEffects(effects_, t, y, y + places_);
  run(acting_, outside_, y, out, ahead);
  if (works_ > 0) {
    double* works = out + 2 * places_ - positions_;
    works[0] = powers.supplied;
    works[1] = powers.dissipated;
  }
}

void Dynamics::evaluate(double t, const double* y, double* dydt) {
  std::copy_n(y + places_, positions_, dydt);
  evaluateRates(t, y, dydt + positions_);
}

void Dynamics::rates(double t, const double* y, double* out) {
  ++evaluations_;
  evaluateRates(t, y, out);
}

void Dynamics::ratesAndRow(double t, const double* y, double* out, const ode::RowAhead& ahead) {
  if (!arrangement_) return System::ratesAndRow(t, y, out, ahead);
  ++evaluations_;
  const simd::NystromSums sums = ahead.row.sums(ahead.h, ahead.base, ahead.sum, ahead.out);
  evaluateRates(t, y, out, &sums);
  ahead.row.runOthers(ahead.h, ahead.base, ahead.sum, ahead.out);
}

void Dynamics::derivative(double t, const double* y, double* dydt) {
  ++evaluations_;
  evaluateInOrder(t, y, dydt);
}

void Dynamics::evaluateInOrder(double t, const double* y, double* dydt) {
  if (!arrangement_) return evaluate(t, y, dydt);
  arrange(y, arrangedY_.data());
  double* rates = arrangedRates_.data();
  evaluateRates(t, arrangedY_.data(), rates);
  std::copy_n(y + n_, n_, dydt);
  arrangement_->restore(rates, dydt + n_);
  std::copy_n(rates + places_, works_, dydt + 2 * n_);
}

void Dynamics::linearize(double t, const double* y, double* dydt) {
  ++evaluations_;
  evaluate(t, y, dydt);
  tAt_ = t;
  if (works_ > 0) keep(y);
  const bool pushed = !eAt_.empty() && loads_.reach() > 0;
  const Vec2d* F = pushed ? outside_.F : nullptr;
  const double* XF = nullptr;
  if (pushed) {
    std::fill(XF_.begin(), XF_.end(), 0.0);
    loads_.addStiffness(t, eAt_.data(), XF_.data());
    XF = arranged(XF_.data(), arrangedY_.data());
  }
  std::visit([&](auto& solver) { solver.linearize(outside_.e, y + places_, dydt + places_, F, XF); },
             *linearized_);
}

void Dynamics::keep(const double* y) {
  std::copy_n(y + places_, arrangedOmegaAt_.size(), arrangedOmegaAt_.begin());
  if (omegaAt_.empty()) return;
  const double* ordered = inOrder(y);
  std::copy_n(ordered, n_, thetaAt_.begin());
  std::copy_n(ordered + n_, n_, omegaAt_.begin());
  if (!eAt_.empty()) rotations(ordered, eAt_.data(), n_);
}

bool Dynamics::timeDerivative(double* ft) {
  if (!varies_) return false;
  // M ∂α/∂t = ∂f/∂t: the recursion without gravity and at rest.
  std::fill(N_.begin(), N_.end(), 0.0);
  std::fill(F_.begin(), F_.end(), Vec2d{});
  findPinVelocities(eAt_.data(), omegaAt_.data());
  const double power =
      loads_.applyRates(tAt_, eAt_.data(), omegaAt_.data(), pinVelocity_.data(), N_.data(), F_.data());
  arrangeLoads(Acting::forces);
  if (!arrangement_) std::copy(eAt_.begin(), eAt_.end(), e_.begin());
  std::copy(thetaAt_.begin(), thetaAt_.end(), motion_.begin());
  std::fill(motion_.begin() + n_, motion_.end(), 0.0);
  const double* y = motion_.data();
  if (arrangement_) {
    arrange(y, arrangedY_.data());
    y = arrangedY_.data();
  }
  std::fill_n(ft, places_, 0.0);
  run(Acting::forces, {outside_.e, outside_.N, outside_.F, {}}, y, ft + positions_);
  ft[2 * places_] = power;
  ft[2 * places_ + 1] = 0;
  return true;
}

ode::LinearCosts Dynamics::linearCosts() const {
  // By clock, of evaluations as this chain has them; between chains with springs and without. Joining
  // segments is dear for short ones; where factorizations do not stay in cache, solves wait for memory.
  constexpr int isShort = 200, staysInCache = 2500;
  if (!arrangement_) return {2.9, 1, 3.2, 2.8};
  if (n_ <= isShort) return {3, 0.6, 6, 2.3};
  if (n_ <= staysInCache) return {2.6, 0.6, 3, 1.8};
  return {3.4, 1, 3.6, 3.2};
}

void Dynamics::factor(double s) {
  s_ = s;
  std::visit([s](auto& solver) { solver.factor(s); }, *linearized_);
}

void Dynamics::solve(const double* rhs, double* x) {
  std::visit([&](auto& solver) { solver.solve(rhs, rhs + places_, x, x + places_); }, *linearized_);
  if (works_ == 0) return;

  // s x_W = rhs_W + the change of the powers along (u, v).
  const Powers change = powersAlong(x);
  x[2 * places_] = (rhs[2 * places_] + change.supplied) / s_;
  x[2 * places_ + 1] = (rhs[2 * places_ + 1] + change.dissipated) / s_;
}

void Dynamics::reserve(int complexCount) {
  if (!linearized_) {
    linearized_.emplace(solverFor(chain_, arrangement_.has_value()));
    const auto n = index(n_);
    arrangedOmegaAt_.resize(springs_.dissipate() ? index(places_) : 0);
    const std::size_t inOrder = stops_.empty() && loads_.empty() ? 0 : n;
    thetaAt_.resize(inOrder);
    omegaAt_.resize(inOrder);
    if (!loads_.empty()) {
      eAt_.resize(n);
      XF_.resize(n);
    }
    findStiffness();
  }
  while (complexLinearized_.size() < index(complexCount))
    complexLinearized_.push_back(complexOf(*linearized_));
  complexS_.resize(complexLinearized_.size());
  part_.resize(complexLinearized_.empty() ? 0 : index(2 * places_));
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
    const double* k = arranged(kAt_.data(), arrangedY_.data());
    const double* d = arranged(dAt_.data(), arrangedY_.data() + places_);
    std::visit([&](auto& solver) { solver.setJoints(k, d); }, *linearized_);
  }
}

void Dynamics::factorComplex(int k, std::complex<double> s) {
  complexS_[index(k)] = s;
  std::visit([s](auto& solver) { solver.factor(s); }, complexLinearized_[index(k)]);
}

void Dynamics::solveComplex(int k, const std::complex<double>* rhs, std::complex<double>* x) {
  std::visit([&](auto& solver) { solver.solve(rhs, rhs + places_, x, x + places_); },
             complexLinearized_[index(k)]);
  if (works_ == 0) return;

  // The powers change linearly: real and imaginary parts one by one.
  const auto powersOf = [&](auto part) {
    for (int i = 0; i < 2 * places_; ++i) part_[index(i)] = part(x[i]);
    return powersAlong(part_.data());
  };
  const Powers real = powersOf([](std::complex<double> z) { return z.real(); });
  const Powers imaginary = powersOf([](std::complex<double> z) { return z.imag(); });
  const std::complex<double> s = complexS_[index(k)];
  const int works = 2 * places_;
  x[works] = (rhs[works] + std::complex<double>(real.supplied, imaginary.supplied)) / s;
  x[works + 1] = (rhs[works + 1] + std::complex<double>(real.dissipated, imaginary.dissipated)) / s;
}

Dynamics::Powers Dynamics::powersAlong(const double* uv) {
  Powers powers{0, arrangedSprings_.dissipationAlong(arrangedOmegaAt_.data(), uv + places_)};
  if (omegaAt_.empty()) return powers;
  const double* u = inOrder(uv);
  const double* v = u + n_;
  Vec2d change;
  for (int j = 0; j < loads_.reach(); ++j) {
    pinVelocity_[index(j)] = change;
    const Vec2d P = eAt_[index(j)] * chain_.links()[index(j)].pin;
    change += v[j] * perp(P) - (omegaAt_[index(j)] * u[j]) * P;
  }
  powers.supplied = loads_.powerAlong(tAt_, eAt_.data(), omegaAt_.data(), u, v, pinVelocity_.data());
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

Dynamics::Powers Dynamics::findLoadsInOrder(double t, const double* y) {
  if (effects_.empty()) return {};
  clearMoments(t, y, y + n_);
  Powers powers = applyEffects(effectsInOrder_, t, y, y + n_);
  if (!springs_.empty()) powers.dissipated += springs_.apply(y, y + n_, N_.data());
  return powers;
}

void Dynamics::series(double t, const double* y, int order, double* c) {
  evaluations_ += order;
  tAt_ = t;
  std::copy(y, y + 2 * n_, c);
  findLoadsInOrder(t, y);
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
  const Powers powers = findLoadsInOrder(t, y);
  rates[0] = powers.supplied;
  rates[1] = powers.dissipated;
}

double Dynamics::seriesCost(int order) const {
  return series_->cost(order);
}

void Dynamics::linkMotions(double t, const double* y, LinkMotion* motions) {
  evaluateInOrder(t, y, motion_.data());
  rotations(y, e_.data(), n_);
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
