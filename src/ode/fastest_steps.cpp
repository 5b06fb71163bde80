#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "ode/adaptive_steps.h"

namespace planar_chain::ode {

namespace {

/// Every now and then another method makes a few steps of the same motion, and takes over if it came clearly
/// further for what they cost. Cost is counted, not timed, so the choice is the same on every machine.
/// All steps meet the tolerance, whoever makes them, and none is made twice.
///
/// An explicit method stays well below its limit of stability, however small its errors are: near it, it
/// leaves oscillations behind, within the tolerance, that a stiff method would have to follow. Where the
/// limit is, the largest eigenvalue of J tells; it is kept up to date by power iteration. So what an explicit
/// method can come to at best is known without trying.
///
/// Between steps that follow an oscillation and steps so long that they damp it away may lie many that fit
/// neither. An implicit method that sees what it damps is therefore tried with a leap, even against itself.
class FastestSteps : public Integrator {
 public:
  FastestSteps(std::vector<std::unique_ptr<Stepper>> steppers, const Tolerance& tolerance,
               std::shared_ptr<Surroundings> surroundings)
      : surroundings_(std::move(surroundings)) {
    for (auto& stepper : steppers) {
      methods_.push_back(std::make_unique<AdaptiveSteps>(std::move(stepper), tolerance, surroundings_));
    }
  }

  const char* name() const override { return methods_[inUse_]->name(); }

  Outcome advance(State& state, double end, double longestStep) override {
    if (!started_) start(state, end);
    for (;;) {
      const double before = state.t;
      lastTried_ = &running();
      const AdaptiveSteps::Attempt result =
          lastTried_->attempt(state, end, std::min(longestStep, steadyStep(*lastTried_)));
      const double cost = lastTried_->cost();
      run_.cost += cost;
      run_.progress += state.t - before;
      (onTrial_ ? onTrials_ : onIncumbents_) += cost;
      if (result == AdaptiveSteps::Attempt::accepted) {
        ++count_.accepted;
        ++run_.steps;
        failures_ = 0;
        count_.lastError = lastTried_->count().lastError;
      } else if (result == AdaptiveSteps::Attempt::rejected) {
        ++count_.rejected;
      } else {
        if (tryTheNext()) continue;
        return result == AdaptiveSteps::Attempt::tooSmall ? Outcome::stepTooSmall : Outcome::notFinite;
      }
      compare();
      if (result == AdaptiveSteps::Attempt::accepted) {
        return state.t < end ? Outcome::underway : Outcome::arrived;
      }
    }
  }

  bool stepTo(State& state, double t) override { return lastTried_->stepTo(state, t); }

  void restart() override {
    for (auto& method : methods_) method->restart();
  }
  void begin() override {
    for (auto& method : methods_) method->begin();
    started_ = onTrial_ = false;
    patience_ = leastPatience;
    failures_ = 0;
    run_ = {};
    onTrials_ = onIncumbents_ = 0;
  }
  const StepCount& count() const override { return count_; }

 private:
  static constexpr int leastPatience = 25;  // steps between trials, doubled while the incumbent wins,
  static constexpr int fewerTrials = 4;     // or more of that where it wins clearly
  static constexpr int mostPatience = 1600;
  static constexpr int judged = 3;         // steps after which a trial is looked at
  static constexpr double clearly = 1.15;  // how much faster a challenger must be to win,
  static constexpr double hopeful = 1.3;   // and how much faster than before to be given more time
  static constexpr double hopeless = 0.7;  // of the incumbent's speed, for the step an explicit one proposes
  static constexpr double farEnough = 0.75;       // of the limit of stability
  static constexpr double clearlyNotStiff = 0.1;  // of those, for a start with an explicit method
  static constexpr double mostTrialCost = 600;    // evaluations
  static constexpr double tuition = 0.2;          // of what incumbents cost, for trials that are a gamble
  static constexpr double farthestLeap = 1000;    // times the incumbent's step

  /// What a method came forward by, and at what cost.
  struct Run {
    double progress = 0, cost = 0;
    int steps = 0;
    double speed() const { return cost > 0 ? progress / cost : 0; }
  };

  AdaptiveSteps& running() { return *methods_[onTrial_ ? challenger_ : inUse_]; }
  bool isExplicit(std::size_t method) const { return std::isfinite(methods_[method]->stabilityLimit()); }

  /// The longest step that is well within the limit of stability.
  double steadyStep(const AdaptiveSteps& method) const {
    const double eigenvalue = surroundings_->largestEigenvalue();
    return eigenvalue > 0 ? farEnough * method.stabilityLimit() / eigenvalue
                          : std::numeric_limits<double>::infinity();
  }

  void compare() {
    if (onTrial_) {
      if (run_.steps >= judged || run_.cost > trialCostLeft_) judgeTrial();
    } else if (run_.steps >= patience_) {
      startTrial();
    }
  }

