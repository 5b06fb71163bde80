#pragma once

/// What a simulation is made of, and one step of its way: the dynamics, the methods in turn, the guard on
/// the energy balance, and the state.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/closed_state.h"
#include "dynamics/dynamics.h"
#include "dynamics/given_state.h"
#include "effects/motors.h"
#include "planar_chain/simulation.h"
#include "run/energy_guard.h"
#include "run/event_watch.h"
#include "run/fallbacks.h"
#include "run/motion_derivatives.h"
#include "run/requirements.h"
#include "run/sampler.h"
#include "run/velocity_limits.h"
#include "run/windings.h"

namespace planar_chain {

struct Simulation::Parts {
  /// Checks that pass before the scene's own method is tried again.
  static constexpr int longestRescue = 1024;

  const Scene& scene;
  const int n = scene.chain.size();
  const Coordinates coordinates = scene.chain.coordinates();
  CommandEffect* commands = nullptr;  ///< among the dynamics' effects; nullptr: this simulation takes none
  Dynamics dynamics;
  std::array<std::unique_ptr<ode::Integrator>, fallbackCount> fallbacks;
  std::array<double, fallbackCount> madeFor{};  ///< the tolerance when each was made
  std::size_t fallback = 0;
  int goodChecks = 0,
      rescueLength = 1;  // checks since a method failed; to pass before the scene's is tried again
  MeanStep meanStep{leastMeanStepOf(scene.integrator)};
  long long rescues = 0, unchecked = 0;  // unchecked: steps since the last check of energy
  bool switchedSince = false;            // likewise
  EnergyGuard guard{scene, dynamics};
  Windings windings{scene, dynamics.size()};
  VelocityLimits velocities{scene.chain};
  ode::State state{dynamics.sizeInLaneOrder()};
  Eigen::VectorXd y = Eigen::VectorXd::Zero(dynamics.size());  ///< the state in the order of the chain
  std::vector<double> q = scene.q, qd = scene.qd;
  double energyAtStart = 0;
  bool actsOtherwise = false;  // than the dynamics know
  bool isTried = false;        // for a query, the dynamics have taken what acts otherwise since `untried`
  Eigen::VectorXd untried{commands ? y.size() : 0};
  std::string fault;
  std::unique_ptr<Sampler> sampler;                // nullptr: nothing is measured
  std::unique_ptr<MotionDerivatives> derivatives;  // nullptr: they are not followed
  EventWatch* watch = nullptr;                     // nullptr: no events are watched
  double watchedTo = -1;                           // s: where events were last watched
  std::vector<double> nearEvents;                  // likewise, what they were near 0
  Eigen::VectorXd pieceFrom;                       // for these: y where the present piece began

  Parts(const Scene& given, int commandCapacity, bool measures)
      : scene(given), dynamics(scene, keep(makeCommands(scene.chain, commandCapacity))) {
    if (measures && !scene.sensors.empty()) sampler = std::make_unique<Sampler>(scene, dynamics, windings);
    useFallback(0);
  }

  std::unique_ptr<CommandEffect> keep(std::unique_ptr<CommandEffect> made) {
    commands = made.get();
    return made;
  }

  ode::Integrator& integrator() const { return *fallbacks[fallback]; }

  /// The scene has another tolerance.
  void useTolerance() {
    for (std::size_t k = 0; k < fallbackCount; ++k) {
      if (fallbacks[k]) fallbacks[k]->setTolerance(toleranceOf(scene, k, dynamics).inLaneOrder(dynamics));
    }
    if (sampler) sampler->useTolerance();
    guard.use(scene.integrator);
  }

  void make(std::size_t k, const Scene& of) {
    fallbacks[k] = methodOf(of, k, dynamics);
    madeFor[k] = of.integrator.tolerance;
  }
  void useFallback(std::size_t next) {
    fallback = next;
    if (!fallbacks[fallback]) make(fallback, scene);
    meanStep.begin(integrator().count(), state.t);
  }

  void restore() { dynamics.toChainOrder(state.y.data(), y.data()); }

