#include "planar_chain/simulation.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>

#include "run/simulation_parts.h"

namespace planar_chain {

namespace {

void requireNotBefore(double t, double now) {
  if (std::isfinite(t) && t >= now) return;
  throw Refused({{"t", "a finite number >= " + toText(now) + " s, the present time", toText(t)}});
}

}  // namespace

Simulation::Simulation(const Scene& scene, int commandCapacity, bool measures)
    : scene_(scene),
      drives_(scene.drives),
      base_(scene.base),
      integrator_(scene.integrator),
      commandCapacity_(commandCapacity),
      measures_(measures) {
  require(commandCapacity >= 0, "the number of commands must not be negative");
  reset();
}

Simulation::~Simulation() = default;

bool Simulation::advanceTo(double t, const std::function<bool()>& keepGoing) {
  Parts& p = *parts_;
  requireNotBefore(t, p.state.t);
  if (!p.fault.empty()) return false;
  p.begin();
  if (p.sampler && p.state.t < t) p.sampler->measureAt(p.state);  // at time 0, once something moves
  bool isWanted = true;
  while (p.state.t < t && p.fault.empty() && !p.isOver() && (isWanted || p.unchecked > 0)) {
    p.advance(t);
    isWanted = isWanted && (!keepGoing || keepGoing());
  }
  if (p.sampler) p.sampler->bank().confirm();
  p.readRelative();
  p.velocities.update(p.qd);
  return p.fault.empty() && p.state.t >= t;
}

bool Simulation::advanceTo(double t, const std::vector<MotionEvent>& events, FoundEvents& found,
                           const std::function<bool()>& keepGoing) {
  Parts& p = *parts_;
  requireNotBefore(t, p.state.t);
  const bool goesOn =
      found.t == p.state.t && found.timesSet == timesSet_ && found.signs.size() == events.size();
  EventWatch watch(events, found, goesOn, p.watchedTo == p.state.t ? p.nearEvents : std::vector<double>(),
                   p.dynamics, p.n,
                   [&p](double at, const double* y, auto& q, auto& qd) { p.toRelative(at, y, q, qd); });
  const auto forget = [&p](EventWatch*) { p.watch = nullptr; };
  const std::unique_ptr<EventWatch, decltype(forget)> atEnd(p.watch = &watch, forget);
  const bool moves = t > p.state.t;
  found.terminal.reset();
  const bool arrives = advanceTo(t, keepGoing);
  if (!moves) return arrives;
  found.t = p.watchedTo = p.state.t;
  found.timesSet = timesSet_;
  watch.end(p.state.t, p.nearEvents);
  return arrives || (p.fault.empty() && found.terminal);
}

Derivatives Simulation::transition(double t, bool motors) {
  requireNotBefore(t, time());
  followDerivatives({}, motors);
  const bool arrives = advanceTo(t);
  const std::unique_ptr<MotionDerivatives> followed = std::move(parts_->derivatives);
  if (!arrives) throw std::domain_error(parts_->fault);
  return parts_->derivativesNow(*followed);
}

void Simulation::followDerivatives(const std::vector<VariedNumber>& numbers, bool motors) {
  require(numbers.empty() || !parts_->commands,
          "derivatives by numbers of the scene need a simulation without commands");
  Parts& p = *parts_;
  p.begin();
  p.derivatives =
      std::make_unique<MotionDerivatives>(scene_, p.dynamics.effects(), p.commands, numbers,
                                          p.state.t == 0 && timesSet_ == 1, motors, p.state.t, p.y);
}

Derivatives Simulation::derivatives() const {
  if (!parts_->derivatives) throw std::logic_error("no derivatives are followed");
  return parts_->derivativesNow(*parts_->derivatives);
}

void Simulation::stopDerivatives() {
  parts_->derivatives.reset();
}

double Simulation::time() const {
  return parts_->state.t;
}

const std::vector<double>& Simulation::q() const {
  return parts_->q;
}

const std::vector<double>& Simulation::qd() const {
  return parts_->qd;
}

const std::string& Simulation::fault() const {
  return parts_->fault;
}

std::string Simulation::method() const {
  return parts_->integrator().name();
}

std::string Simulation::recursion() const {
  return parts_->dynamics.recursion();
}

Statistics Simulation::statistics() const {
  Statistics statistics;
  for (const auto& integrator : parts_->fallbacks) {
    if (!integrator) continue;
    statistics.steps += integrator->count().accepted;
    statistics.rejected += integrator->count().rejected;
  }
  if (parts_->sampler) parts_->sampler->countSteps(statistics.steps, statistics.rejected);
  statistics.evaluations = parts_->dynamics.evaluations();
  statistics.localError = parts_->integrator().count().lastError;
  statistics.rescues = parts_->rescues;
  return statistics;
}

Energy Simulation::energy() const {
  return parts_->dynamics.energy(parts_->state.t, parts_->y.data());
}

EnergyBalance Simulation::energyBalance() const {
  const Energy present = energy();
  const Eigen::Vector2d works = parts_->guard.worksOf(parts_->y.data());
  return {present, works[0], works[1], present.total() - parts_->energyAtStart - works[0] + works[1]};
}

Vec2d Simulation::tipForce() {
  return parts_->dynamicsForQuery().tipForce(parts_->state.t, parts_->y.data());
}

double Simulation::closureError() {
  return parts_->dynamics.closureError(parts_->state.t, parts_->y.data());
}

double Simulation::closureMargin() {
  return parts_->dynamics.closureMargin(parts_->state.t, parts_->y.data());
}

void Simulation::accelerations(double* qdd) {
  parts_->dynamicsForQuery().accelerations(parts_->state.t, parts_->y.data(), qdd);
  parts_->coordinates.toRelative(qdd, qdd);
}

void Simulation::jointTorques(double* tau) {
  parts_->dynamicsForQuery().jointTorques(parts_->state.t, parts_->y.data(), tau);
}

void Simulation::linkMotions(LinkMotion* motions) {
  parts_->dynamicsForQuery().linkMotions(parts_->state.t, parts_->y.data(), motions);
  parts_->windings.addTo(motions);
}

std::vector<Measurement> Simulation::measure() {
  Parts& p = *parts_;
  if (!p.sampler) return {};
  if (p.sampler->bank().next() <= p.state.t) p.dynamicsForQuery();  // at time 0, of what acts from there on
  return p.sampler->measure(p.state);
}

long long Simulation::lostMeasurements() const {
  return parts_->sampler ? parts_->sampler->bank().lost() : 0;
}

bool Simulation::holdTorque(int joint, double torque, double until, double start) {
  return parts_->give({Load::none, {}, {}, 0, joint, torque}, start, until, false);
}

bool Simulation::holdForce(int link, Vec2d point, Vec2d force, double moment, double until, double start) {
  return parts_->give({link, force, point, moment}, start, until, false);
}

bool Simulation::addTorque(int joint, double torque, double duration, double start) {
  return parts_->give({Load::none, {}, {}, 0, joint, torque}, start, duration, true);
}

bool Simulation::addForce(int link, Vec2d point, Vec2d force, double moment, double duration, double start) {
  return parts_->give({link, force, point, moment}, start, duration, true);
}

void Simulation::clearCommands() {
  if (!parts_->commands) return;
  parts_->commands->clear();
  parts_->actOtherwise();
}

const std::vector<long long>& Simulation::cutOffs() const {
  static const std::vector<long long> none;
  return parts_->commands ? parts_->commands->cutOffs() : none;
}

const std::vector<long long>& Simulation::velocityExcesses() const {
  return parts_->velocities.counts();
}

void Simulation::follow(int joint, MotionLaw law) {
  const auto drive = std::find_if(scene_.drives.begin(), scene_.drives.end(),
                                  [joint](const Drive& one) { return one.joint == joint; });
  require(drive != scene_.drives.end(), "only a driven joint can follow a law");
  requireContinuation(law, time(), q()[index(joint)], qd()[index(joint)]);
  for (JointConstraint* jointConstraint : parts_->dynamics.effects().jointConstraints())
    jointConstraint->follow(joint, law);
  drive->law = std::move(law);
  parts_->actOtherwise();
}

void Simulation::followBase(BaseLaws laws) {
  require(scene_.base.has_value(), "only a base that moves can follow laws");
  for (MotionLaw BaseLaws::*law : {&BaseLaws::x, &BaseLaws::y, &BaseLaws::angle}) {
    const GivenMotion present = (*scene_.base.*law).at(time());
    requireContinuation(laws.*law, time(), present.value, present.rate);
  }
  for (JointConstraint* jointConstraint : parts_->dynamics.effects().jointConstraints())
    jointConstraint->followBase(laws);
  scene_.base = std::move(laws);
  parts_->actOtherwise();
}

void Simulation::setTolerance(double tolerance) {
  require(tolerance >= IntegratorSettings::finest && tolerance <= IntegratorSettings::coarsest,
          "a tolerance must be from 1e-15 to 1");
  scene_.integrator.tolerance = tolerance;
  if (integrator_.rateTolerance) {
    scene_.integrator.rateTolerance = *integrator_.rateTolerance * (tolerance / integrator_.tolerance);
  }
  parts_->useTolerance();
}

void Simulation::setState(const std::vector<double>& q, const std::vector<double>& qd) {
  parts_->set(q, qd);
  ++timesSet_;
}

void Simulation::reset() {
  scene_.drives = drives_;
  scene_.base = base_;
  scene_.integrator = integrator_;
  // Made anew: nothing that a method has learnt on the way is left.
  parts_ = std::make_unique<Parts>(scene_, commandCapacity_, measures_);
  parts_->set(scene_.q, scene_.qd);
  ++timesSet_;
}

}  // namespace planar_chain
