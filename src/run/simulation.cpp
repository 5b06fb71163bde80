#include "planar_chain/simulation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "dynamics/closed_state.h"
#include "dynamics/dynamics.h"
#include "dynamics/given_state.h"
#include "effects/motors.h"
#include "ode/methods.h"
#include "run/energy_guard.h"
#include "run/ladder.h"
#include "run/requirements.h"
#include "run/sampler.h"
#include "run/turns.h"
#include "run/velocity_limits.h"
#include "simd/cpu.h"

namespace planar_chain {

namespace {

constexpr int longestRescue = 1024;  // checks that pass before the scene's own method is tried again

}  // namespace

struct Simulation::Parts {
  const Scene& scene;
  const int n = scene.chain.size();
  const Coordinates coordinates = scene.chain.coordinates();
  CommandEffect* commands = nullptr;  ///< among the dynamics' effects; nullptr: this simulation takes none
  Dynamics dynamics;
  std::array<std::unique_ptr<ode::Integrator>, rungs> ladder;
  std::size_t rung = 0;
  int goodChecks = 0, rescueLength = 1;  // checks since the ladder was climbed; to pass on a higher rung
  Pace pace{leastPaceOf(scene.integrator)};
  long long rescues = 0, unchecked = 0;  // unchecked: steps since the last check of energy
  bool switchedSince = false;            // likewise
  EnergyGuard guard{scene, dynamics};
  Turns turns{scene, dynamics.size()};
  VelocityLimits velocities{scene.chain};
  ode::State state{dynamics.arrangedSize()};
  Eigen::VectorXd y = Eigen::VectorXd::Zero(dynamics.size());  ///< the state in the order of the chain
  std::vector<double> q = scene.q, qd = scene.qd;
  double energyAtStart = 0;
  bool actsOtherwise = false;  // than the dynamics know
  std::string fault;
  std::unique_ptr<Sampler> sampler;  // nullptr: nothing is measured

  Parts(const Scene& given, int commandCapacity, bool measures)
      : scene(given), dynamics(scene, keep(makeCommands(scene.chain, commandCapacity))) {
    fault.reserve(300);
    if (measures && !scene.sensors.empty()) sampler = std::make_unique<Sampler>(scene, dynamics, turns);
    climbTo(0);
  }

  std::unique_ptr<CommandEffect> keep(std::unique_ptr<CommandEffect> made) {
    commands = made.get();
    return made;
  }

  ode::Integrator& integrator() const { return *ladder[rung]; }

  /// The scene has another tolerance.
  void useTolerance() {
    for (std::size_t k = 0; k < rungs; ++k) {
      if (ladder[k]) ladder[k]->setTolerance(toleranceOf(scene, k, dynamics).arrangedBy(dynamics));
    }
    if (sampler) sampler->useTolerance();
    guard.use(scene.integrator);
  }

  void climbTo(std::size_t next) {
    rung = next;
    if (!ladder[rung]) ladder[rung] = methodOf(scene, rung, dynamics);
    pace.begin(integrator().count(), state.t);
  }

  void restore() { dynamics.restore(state.y.data(), y.data()); }

  void set(std::vector<double> newQ, std::vector<double> newQd) {
    std::vector<Fault> faults;
    stateOf(scene, state.t, vectorOf(newQ), vectorOf(newQd), faults);
    if (!faults.empty()) throw Refused(std::move(faults));
    closeState(scene, state.t, newQ, newQd);
    coordinates.toAbsolute(newQ.data(), y.data());
    coordinates.toAbsolute(newQd.data(), y.data() + n);
    const double energy = dynamics.energy(state.t, y.data()).total();
    if (!std::isfinite(energy)) restore();
    require(std::isfinite(energy), "q and qd must be of finite energy");
    turns.take(newQ, y.data());
    energyAtStart = dynamics.energy(state.t, y.data()).total();
    q = newQ;
    qd = newQd;
    y.tail(dynamics.works()).setZero();
    dynamics.arrange(y.data(), state.y.data());
    state.carry.setZero();
    fault.clear();
    guard.begin(state, y.data());
    unchecked = 0;
    switchedSince = false;
    climbTo(0);
    rescueLength = 1;
    dynamics.enter(state.t);
    dynamics.enterState(state.t, y.data());
    settle();
    actsOtherwise = false;
    integrator().begin();
  }