  void set(std::vector<double> newQ, std::vector<double> newQd) {
    undoTrial();
    std::vector<Fault> faults;
    stateOf(scene, state.t, vectorOf(newQ), vectorOf(newQd), faults);
    if (!faults.empty()) throw Refused(std::move(faults));
    closeState(scene, state.t, newQ, newQd);
    coordinates.toAbsolute(newQ.data(), y.data());
    coordinates.toAbsolute(newQd.data(), y.data() + n);
    const double energy = dynamics.energy(state.t, y.data()).total();
    if (!std::isfinite(energy)) restore();
    require(std::isfinite(energy), "q and qd must be of finite energy");

    windings.take(newQ, y.data());
    energyAtStart = dynamics.energy(state.t, y.data()).total();
    q = newQ;
    qd = newQd;

    y.tail(dynamics.works()).setZero();
    dynamics.toLaneOrder(y.data(), state.y.data());
    state.carry.setZero();
    fault.clear();
    derivatives.reset();

    guard.begin(state, y.data());
    unchecked = 0;
    switchedSince = false;
    useFallback(0);
    rescueLength = 1;

    if (dynamics.begin(state.t, y.data())) takeChain();
    actsOtherwise = false;
    integrator().begin();
  }

  /// Puts held joints exactly where they are.
  void snapPrescribed() {
    if (dynamics.hold(state.t, y.data())) takeChain();
  }

  /// y is the state from now on.
  void takeChain() {
    dynamics.toLaneOrder(y.data(), state.y.data());
    if (unchecked == 0) guard.moveTo(state);
  }

  /// Call after the acting forces change.
  void actAnew() {
    if (dynamics.enter(state.t, y.data())) takeChain();
    integrator().restart();
    if (derivatives) derivatives->enter();
    actsOtherwise = false;
  }

  /// The dynamics as of the last command: for a query.
  Dynamics& dynamicsForQuery() {
    if (actsOtherwise) {
      dynamics.remember();
      untried = y;
      actAnew();
      isTried = true;
    }
    return dynamics;
  }

  /// Goes back to before the queries at this time, so that the next commands find what they would find
  /// without them.
  void undoTrial() {
    if (!std::exchange(isTried, false)) return;
    dynamics.recall();
    y = untried;
    takeChain();
    actsOtherwise = true;
  }

  /// Call after commands or laws change. Without commands, allocates the first time.
  void actOtherwise() {
    undoTrial();
    untried.resize(y.size());
    actsOtherwise = true;
  }

  /// Before the first step from here.
  void begin() {
    isTried = false;
    if (actsOtherwise) actAnew();
  }

  /// Gives a command from `start` on: held to the time `last`, or timed, for `last` seconds.
  bool give(Command command, double start, double last, bool isTimed) {
    require(commands != nullptr, "this simulation was built without room for commands");
    command.start = start == now ? state.t : start;
    command.stop = isTimed ? command.start + last : last;
    requireOf(command, scene, state.t, isTimed);
    const bool taken = isTimed ? commands->add(command, state.t) : commands->hold(command, state.t);
    if (taken && command.start <= state.t && commands->isPrompt(command.joint)) actOtherwise();
    return taken;
  }

