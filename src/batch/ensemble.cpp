#include "batch/ensemble.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <utility>

#include "effects/effect_kind.h"
#include "effects/motors.h"
#include "lanes/lane_order.h"
#include "ode/local_stiffness.h"
#include "ode/taylor.h"
#include "run/fallbacks.h"
#include "run/step_budget.h"
#include "run/windings.h"

namespace planar_chain {

namespace {

/// False for prismatic joints, and if a kind refuses the scene: a Simulation then gives the reason.
bool allRunInLanes(const Scene& scene) {
  const auto runs = [&](const EffectKind* kind) { return kind->runsInLanes(scene); };
  try {
    return !scene.chain.coordinates().anyIsPrismatic() &&
           std::all_of(effectKinds().begin(), effectKinds().end(), runs);
  } catch (const std::exception&) {
    return false;
  }
}

/// True if a commanded torque acts as it is, but for its limit.
bool actsAtOnce(const Joint& joint) {
  return !changesCommands(joint);
}

bool areSmall(const std::vector<double>& values, double most) {
  return std::all_of(values.begin(), values.end(), [most](double value) { return std::abs(value) <= most; });
}

simd::StepControl controlOf(const IntegratorSettings& settings) {
  using ode::Allowance;
  auto tail = ode::Taylor::shares;
  for (double& factor : tail) factor *= ode::Taylor::caution;
  return {Allowance::share * settings.tolerance,
          std::numeric_limits<double>::epsilon(),
          Allowance::shortestCounted,
          Allowance::share * settings.rateTolerance.value_or(settings.tolerance),
          settings.rateTolerance ? 1 : ode::LocalStiffness::leastTurningTime(settings.tolerance),
          largestCounted,
          Allowance::slowUnits,
          tail};
}

}  // namespace

const simd::Kernel* Ensemble::kernelFor(const Scene& scene, int mostLanes) {
  if (scene.chain.size() > simd::ShortChains::most) return nullptr;
  for (const simd::Kernel* kernel : simd::kernels({scene.integrator.plainKernel})) {
    if (mostLanes == 0 || kernel->lanes <= mostLanes) return kernel;
  }
  return nullptr;
}

Ensemble::Ensemble(const Scene& like, Runs& runs, const simd::Kernel& kernel)
    : runs_(runs),
      settings_(like.integrator),
      mostSteps_(runs.options.mostSteps ? *runs.options.mostSteps
                                        : StepBudget::usual(settings_, runs.duration())),
      kernel_(kernel),
      run_(kernel_.ensemble[std::min(n_, 3) - 1]),
      order_(ode::Taylor::orderFor(settings_.tolerance)),
      rule_(ode::Taylor::gaussRule(order_ / 3)),
      control_(controlOf(settings_)),
      series_(n_, order_, kernel_.lanes),
      lanes_(static_cast<std::size_t>(kernel_.lanes)),
      state_(2 * index(n_)),
      steady_(place(n_, 0)),
      limits_(steady_) {
  const auto make = [this](CacheLines& array, int numbers) { array.resize(place(numbers, 0)); };
  make(ground_, 2);
  make(joints_, simd::EnsembleArrays::jointQuantities * n_);
  make(N_, n_);
  make(c_, 2 * n_ * (order_ + 1));
  for (CacheLines* array : {&carry_, &states_}) make(*array, 2 * n_);
  for (CacheLines* array : {&h_, &ahead_, &within_, &power_, &turning_}) make(*array, 1);
  make(direction_, 2 * n_);
  make(scratch_, 6 * n_);
}

bool Ensemble::takes(const Scene& scene) const {
  const IntegratorSettings& settings = scene.integrator;
  return n_ <= simd::ShortChains::most && (settings.method == "auto" || settings.method == "taylor") &&
         settings.tolerance == settings_.tolerance && settings.rateTolerance == settings_.rateTolerance &&
         settings.plainKernel == settings_.plainKernel && scene.q.size() == index(n_) &&
         scene.qd.size() == index(n_) && areSmall(scene.q, Windings::mostAngle) &&
         areSmall(scene.qd, mostRate) && allRunInLanes(scene) &&
         (!runs_.haveTorques() ||
          std::all_of(scene.chain.joints().begin(), scene.chain.joints().end(), actsAtOnce));
}

void Ensemble::begin(std::size_t run, Scene scene) {
  std::size_t lane = 0;
  while (lanes_[lane].given) ++lane;

  for (int j = 0; j < n_; ++j) {
    const Joint& joint = scene.chain.joints()[index(j)];
    double torque = joint.stiffness * joint.restAngle;
    for (const Load& load : scene.loads) torque += load.joint == j ? load.torque : 0;
    steady_[place(j, lane)] = torque;
    limits_[place(j, lane)] =
        joint.has("effort_limit") ? joint.other("effort_limit") : std::numeric_limits<double>::infinity();
    series_.put(j, lane, scene.chain.links()[index(j)]);
    putInLane(joints_.data(), place(j, lane), lanes_.size(), {joint.stiffness, joint.damping, torque});
  }
  ground_[place(0, lane)] = -scene.chain.gravity().x;
  ground_[place(1, lane)] = -scene.chain.gravity().y;

  double theta = 0, omega = 0;
  for (int j = 0; j < n_; ++j) {
    c_[place(j, lane)] = theta += scene.q[index(j)];
    c_[place(n_ + j, lane)] = omega += scene.qd[index(j)];
    carry_[place(j, lane)] = carry_[place(n_ + j, lane)] = 0;
    for (const int i : {j, n_ + j}) direction_[place(i, lane)] = i % 2 == 0 ? 1 : -1;
  }
  constexpr double firstGuess = 1;  // s
  h_[lane] = firstGuess;
  lanes_[lane] = {Given{run, std::move(scene)}};
  lanes_[lane].balance.emplace(lanes_[lane].given->scene);
  if (runs_.haveTorques()) holdTorques(lane);
  balances(lane);
  ++inUse_;
}

void Ensemble::holdTorques(std::size_t k) {
  Lane& lane = lanes_[k];
  while (lane.held < runs_.times.size() && runs_.times[lane.held] <= lane.t) ++lane.held;
  if (lane.held == runs_.times.size()) return;
  const double* const torques = runs_.torquesOf(lane.given->run, lane.held);
  double inner = 0;
  for (int j = 0; j < n_; ++j) {
    const double limit = limits_[place(j, k)], theta = c_[place(j, k)];
    const double torque = steady_[place(j, k)] + std::clamp(torques[j], -limit, limit);
    lane.supplied += (torqueIn(j, k) - torque) * (theta - inner);
    torqueIn(j, k) = torque;
    inner = theta;
  }
}

simd::EnsembleArrays Ensemble::arrays() {
  const bool haveTorques = std::any_of(joints_.begin(), joints_.end(), [](double x) { return x != 0; });
  return {series_.arrays(), order_,
          ground_.data(),   haveTorques ? joints_.data() : nullptr,
          N_.data(),        c_.data(),
          carry_.data(),    h_.data(),
          turning_.data(),  direction_.data(),
          scratch_.data()};
}

std::vector<Ensemble::Given> Ensemble::step() {
  const simd::EnsembleArrays all = arrays();
  findTurningTimes(all);
  run_.find(all, control_);

  std::vector<Given> hopeless;
  const auto leave = [this](Lane& lane) {
    --inUse_;
    Given given = std::move(*lane.given);
    lane.given.reset();
    return given;
  };
  for (std::size_t k = 0; k < lanes_.size(); ++k) {
    if (!lanes_[k].given) continue;
    lanes_[k].end = lanes_[k].t + h_[k];
    if (runs_.haveTorques() && lanes_[k].held < runs_.times.size())
      lanes_[k].end = std::min(lanes_[k].end, runs_.times[lanes_[k].held]);
    const bool isUnchecked = lanes_[k].unchecked == EnergyCheck::period;
    if (isHopeless(k) || (isUnchecked && !balances(k))) hopeless.push_back(leave(lanes_[k]));
  }
  writeStates();

  for (std::size_t k = 0; k < lanes_.size(); ++k) {
    Lane& lane = lanes_[k];
    ahead_[k] = 0;
    if (!lane.given) continue;
    ++lane.steps;
    ++lane.unchecked;
    if (lane.next == runs_.times.size() || runs_.cancelled) {
      const bool isDone = lane.next == runs_.times.size();
      if (isDone && !balances(k)) {
        hopeless.push_back(leave(lane));
        continue;
      }
      const std::size_t run = leave(lane).run;
      runs_.result.runs[run].steps = lane.steps;
      runs_.end(run, isDone ? RunOutcome::done : RunOutcome::cancelled);
    } else {
      ahead_[k] = lane.end - lane.t;
      lane.t = lane.end;
    }
  }
  if (all.joints) dissipate(all);
  run_.take(all, ahead_.data());
  for (std::size_t k = 0; runs_.haveTorques() && k < lanes_.size(); ++k) {
    if (lanes_[k].given && lanes_[k].held < lanes_[k].next) holdTorques(k);
  }
  return hopeless;
}

bool Ensemble::balances(std::size_t k) {
  Lane& lane = lanes_[k];
  const Scene& scene = lane.given->scene;
  double* const y = state_.data();
  for (int i = 0; i < 2 * n_; ++i) y[i] = c_[place(i, k)];
  const Energy energy = energyOf(scene.chain, y, y + n_);
  Eigen::Vector2d works{lane.supplied, lane.dissipated};
  for (const Load& load : scene.loads) works[0] += load.torque * relative(y, load.joint);
  for (int j = 0; runs_.haveTorques() && j < n_; ++j)
    works[0] += (torqueIn(j, k) - steady_[place(j, k)]) * relative(y, j);
  if (lane.steps == 0) lane.balance->begin(lane.t, energy, works);
  return lane.balance->accept(lane.t, y, energy, works, std::exchange(lane.unchecked, 0));
}

void Ensemble::dissipate(const simd::EnsembleArrays& all) {
  for (Eigen::Index i = 0; i < rule_.rows(); ++i) {
    for (std::size_t k = 0; k < lanes_.size(); ++k) within_[k] = rule_(i, 0) * ahead_[k];
    run_.dissipation(all, within_.data(), states_.data(), power_.data());
    for (std::size_t k = 0; k < lanes_.size(); ++k) {
      if (lanes_[k].given) lanes_[k].dissipated += rule_(i, 1) * ahead_[k] * power_[k];
    }
  }
}

/// At the first of every LocalStiffness::period steps.
void Ensemble::findTurningTimes(const simd::EnsembleArrays& all) {
  bool isAnyDue = false;
  for (std::size_t k = 0; k < lanes_.size(); ++k) {
    const bool isDue = lanes_[k].given && lanes_[k].steps % ode::LocalStiffness::period == 0;
    ahead_[k] = isDue ? 1 : 0;
    isAnyDue = isAnyDue || isDue;
  }
  if (isAnyDue) run_.findTurning(all, control_, ahead_.data());
}

/// All that are due within the step.
void Ensemble::writeStates() {
  for (;;) {
    bool isAnyDue = false;
    for (std::size_t k = 0; k < lanes_.size(); ++k) {
      const Lane& lane = lanes_[k];
      const bool isDue = lane.given && lane.next < runs_.times.size() && runs_.times[lane.next] <= lane.end;
      ahead_[k] = isDue ? runs_.times[lane.next] - lane.t : -1;
      isAnyDue = isAnyDue || isDue;
    }
    if (!isAnyDue) return;
    run_.evaluate(arrays(), ahead_.data(), states_.data());
    for (std::size_t k = 0; k < lanes_.size(); ++k) {
      if (ahead_[k] < 0) continue;
      double* state = runs_.stateOf(lanes_[k].given->run, lanes_[k].next++);
      for (int i = 0; i < 2 * n_; ++i) state[i] = states_[place(i, k)];
      toRelative(state, n_, state);
      toRelative(state + n_, n_, state + n_);
    }
  }
}

bool Ensemble::isHopeless(std::size_t lane) {
  // Long enough for a start from rest. A run whose steps turn the links less than that on average is bound by
  // stability: Simulation has stiff methods, the lanes have none. Less keeps stiff runs in lanes, where they
  // cost most; more gives up runs at fine tolerances.
  constexpr int judged = 200;           // steps
  constexpr double leastTurned = 0.01;  // rad a step
  Lane& of = lanes_[lane];
  const double h = h_[lane];
  if (of.steps >= mostSteps_) return true;
  if (!(h > 4 * std::numeric_limits<double>::epsilon() * std::max(1.0, of.t))) return true;

  double rate = 0, acceleration = 0, theta = 0;
  for (int j = 0; j < n_; ++j) {
    const double next = c_[place(j, lane)];
    if (!(std::abs(next - theta) <= Windings::mostAngle)) return true;
    theta = next;
    rate = std::max(rate, std::abs(c_[place(n_ + j, lane)]));
    acceleration = std::max(acceleration, std::abs(c_[place(3 * n_ + j, lane)]));
  }
  of.turned += h * (rate + std::sqrt(acceleration));
  return of.steps >= judged && of.turned < leastTurned * static_cast<double>(of.steps);
}

}  // namespace planar_chain