  /// Puts held joints exactly where they are.
  void settle() {
    if (dynamics.hold(state.t, y.data())) takeChain();
  }
  void takeChain() {  // y is the state from now on
    dynamics.arrange(y.data(), state.y.data());
    if (unchecked == 0) guard.moveTo(state);
  }

  /// Call after the acting forces change.
  void actAnew() {
    dynamics.enter(state.t);
    dynamics.reconsider(state.t, y.data());
    settle();
    integrator().restart();
    actsOtherwise = false;
  }

  /// The dynamics as of the last command.
  Dynamics& settled() {
    if (actsOtherwise) actAnew();
    return dynamics;
  }

  /// Gives a command from `start` on: held to the time `last`, or timed, for `last` seconds.
  bool give(Command command, double start, double last, bool isTimed) {
    require(commands != nullptr, "this simulation was built without room for commands");
    command.start = start == now ? state.t : start;
    command.stop = isTimed ? command.start + last : last;
    requireOf(command, scene, state.t, isTimed);
    const bool taken = isTimed ? commands->add(command, state.t) : commands->hold(command, state.t);
    if (taken && command.start <= state.t && commands->isPrompt(command.joint)) actsOtherwise = true;
    return taken;
  }

  /// Some steps towards t; or, in trouble, none, and the next rung of the ladder.
  void advance(double t) {
    const double end = std::min(t, dynamics.effects().until());
    const long long before = integrator().count().accepted;
    const double longest = dynamics.effects().longestStep();
    const ode::Outcome outcome = sampler ? sampler->integrate(integrator(), state, end, longest)
                                         : integrator().integrate(state, end, longest, EnergyCheck::period);
    restore();
    unchecked += integrator().count().accepted - before;
    const bool hasSwitched = outcome == ode::Outcome::switched;
    const bool isDue = !hasSwitched || unchecked >= EnergyCheck::period || state.t >= end;
    if (ode::hasFailed(outcome) || (isDue && !guard.accept(state, y.data(), unchecked)))
      return goBack(outcome);
    if (isDue) {
      unchecked = 0;
      switchedSince = false;
      if (turns.takeMore(dynamics, state, y)) guard.moveTo(state);
    }

    if (hasSwitched) {
      dynamics.change(state.t, y.data(), integrator().crossing());
      takeChain();
      integrator().passSwitch();
      switchedSince = true;
    }
    if (state.t >= dynamics.effects().until()) {
      actAnew();
    } else {
      settle();
    }
    if (rung > 0 && unchecked == 0 && ++goodChecks >= rescueLength) {
      climbTo(0);
      integrator().begin();
    } else if (isStuck()) {
      rescueBy(rungs - 1);
    }
  }

  /// To the last good state, and on by the next rung of the ladder, if there is one.
  void goBack(ode::Outcome outcome) {
    state = guard.lastGood();
    restore();
    unchecked = 0;
    if (sampler) sampler->bank().dropAfter(state.t);
    if (std::exchange(switchedSince, false)) dynamics.enterState(state.t, y.data());
    if (rung + 1 == rungs) {
      return describeFailure(fault, scene, state.t, outcome, guard.gap(),
                             dynamics.isStretched(state.t, y.data()));
    }
    dynamics.reconsider(state.t, y.data());  // results for these times belong to other states
    rescueBy(rung + 1);
  }

  void rescueBy(std::size_t next) {
    if (rung == 0) rescueLength = std::min(2 * rescueLength, longestRescue);
    ++rescues;
    goodChecks = 0;
    climbTo(next);
    integrator().begin();
  }

  long long evaluations() const { return dynamics.evaluations() - (sampler ? sampler->evaluations() : 0); }

  /// True if another method will be faster: the motion is stiff, or a stop ends unstable steps at once.
  bool isStuck() { return rung + 1 < rungs && pace.isSlow(integrator().count(), state.t); }

