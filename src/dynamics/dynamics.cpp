#include "dynamics/dynamics.h"

#include <algorithm>

namespace planar_chain {

namespace {

/// True if the recursion of bare chains does it all.
bool isBare(const Scene& scene, const Effects& effects) {
  return !scene.chain.coordinates().anyIsPrismatic() && effects.jointConstraints().empty() &&
         !effects.anyForces(&Forces::dependOnMotion);
}

}  // namespace

Dynamics::Dynamics(const Scene& scene, std::unique_ptr<Effect> more)
    : effects_(scene, std::move(more)),
      mechanism_(scene, !isBare(scene, effects_)),
      n_(mechanism_.size()),
      firstRate_(mechanism_.paddedSize()),
      works_(effects_.any(&Effect::hasPower) ? 2 : 0),
      stores_(scene.chain),
      recursion_(mechanism_.makeRecursion()) {
  effects_.takeLaneOrder(mechanism_.lanes());
  if (!isBare(scene, effects_)) general_.emplace(mechanism_, effects_);
  if (isFree(scene)) momenta_.emplace(mechanism_, effects_);
  positions_ = !general_ && std::holds_alternative<ShortChain>(recursion_) ? 0 : firstRate_;

  const auto n = index(n_);
  const bool acts = !effects_.empty(), hasForces = effects_.mostActing() == LoadKind::forces;
  room_.e.resize(index(ShortChain::roomFor(n_)));
  room_.derivative.resize(index(size()));
  room_.N.resize(acts || general_ ? n : 0);
  room_.F.resize(hasForces ? n : 0);
  room_.pinVelocity.resize(room_.F.size());
  N_ = room_.N.data();
  external_ = {room_.e.data(), N_, room_.F.data(), -1.0 * scene.chain.gravity()};
  if (mechanism_.lanes()) {
    const auto firstRate = index(firstRate_);
    room_.state.resize(2 * n);
    room_.eInLanes = AlignedArray<Rotation<double>>(firstRate);
    room_.FInLanes = AlignedArray<Vec2d>(hasForces ? firstRate : 0);
    room_.NInLanes = CacheLines(acts ? firstRate : 0);
    room_.yInLanes = CacheLines(index(sizeInLaneOrder()));
    room_.ratesInLanes = CacheLines(index(firstRate_ + works_));
    N_ = room_.NInLanes.data();
    external_ = {room_.eInLanes.data(), N_, room_.FInLanes.data(), external_.ground};
  }
  enter(0);
}

std::string Dynamics::recursion() const {
  if (general_) return general_->recursion();
  return std::visit([](const auto& recursion) { return recursion.name(); }, recursion_);
}

// ---- What acts -------------------------------------------------------------------------------------

void Dynamics::enter(double t) {
  effects_.enter(t);
  if (general_) general_->forget();
  switched();
}

bool Dynamics::enter(double t, double* y) {
  enter(t);
  reconsider(t, y);
  return hold(t, y);
}

bool Dynamics::begin(double t, double* y) {
  enter(t);
  enterState(t, y);
  return hold(t, y);
}

void Dynamics::reconsider(double t, double* y) {
  if (general_) general_->forget();
  if (!effects_.events().empty()) fire(t, y);
}

void Dynamics::enterState(double t, const double* y) {
  if (general_) general_->forget();
  effects_.enterState(t, y);
  switched();
}

void Dynamics::fire(double t, double* y, const ode::LocatedEvent& located) {
  if (general_) general_->prepareChange();
  effects_.fire(t, y, located);
  switched();
}

void Dynamics::saveOrRestore(Snapshot& snapshot) {
  effects_.saveOrRestore(snapshot);
  if (general_) general_->saveOrRestore(snapshot);
  snapshot(evaluations_, seriesOrders_);
  if (snapshot.isReading()) switched();
}

void Dynamics::switched() {
  isBare_ = !general_ && !effects_.act() && works_ == 0;
  if (tangents_) takeStiffness();
}

/// Allocates the first time.
void Dynamics::takeStiffness() {
  if (!tangents_) tangents_.emplace(n_, effects_);
  tangents_->takeConstant(effects_);
  if (solve_) solve_->takeStiffness();
}

ChainState Dynamics::stateWithForces(double t, const double* theta, const double* omega) {
  mechanism_.rotate(theta, room_.e.data(), n_);
  std::fill(room_.F.begin(), room_.F.end(), Vec2d{});
  mechanism_.findPinVelocities(room_.e.data(), omega, effects_.reach(), room_.pinVelocity.data());
  return {t, theta, omega, room_.e.data(), room_.pinVelocity.data()};
}

Powers Dynamics::apply(const std::vector<Effect*>& effects, double t, const double* theta,
                       const double* omega) {
  std::fill(room_.N.begin(), room_.N.end(), 0.0);
  ChainState at{t, theta, omega};
  if (effects_.acting() == LoadKind::forces) at = stateWithForces(t, theta, omega);
  return Effects::apply(effects, at, {room_.N.data(), room_.F.data()});
}

void Dynamics::loadsToLanes(LoadKind acting) {
  const LaneOrder* lanes = mechanism_.lanes();
  if (!lanes || acting == LoadKind::nothing) return;
  lanes->toLaneOrder(room_.N.data(), N_);
  if (acting == LoadKind::forces) lanes->toLaneOrder(room_.F.data(), room_.FInLanes.data());
}

// ---- Two orders ------------------------------------------------------------------------------------

void Dynamics::toLaneOrder(const double* y, double* laneOrdered) const {
  mechanism_.toLaneOrder(y, laneOrdered);
  std::copy_n(y + 2 * n_, works_, laneOrdered + 2 * firstRate_);
}

void Dynamics::toChainOrder(const double* laneOrdered, double* y) const {
  mechanism_.toChainOrder(laneOrdered, y);
  std::copy_n(laneOrdered + 2 * firstRate_, works_, y + 2 * n_);
}

// ---- f(t, y) ---------------------------------------------------------------------------------------

[[gnu::always_inline]] inline void Dynamics::run(LoadKind acting, const Loads& external, const double* y,
                                                 double* rates) {
  if (auto* chain = std::get_if<ShortChain>(&recursion_))
    return chain->derivative(acting, external, y, rates);
  runLong(acting, external, y, rates);
}

/// Not inline: short chains would save registers for it.
[[gnu::noinline]] void Dynamics::runLong(LoadKind acting, const Loads& external, const double* y,
                                         double* rates) {
  const double* omega = y + firstRate_;
  const double* N = acting == LoadKind::nothing ? nullptr : external.N;
  const Vec2d* F = acting == LoadKind::forces ? external.F : nullptr;
  mechanism_.rotate(y, external.e, firstRate_);
  std::get_if<Segments>(&recursion_)->accelerations(external.e, omega, N, F, external.ground, rates);
}

inline void Dynamics::evaluateRates(double t, const double* y, double* out) {
  if (isBare_) return run(LoadKind::nothing, external_, y, out);
  evaluateEffects(t, y, out);
}

inline Powers Dynamics::ratesUnderEffects(double t, const double* y, double* out) {
  // Effects that need chain order come first, and write N and F.
  Powers powers;
  const LoadKind acting = effects_.acting();
  if (!effects_.activeInOrder().empty()) {
    const double* ordered = mechanism_.stateInOrder(y, room_.state.data());
    powers = apply(effects_.activeInOrder(), t, ordered, ordered + n_);
    loadsToLanes(acting);
  } else if (acting != LoadKind::nothing) {
    std::fill_n(N_, firstRate_, 0.0);
  }
  for (InLanes* effect : effects_.activeInLanes()) powers += effect->applyInLanes(y, y + firstRate_, N_);
  run(acting, external_, y, out);
  return powers;
}

[[gnu::noinline]] void Dynamics::evaluateEffects(double t, const double* y, double* out) {
  const Powers powers = general_ ? general_->rates(t, y, out) : ratesUnderEffects(t, y, out);
  if (works_ == 0) return;
  double* works = out + 2 * firstRate_ - positions_;
  works[0] = powers.supplied;
  works[1] = powers.dissipated;
}

void Dynamics::evaluate(double t, const double* y, double* dydt) {
  std::copy_n(y + firstRate_, positions_, dydt);
  evaluateRates(t, y, dydt + positions_);
}

void Dynamics::rates(double t, const double* y, double* out) {
  ++evaluations_;
  evaluateRates(t, y, out);
}

void Dynamics::derivative(double t, const double* y, double* dydt) {
  ++evaluations_;
  evaluateInOrder(t, y, dydt);
}

void Dynamics::evaluateInOrder(double t, const double* y, double* dydt) {
  const LaneOrder* lanes = mechanism_.lanes();
  if (!lanes) return evaluate(t, y, dydt);
  mechanism_.toLaneOrder(y, room_.yInLanes.data());
  double* rates = room_.ratesInLanes.data();
  evaluateRates(t, room_.yInLanes.data(), rates);
  std::copy_n(y + n_, n_, dydt);
  lanes->toChainOrder(rates, dydt + n_);
  std::copy_n(rates + firstRate_, works_, dydt + 2 * n_);
}

const Vec2d* Dynamics::evaluateWithForces(double t, const double* y, double* dydt) {
  evaluateInOrder(t, y, dydt);
  return effects_.reach() > 0 ? room_.F.data() : nullptr;
}

// ---- The exact solve -------------------------------------------------------------------------------

void Dynamics::reserve(int complexCount) {
  if (!solve_) {
    takeStiffness();
    solve_.emplace(mechanism_, effects_, *tangents_, !general_);
    solve_->takeStiffness();
  }
  solve_->reserve(complexCount);
}

void Dynamics::linearize(double t, const double* y, double* dydt) {
  ++evaluations_;
  evaluate(t, y, dydt);
  if (general_) return solve_->linearize(general_->at(t, y));
  solve_->linearize(t, y, dydt, external_);
}

bool Dynamics::timeDerivative(double* ft) {
  if (!effects_.varyWithTime()) return false;
  std::fill_n(ft, firstRate_, 0.0);
  const Powers power =
      general_ ? solve_->timeDerivative(ft + firstRate_) : timeDerivativeOfLoads(ft + positions_);
  if (works_ == 0) return true;
  ft[2 * firstRate_] = power.supplied;
  ft[2 * firstRate_ + 1] = power.dissipated;
  return true;
}

/// M ∂α/∂t = ∂f/∂t: the recursion without gravity and at rest.
Powers Dynamics::timeDerivativeOfLoads(double* slopes) {
  std::fill(room_.N.begin(), room_.N.end(), 0.0);
  std::fill(room_.F.begin(), room_.F.end(), Vec2d{});
  solve_->findPinVelocities();
  const ChainState& at = solve_->state();
  const Powers power = effects_.applyRates(at, {room_.N.data(), room_.F.data()});
  const LoadKind acting = effects_.mostActing();
  loadsToLanes(acting);
  if (acting == LoadKind::forces) std::copy_n(at.e, n_, room_.e.begin());
  double* atRest = room_.derivative.data();
  std::copy_n(at.theta, n_, atRest);
  std::fill_n(atRest + n_, n_, 0.0);
  const double* y = atRest;
  if (mechanism_.lanes()) {
    mechanism_.toLaneOrder(atRest, room_.yInLanes.data());
    y = room_.yInLanes.data();
  }
  run(acting, {external_.e, external_.N, external_.F, {}}, y, slopes);
  return power;
}

// ---- What others read ------------------------------------------------------------------------------

Energy Dynamics::energy(double t, const double* y) const {
  const BaseLaws* laws = effects_.base();
  return energyOf(mechanism_.chain(), stores_, y, y + n_, laws ? stateOf(*laws, t) : BaseState{});
}

void Dynamics::accelerations(double t, const double* y, double* alpha) {
  if (general_) {
    std::copy_n(general_->query(t, y).slopes(), n_, alpha);
    return;
  }
  evaluateInOrder(t, y, room_.derivative.data());
  std::copy_n(room_.derivative.data() + n_, n_, alpha);
}

void Dynamics::linkMotions(double t, const double* y, LinkMotion* motions) {
  if (general_) {
    const Evaluation& at = general_->query(t, y);
    const Vec2d acceleration = at.ground + mechanism_.chain().gravity();
    const Vec2d* F = effects_.acting() == LoadKind::forces ? at.F.data() : nullptr;
    return moveLinks({{at.base.pin, at.base.velocity},
                      acceleration,
                      at.groundTurning,
                      at.base.angle,
                      y,
                      at.e.data(),
                      at.omega(),
                      at.xdd.data(),
                      at.displaced.data(),
                      F,
                      at.ends.tip.force},
                     motions);
  }
  const Vec2d* F = evaluateWithForces(t, y, room_.derivative.data());
  mechanism_.rotate(y, room_.e.data(), n_);
  moveLinks({{}, {}, 0, 0, y, room_.e.data(), y + n_, room_.derivative.data() + n_, nullptr, F}, motions);
}

void Dynamics::moveLinks(const ChainMotion& from, LinkMotion* motions) const {
  const Chain& chain = mechanism_.chain();
  const Coordinates& coordinates = chain.coordinates();

  // Outwards: positions, velocities, accelerations of the pins and of the centres of mass.
  Moved<double> moved{from.acceleration, from.turning};
  sweepOutwards(chain, from.pin, from.e, from.omega, from.y, from.y + n_,
                [&](int j, const PointAt<double>& own) {
                  const Link& link = chain.links()[index(j)];
                  if (coordinates.isPrismatic(j)) {
                    const auto& [d, S, gamma] = from.displaced[j];
                    moved.a = mulAdd(moved.alpha, perp(S), moved.a + gamma) + from.xdd[j] * d;
                  } else {
                    moved.alpha = from.xdd[j];
                  }
                  const double w = from.omega[j], alpha = moved.alpha;
                  const Vec2d R = from.e[j] * link.com, P = from.e[j] * link.pin;
                  LinkMotion& body = motions[j];
                  body.innerPin = own.position;
                  body.angle = coordinates.angle(from.y, j) + from.angle;
                  body.com = own.position + R;
                  body.velocity = own.velocity + w * perp(R);
                  body.omega = w;
                  body.acceleration = moved.a + alpha * perp(R) - (w * w) * R;
                  body.alpha = alpha;
                  moved.a += alpha * perp(P) - (w * w) * P;
                });

  // Inwards: the forces in the pins, F_pin,j = m (a_j − g) − F_j + F_pin,j+1.
  Vec2d next = -1.0 * from.tipForce;
  for (int j = n_ - 1; j >= 0; --j) {
    next += chain.links()[index(j)].mass * (motions[j].acceleration - chain.gravity());
    if (from.F) next -= from.F[j];
    motions[j].pinForce = next;
  }
}

void Dynamics::jointTorques(double t, const double* y, double* tau) {
  std::fill_n(tau, n_, 0.0);
  ChainState at{t, y, y + n_};
  if (general_) {
    general_->torques(t, y, tau);
    at = general_->query(t, y).state();
  }
  for (Effect* effect : effects_.active()) {
    if (!effect->jointConstraint()) effect->addTorques(at, tau);
  }
}

}  // namespace planar_chain
