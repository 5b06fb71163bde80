#include <algorithm>
#include <utility>

#include "planar_chain/ode/adaptive_steps.h"

namespace planar_chain::ode {

namespace {

/// Every now and then another method makes a few steps of the same motion, and takes over if it came clearly
/// further for what they cost. Cost is counted, not timed, so the choice is the same on every machine.
/// All steps meet the tolerance, whoever makes them, and none is made twice.
///
/// An explicit method may not run where its steps come near its limit of stability, however fast it is: there
/// it leaves oscillations behind, within the tolerance, that a stiff method would have to follow. Where that
/// is, the largest eigenvalue of J tells; it is kept up to date by power iteration.
class FastestSteps : public Integrator {
 public:
  FastestSteps(std::vector<std::unique_ptr<Stepper>> steppers, const Tolerance& tolerance)
      : surroundings_(std::make_shared<Surroundings>(steppers.front()->system())) {
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
      const AdaptiveSteps::Attempt result = lastTried_->attempt(state, end, longestStep);
      run_.cost += lastTried_->cost();
      run_.progress += state.t - before;
      if (result == AdaptiveSteps::Attempt::accepted) {
        ++count_.accepted;
        ++run_.steps;
        count_.lastError = lastTried_->count().lastError;
      } else if (result == AdaptiveSteps::Attempt::rejected) {
        ++count_.rejected;
      } else {
        if (tryTheNext()) continue;
        return result == AdaptiveSteps::Attempt::tooSmall ? Outcome::stepTooSmall : Outcome::notFinite;
      }
      failures_ = 0;
      compare(state);
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
    run_ = {};
  }
  const StepCount& count() const override { return count_; }

 private:
  static constexpr int leastPatience = 25;  // steps between trials, doubled while the incumbent wins
  static constexpr int mostPatience = 1600;
  static constexpr int judged = 3;              // steps after which a trial is looked at
  static constexpr double clearly = 1.15;       // how much faster a challenger must be to win,
  static constexpr double hopeful = 1.3;        // and how much faster than before to be given more time
  static constexpr double farEnough = 0.75;     // of the limit of stability
  static constexpr double mostTrialCost = 600;  // evaluations

  /// What a method came forward by, and at what cost.
  struct Run {
    double progress = 0, cost = 0;
    int steps = 0;
    double speed() const { return cost > 0 ? progress / cost : 0; }
    double meanStep() const { return steps > 0 ? progress / steps : 0; }
  };

  AdaptiveSteps& running() { return *methods_[onTrial_ ? challenger_ : inUse_]; }

  void compare(const State& state) {
    if (onTrial_) {
      if (run_.steps >= judged || run_.cost > trialCostLeft_) judgeTrial(state);
    } else if (run_.steps >= patience_) {
      startTrial(state);
    }
  }

  /// An explicit method where its first step is far from the limit, the stiff one elsewhere.
  void start(const State& state, double end) {
    surroundings_->look(state.t, state.y);
    inUse_ = methods_.size() > 1 && maySteadily(1, methods_[1]->propose(state, end - state.t)) ? 1 : 0;
    started_ = true;
  }

  /// May this method run with steps of h?
  bool maySteadily(std::size_t method, double h) const {
    return h * surroundings_->largestEigenvalue() < farEnough * methods_[method]->stabilityLimit();
  }

  void startTrial(const State& state) {
    surroundings_->look(state.t, state.y);
    if (!maySteadily(inUse_, run_.meanStep())) {
      methods_.front()->resume(methods_[inUse_]->proposal());
      inUse_ = 0;
      patience_ = leastPatience;
      run_ = {};
      return;
    }
    incumbentSpeed_ = run_.speed();
    lastLook_ = 0;
    trialCostLeft_ = std::min(run_.cost, mostTrialCost);
    challenger_ = (challenger_ + 1) % methods_.size();
    if (challenger_ == inUse_) challenger_ = (challenger_ + 1) % methods_.size();
    const double own = methods_[challenger_]->proposal();
    methods_[challenger_]->resume(own > 0 ? own : methods_[inUse_]->proposal());
    onTrial_ = true;
    run_ = {};
  }

  /// After some steps: it wins, or is getting faster, or is not worth more. A stiff method takes long to find
  /// its step where it must first damp what an explicit one has left oscillating.
  void judgeTrial(const State& state) {
    const double speed = run_.speed();
    trialCostLeft_ -= run_.cost;
    if (speed > clearly * incumbentSpeed_) {
      const double h = run_.meanStep();
      surroundings_->look(state.t, state.y);
      endTrial(maySteadily(challenger_, h));
    } else if (trialCostLeft_ <= 0 || speed < hopeful * lastLook_) {
      endTrial(false);
    }
    lastLook_ = speed;
    run_ = {};
  }

  void endTrial(bool won) {
    if (won) {
      inUse_ = challenger_;
      patience_ = std::max(patience_ / 2, leastPatience);
    } else {
      methods_[inUse_]->resume(methods_[inUse_]->proposal());
      patience_ = std::min(2 * patience_, mostPatience);
    }
    onTrial_ = false;
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
  double incumbentSpeed_ = 0, lastLook_ = 0, trialCostLeft_ = 0;
  Run run_;
  StepCount count_;
};

}  // namespace

std::unique_ptr<Integrator> fastestSteps(std::vector<std::unique_ptr<Stepper>> steppers,
                                         Tolerance tolerance) {
  return std::make_unique<FastestSteps>(std::move(steppers), tolerance);
}

}  // namespace planar_chain::ode