  /// An explicit method where its first step is far from the limit, the stiff one elsewhere.
  void start(const State& state, double end) {
    surroundings_->look(state.t, state.y);
    inUse_ = 0;
    while (inUse_ < methods_.size() && !isExplicit(inUse_)) ++inUse_;
    if (inUse_ == methods_.size() ||
        methods_[inUse_]->propose(state, end - state.t) >= clearlyNotStiff * steadyStep(*methods_[inUse_])) {
      inUse_ = 0;
    }
    challenger_ = inUse_;
    started_ = true;
  }

  /// Whether a trial of this method makes sense, against the incumbent's speed.
  bool isWorthATrial(std::size_t method) const {
    if (isExplicit(method)) {
      return method != inUse_ &&
             steadyStep(*methods_[method]) > clearly * incumbentSpeed_ * methods_[method]->cost();
    }
    if (method == inUse_ && !methods_[method]->seesWhatItDamps()) return false;
    // Far from its limit an explicit one follows what makes its steps short, and the others would have to.
    if (isExplicit(inUse_) && incumbentStep_ < clearlyNotStiff * steadyStep(*methods_[inUse_])) return false;
    const bool isGamble = method == inUse_ || isExplicit(inUse_);
    return !isGamble || onTrials_ + judged * methods_[method]->cost() <= tuition * onIncumbents_;
  }

  void startTrial() {
    incumbentSpeed_ = run_.speed();
    incumbentStep_ = methods_[inUse_]->proposal();
    trialCostLeft_ = std::min(run_.cost, mostTrialCost);
    run_ = {};
    for (std::size_t k = 1; k <= methods_.size(); ++k) {
      const std::size_t next = (challenger_ + k) % methods_.size();
      if (!isWorthATrial(next)) continue;
      challenger_ = next;
      lastLook_ = 0;
      const double own = methods_[next]->proposal();
      methods_[next]->resume(methods_[next]->seesWhatItDamps() ? std::max(own, nextLeap() * incumbentStep_)
                             : own > 0                         ? own
                                                               : incumbentStep_);
      onTrial_ = true;
      return;
    }
  }

  /// 10, 100, 1000, 10 …
  double nextLeap() { return leap_ = leap_ < farthestLeap ? 10 * leap_ : 10; }

  /// After some steps: it wins, or is getting faster, or is not worth more. A stiff method takes long to find
  /// its step where it must first damp what an explicit one has left oscillating.
  void judgeTrial() {
    const double speed = run_.speed();
    const AdaptiveSteps& challenger = *methods_[challenger_];
    // An explicit method has its step by now, though some tries were lost on the way there.
    const bool isHopeless =
        isExplicit(challenger_) && challenger.proposal() < hopeless * incumbentSpeed_ * challenger.cost();
    trialCostLeft_ -= run_.cost;
    if (speed > clearly * incumbentSpeed_) {
      inUse_ = challenger_;
      patience_ = std::max(patience_ / 2, leastPatience);
      onTrial_ = false;
    } else if (isHopeless || trialCostLeft_ <= 0 || speed < hopeful * lastLook_) {
      methods_[inUse_]->resume(incumbentStep_);
      patience_ = std::min((isHopeless ? fewerTrials : 2) * patience_, mostPatience);
      onTrial_ = false;
    }
    lastLook_ = speed;
    run_ = {};
  }

  /// The method in use can go no further; false when none can.
  bool tryTheNext() {
    if (++failures_ >= static_cast<int>(methods_.size())) return false;
    const std::size_t failed = onTrial_ ? challenger_ : inUse_;
    inUse_ = (failed + 1) % methods_.size();
    methods_[inUse_]->restart();
    onTrial_ = false;
    run_ = {};
    return true;
  }

  std::shared_ptr<Surroundings> surroundings_;
  std::vector<std::unique_ptr<AdaptiveSteps>> methods_;
  std::size_t inUse_ = 0, challenger_ = 0;
  AdaptiveSteps* lastTried_ = nullptr;
  bool started_ = false, onTrial_ = false;
  int patience_ = leastPatience, failures_ = 0;
  double incumbentSpeed_ = 0, incumbentStep_ = 0, lastLook_ = 0, trialCostLeft_ = 0;
  double leap_ = 1;
  double onTrials_ = 0, onIncumbents_ = 0;  ///< cost of all
  Run run_;
  StepCount count_;
};

}  // namespace

std::unique_ptr<Integrator> fastestSteps(std::vector<std::unique_ptr<Stepper>> steppers, Tolerance tolerance,
                                         std::shared_ptr<Surroundings> surroundings) {
  return std::make_unique<FastestSteps>(std::move(steppers), tolerance, std::move(surroundings));
}

}  // namespace planar_chain::ode