  /// Some steps towards t; or, in trouble, none, and the next method.
  void advance(double t) {
    const double end = std::min(t, dynamics.effects().until());
    const ode::StepCount before = integrator().count();
    const double longest = dynamics.effects().longestStep();
    const double begin = state.t;
    if (derivatives) pieceFrom = y;
    ode::Integrator& steps = watch ? watch->over(integrator()) : integrator();
    const ode::Outcome outcome = sampler       ? sampler->integrate(steps, state, end, longest)
                                 : derivatives ? integrateWithDerivatives(steps, end, longest)
                                               : steps.integrate(state, end, longest, EnergyCheck::period);
    restore();
    if (watch) watch->take();

    // The balance of energy, every few steps.
    const ode::StepCount count = integrator().count();
    unchecked += count.accepted - before.accepted;
    const bool hasSwitched = outcome == ode::Outcome::switched;
    const bool isDue = !hasSwitched || unchecked >= EnergyCheck::period || state.t >= end || isOver();
    if (ode::hasFailed(outcome) || (isDue && !guard.accept(state, y.data(), unchecked)))
      return goBack(outcome);
    if (derivatives && count.leaps > before.leaps) derivatives->passChangePoint(begin);
    if (derivatives && sampler) derivatives->follow(begin, pieceFrom, state.t, y, {});
    if (isDue) {
      if (derivatives) derivatives->keep();
      unchecked = 0;
      switchedSince = false;
      if (windings.takeMore(dynamics, state, y)) guard.moveTo(state);
    }

    if (hasSwitched) {
      if (derivatives) derivatives->meet(state.t, y, integrator().event());
      dynamics.fire(state.t, y.data(), integrator().event());
      takeChain();
      if (derivatives) derivatives->pass(state.t, y);
      integrator().passEvent();
      switchedSince = true;
    }
    if (state.t >= dynamics.effects().until()) {
      actAnew();
    } else {
      snapPrescribed();
    }

    if (fallback > 0 && unchecked == 0 && ++goodChecks >= rescueLength) {
      useFallback(0);
      integrator().begin();
    } else if (isStuck()) {
      rescueBy(fallbackCount - 1);
    }
  }

  /// As Integrator::integrate(), and derivatives follow each step.
  ode::Outcome integrateWithDerivatives(ode::Integrator& steps, double end, double longest) {
    ode::Outcome outcome = ode::Outcome::underway;
    for (int k = 0; outcome == ode::Outcome::underway && k < EnergyCheck::period; ++k) {
      pieceFrom = y;
      const double begin = state.t;
      outcome = steps.integrate(state, end, longest, 1);
      restore();
      if (!ode::hasFailed(outcome)) derivatives->follow(begin, pieceFrom, state.t, y, dynamics.lastSeries());
    }
    return outcome;
  }

  /// @throws std::domain_error if the motion has none
  Derivatives derivativesNow(const MotionDerivatives& followed) const {
    if (!followed.fault().empty()) throw std::domain_error(followed.fault());
    return followed.derivatives(state.t, y);
  }

  /// To the last good state, and on by the next method, if there is one.
  void goBack(ode::Outcome outcome) {
    state = guard.lastGood();
    restore();
    unchecked = 0;
    if (sampler) sampler->bank().dropAfter(state.t);
    if (derivatives) derivatives->goBack();
    if (watch) watch->goBack(state.t);
    if (std::exchange(switchedSince, false)) dynamics.enterState(state.t, y.data());
    if (fallback + 1 == fallbackCount) {
      return describeFailure(fault, scene, state.t, y.data(), outcome, guard.gap(), dynamics, coordinates);
    }
    dynamics.reconsider(state.t, y.data());  // results for these times belong to other states
    rescueBy(fallback + 1);
  }

  void rescueBy(std::size_t next) {
    if (fallback == 0) rescueLength = std::min(2 * rescueLength, longestRescue);
    ++rescues;
    goodChecks = 0;
    useFallback(next);
    integrator().begin();
  }

  /// True if the way ends here, at an event.
  bool isOver() const { return watch && watch->isOver(); }

  /// True if another method will be faster: the motion is stiff, or a stop ends unstable steps at once.
  bool isStuck() { return fallback + 1 < fallbackCount && meanStep.isSlow(integrator().count(), state.t); }

  /// In saved_state.cpp. The scene's tolerance and laws are those of the state.
  void saveOrRestore(Snapshot& snapshot);
  void saveOrRestoreFallbacks(Snapshot& snapshot);

  void readRelative() { toRelative(state.t, y.data(), q, qd); }
  /// Reads a state in chain order.
  void toRelative(double t, const double* from, std::vector<double>& toQ, std::vector<double>& toQd) {
    coordinates.toRelative(from, toQ.data());
    coordinates.toRelative(from + n, toQd.data());
    dynamics.hold(t, toQ.data(), toQd.data());
    windings.addTo(toQ);
  }
};

}  // namespace planar_chain