  void readRelative() {
    coordinates.toRelative(y.data(), q.data());
    coordinates.toRelative(y.data() + n, qd.data());
    dynamics.hold(state.t, q.data(), qd.data());
    turns.addTo(q);
  }
};

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
  if (!(std::isfinite(t) && t >= p.state.t)) {
    throw Refused({{"t", "a finite number >= " + toText(p.state.t) + " s, the present time", toText(t)}});
  }
  if (!p.fault.empty()) return false;
  if (p.sampler) p.sampler->measureAt(p.state);  // at time 0; commands act later
  p.settled();
  bool isWanted = true;
  while (p.state.t < t && p.fault.empty() && (isWanted || p.unchecked > 0)) {
    p.advance(t);
    isWanted = isWanted && (!keepGoing || keepGoing());
  }
  if (p.sampler) p.sampler->bank().confirm();
  p.readRelative();
  p.velocities.update(p.qd);
  return p.fault.empty() && p.state.t >= t;
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
  for (const auto& integrator : parts_->ladder) {
    if (!integrator) continue;
    statistics.steps += integrator->count().accepted;
    statistics.rejected += integrator->count().rejected;
  }
  statistics.evaluations = parts_->evaluations();
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
  return parts_->settled().tipForce(parts_->state.t, parts_->y.data());
}
double Simulation::closureError() {
  return parts_->dynamics.closureError(parts_->state.t, parts_->y.data());
}
double Simulation::closureMargin() {
  return parts_->dynamics.closureMargin(parts_->state.t, parts_->y.data());
}

void Simulation::accelerations(double* qdd) {
  parts_->settled().accelerations(parts_->state.t, parts_->y.data(), qdd);
  parts_->coordinates.toRelative(qdd, qdd);
}
void Simulation::jointTorques(double* tau) {
  parts_->settled().jointTorques(parts_->state.t, parts_->y.data(), tau);
}
void Simulation::linkMotions(LinkMotion* motions) {
  parts_->settled().linkMotions(parts_->state.t, parts_->y.data(), motions);
  parts_->turns.addTo(motions);
}

std::vector<Measurement> Simulation::measure() {
  return parts_->sampler ? parts_->sampler->measure(parts_->state) : std::vector<Measurement>();
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
  parts_->actsOtherwise = true;
}
CommandEffect* Simulation::commandEffect() const {
  return parts_->commands;
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
  for (Coupler* coupler : parts_->dynamics.effects().couplers()) coupler->follow(joint, law);
  drive->law = std::move(law);
  parts_->actsOtherwise = true;
}

void Simulation::followBase(BaseLaws laws) {
  require(scene_.base.has_value(), "only a base that moves can follow laws");
  require(scene_.chain.slides() == 0 || laws.angle.isZero(), "a base with prismatic links cannot turn");
  for (MotionLaw BaseLaws::*law : {&BaseLaws::x, &BaseLaws::y, &BaseLaws::angle}) {
    const GivenMotion present = (*scene_.base.*law).at(time());
    requireContinuation(laws.*law, time(), present.value, present.rate);
  }
  for (Coupler* coupler : parts_->dynamics.effects().couplers()) coupler->followBase(laws);
  scene_.base = std::move(laws);
  parts_->actsOtherwise = true;
}

void Simulation::setTolerance(double tolerance) {
  require(tolerance >= 1e-15 && tolerance <= 1, "a tolerance must be from 1e-15 to 1");
  scene_.integrator.tolerance = tolerance;
  if (integrator_.rateTolerance) {
    scene_.integrator.rateTolerance = *integrator_.rateTolerance * (tolerance / integrator_.tolerance);
  }
  parts_->useTolerance();
}

void Simulation::setState(const std::vector<double>& q, const std::vector<double>& qd) {
  parts_->set(q, qd);
}

void Simulation::reset() {
  const simd::PlainKernels plain(scene_.integrator.plainKernel);
  scene_.drives = drives_;
  scene_.base = base_;
  scene_.integrator = integrator_;
  // Made anew: nothing that a method has learnt on the way is left.
  parts_ = std::make_unique<Parts>(scene_, commandCapacity_, measures_);
  parts_->set(scene_.q, scene_.qd);
}

}  // namespace planar_chain
