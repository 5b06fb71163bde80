/// The method `auto`.

#include <algorithm>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "ode/adaptive_steps.h"

namespace planar_chain::ode {

namespace {

/// From time to time a challenger makes a few steps of the same motion. It replaces the incumbent if its
/// speed, progress over cost, is clearly higher. Cost is counted, not timed, so the choice is the same on
/// every machine. The steps of both meet the tolerance, and none is made twice.
///
/// An explicit method stays well below its limit of stability, however small its errors are: near the limit
/// it leaves oscillations within the tolerance, which a stiff method would have to follow. The limit follows
/// from the largest eigenvalue of J (local_stiffness.h). So the best speed of an explicit method is known
/// without a trial.
///
/// Some steps follow an oscillation, and some are so long that they damp it. Many lengths between fit
/// neither. So an implicit method whose error sees stiff modes starts its trial with a leap, even against
/// itself. Another implicit incumbent has mostly damped them. Against that one, in place of the shortest
/// leap, it starts with the shortest step that wins, and loses at once if that is rejected.
class FastestSteps : public Integrator {
 public:
  FastestSteps(std::vector<std::unique_ptr<Stepper>> steppers, const Tolerance& tolerance,
               std::shared_ptr<LocalStiffness> stiffness, bool jumpsOften)
      : isFine_(tolerance.isFine()),
        judged_(jumpsOften ? judgedAmongSwitches : judgedSteps),
        stiffness_(std::move(stiffness)) {
    for (auto& stepper : steppers) methods_.emplace_back(std::move(stepper), tolerance, stiffness_);
    lastTried_ = &methods_.front();
  }

  const char* name() const override { return methods_[inUse_].name(); }

  Outcome advance(State& state, double end, double longestStep) override {
    if (!started_) start(state, end);
    for (;;) {
      // Start or judge a trial.
      if (onTrial_ && (run_.steps >= judged_ || run_.cost > trialCostLeft_ || isHopeless())) {
        judgeTrial();
      } else if (!onTrial_ && ((run_.steps >= patience_ && isTypical()) || hasSlowed())) {
        startTrial();
      }

      // Attempt a step.
      const double before = state.t;
      lastTried_ = &running();
      const long long rejected = lastTried_->count().rejected;
      const std::optional<Outcome> outcome =
          lastTried_->attempt(state, end, std::min(longestStep, steadyStep(*lastTried_)));

      // Count it.
      const double cost = lastTried_->cost();
      run_.cost += cost;
      run_.progress += state.t - before;
      (onTrial_ ? onTrials_ : onIncumbents_) += cost;
      count_.rejected += lastTried_->count().rejected - rejected;
      if (outcome && hasFailed(*outcome)) {
        if (tryTheNext()) continue;
        return *outcome;
      }
      if (outcome) {
        ++count_.accepted;
        ++run_.steps;
        failures_ = 0;
        count_.lastError = lastTried_->count().lastError;
      }
      end_ = state.t;
      if (outcome) return *outcome;
    }
  }

  bool lookTo(State& state, double t) override { return lastTried_->lookTo(state, t); }
  bool stepTo(State& state, double t) override {
    const bool isFinite = lastTried_->stepTo(state, t);
    run_.cost += lastTried_->cost();
    countProgress(t);
    return isFinite;
  }
  double errorNorm(const Vector& y, double h, const Vector& error) const override {
    return lastTried_->errorNorm(y, h, error);
  }
  void endAt(State& state) override { countProgress(state.t); }

  int pieces() const override { return lastTried_->pieces(); }

  void restartAfter(Change change) override {
    for (AdaptiveSteps& method : methods_) method.restartAfter(change);
    if (change != Change::all) return;
    started_ = onTrial_ = false;
    patience_ = leastPatience;
    failures_ = 0;
    beginRun(0);
    onTrials_ = onIncumbents_ = 0;
  }
  void forgetSlope() override {
    for (AdaptiveSteps& method : methods_) method.forgetSlope();
  }
  void setTolerance(const Tolerance& tolerance) override {
    for (AdaptiveSteps& method : methods_) method.setTolerance(tolerance);
  }
  StepCount count() const override { return count_; }
  void saveOrRestore(Snapshot& snapshot) override {
    std::size_t lastTried = 0;
    for (std::size_t k = 0; k < methods_.size(); ++k) {
      methods_[k].saveOrRestore(snapshot);
      if (lastTried_ == &methods_[k]) lastTried = k;
    }
    snapshot(inUse_, challenger_, lastTried, started_, onTrial_, patience_, failures_);
    snapshot(incumbentSpeed_, incumbentStep_, lastSpeed_, trialCostLeft_, leap_, end_, onTrials_,
             onIncumbents_, usualSpeed_, run_, before_, count_);
    lastTried_ = &methods_[lastTried];
  }

 private:
  // No choice below changes what meets the tolerance, only the cost. `test/performance/knobs.py
  // src/ode/fastest_steps.cpp BUILD` runs the scenes that ship with half and with twice each value.

  /// Steps before the first trial. Fewer: short runs pay for trials. More: a wrong start is kept for longer.
  static constexpr int leastPatience = 25;
  /// The patience doubles after each trial that the incumbent wins, and grows by this factor if it wins
  /// clearly. Less: motions of one character pay for more lost trials. More: a change is noticed late.
  static constexpr int fewerTrials = 4;
  /// An explicit incumbent near its limit that gets slower than this share of its usual speed is compared at
  /// once: the motion has become stiff, as by a contact. Near 1: each variation starts trials.
  static constexpr double slow = 0.2;
  /// A trial waits until the incumbent's step is this share of its mean. Near 1: trials wait for nothing.
  /// Far below: they begin in transients, and the faster method loses.
  static constexpr double typical = 0.1;
  /// It waits no longer than for so many times the patience.
  static constexpr int latest = 2;
  /// Bounds the patience, as any motion may change. Only runs of thousands of steps reach it.
  static constexpr int mostPatience = 1600;
  /// The challenger wins if its speed exceeds the incumbent's by this factor. Near 1: methods of equal speed
  /// take turns, and each change loses the length of the step. At 2: a far faster method never wins.
  static constexpr double clearly = 1.15;
  /// A trial continues while the speed grows by this factor between decisions. A stiff method's step still
  /// grows by up to ten then; one that grows more slowly has found its length.
  static constexpr double hopeful = 1.3;
  /// A trial ends at once if the next step would be slower than this share of the incumbent's speed. Near 1:
  /// it ends for the noise in one step. Far below: lost trials run to their end.
  static constexpr double hopeless = 0.7;
  /// Explicit methods stay below this share of their limit of stability. Above 1 they leave it, and their
  /// error control rejects steps; close to 1 they leave oscillations, as explained above.
  static constexpr double farEnough = 0.75;
  /// A run starts with an explicit method if its first step is below this share of the longest steady one.
  /// First steps are short. So a larger share starts stiff scenes explicitly until the first trial.
  static constexpr double clearlyNotStiff = 0.1;
  /// The share for a method that foresees its error, of few components: its first step is as long as the next
  /// ones. Of longer chains that gains nothing.
  static constexpr Eigen::Index few = 6;
  static constexpr double foreseenNotStiff = 0.5;
  /// A run starts with a stiff method, however short its first step is, if so many steady steps fit into the
  /// one that the error alone allows. Far less: tension, whose vibrations must be followed, counts too.
  static constexpr double surelyStiff = 1000;
  /// Stiff methods are tried only if the explicit incumbent's step exceeds this share of the steady one:
  /// below, accuracy bounds the step and not stiffness, and they would lose.
  static constexpr double farFromTheLimit = 0.2;
  /// Below this share they are tried rarely: vibrations that a stiff method would damp may bound the step.
  static constexpr double nearTheLimit = 0.5;
  /// The most evaluations of one trial. Without it a stiff method on a long chain could use as many as the
  /// incumbent has in all. Half or twice as much changes little.
  static constexpr double mostTrialCost = 600;
  /// Uncertain trials together cost at most this share of the incumbents' evaluations: it bounds the loss on
  /// a motion for which no other method is ever faster.
  static constexpr double trialBudget = 0.2;
  /// The share below nearTheLimit, where trials seldom win.
  static constexpr double smallTrialBudget = 0.02;
  /// From this tolerance on, error estimates may be rounding, as in adaptive_steps.cpp.
  static constexpr double finest = 1e-10;
  /// At tolerances above this one no other method is challenged by one of high order, whose step costs
  /// several times as much: rodas5p is a stiff one, too.
  static constexpr double coarse = 1e-4;
  /// A stiff challenger that cannot leap starts with at least this share of the incumbent's step. Its own
  /// last step may be of another part of the motion, and far too short.
  static constexpr double notFar = 0.1;
  /// Leaps are 10, 100, then this many times the incumbent's step, by turns. A longer one is rejected until
  /// it is one of these.
  static constexpr double shortestLeap = 10, farthestLeap = 1000;
  /// An explicit challenger without a step of its own starts with this share of the incumbent's. A whole one
  /// is often rejected.
  static constexpr double cautious = 0.5;
  /// An explicit method of lower order than an explicit incumbent is taken to make steps of at most so many
  /// times its step. Below 1: methods whose constant of the error is small are not tried. Large: beside a
  /// series that costs less than an evaluation an order, trials are lost.
  static constexpr double farthestOfLowerOrder = 2;
  /// Steps of a trial before each decision: where switches end steps at random, a few do not suffice.
  static constexpr int judgedSteps = 3, judgedAmongSwitches = 12;

  /// Progress, s, and cost of a method, in evaluations.
  struct Run {
    double progress = 0, cost = 0;
    int steps = 0;
    double speed() const { return cost > 0 ? progress / cost : 0; }
  };

  void beginRun(double usualSpeed) {
    run_ = before_ = {};
    usualSpeed_ = usualSpeed;
  }
  void countProgress(double t) { run_.progress += t - std::exchange(end_, t); }
  AdaptiveSteps& running() { return methods_[onTrial_ ? challenger_ : inUse_]; }
  bool isExplicit(std::size_t method) const { return methods_[method].isExplicit(); }

  /// The longest step well within the limit of stability.
  double steadyStep(const AdaptiveSteps& method) const {
    return farEnough * method.facts().stabilityLimit / stiffness_->largestEigenvalue();
  }

  /// The speed of steps as long as the next one, which an explicit method has found at once. 0: unknown, as
  /// of a series that has been evaluated already.
  double foundSpeed(const AdaptiveSteps& method) const {
    const bool isKnown = run_.steps > 0 && method.cost() > 0;
    return isKnown ? std::min(method.proposal(), steadyStep(method)) / method.cost() : 0;
  }
  /// True if error estimates may be rounding (Tolerance): then one rejection says nothing, and rates
  /// count in full, so a stiff transient must be followed.
  bool mayRound() const { return methods_.front().tolerance().value <= finest; }
  /// True if a trial of method k may be a leap over vibrations that the incumbent follows.
  bool leaps(std::size_t k) const {
    return methods_[k].facts().errorSeesStiffModes &&
           (k == inUse_ || isExplicit(inUse_) || leap_ > shortestLeap || mayRound());
  }

  /// Starts with the first explicit method if its first step is far from the limit, else with the stiff one.
  void start(const State& state, double end) {
    stiffness_->maybeUpdate(state.t, state.y, methods_.front().tolerance());
    inUse_ = 0;
    while (!isExplicit(inUse_)) ++inUse_;
    AdaptiveSteps& first = methods_[inUse_];
    const double step = first.propose(state, end - state.t);
    const double foreseen = state.y.size() <= few ? first.foreseenStep(state) : 0;
    const bool mayBeStiff = foreseen > 0 ? foreseen >= foreseenNotStiff * steadyStep(first)
                                         : step >= clearlyNotStiff * steadyStep(first);
    const auto proposeBoldly = [&](AdaptiveSteps& method) {
      return method.propose(state, end - state.t, true);
    };
    if (mayBeStiff || (proposeBoldly(first) >= surelyStiff * steadyStep(first) && !mayRound())) {
      inUse_ = 0;
      proposeBoldly(methods_[inUse_]);
    }
    challenger_ = inUse_;
    started_ = true;
  }

  /// False in a transient, as behind a contact: there no method is as fast as the incumbent is on average.
  bool isTypical() const {
    return run_.steps >= latest * patience_ ||
           methods_[inUse_].proposal() * run_.steps >= typical * run_.progress;
  }

  /// Compares the speed over every leastPatience steps with the highest of the run. True if stiffness has
  /// lowered it.
  bool hasSlowed() {
    if (!isExplicit(inUse_) || run_.steps < before_.steps + leastPatience) return false;
    const Run last{run_.progress - before_.progress, run_.cost - before_.cost, leastPatience};
    before_ = run_;
    usualSpeed_ = std::max(usualSpeed_, last.speed());
    const AdaptiveSteps& method = methods_[inUse_];
    const bool isStiff = method.proposal() > nearTheLimit * steadyStep(method);
    const bool hasSlowed = isStiff && last.speed() < slow * usualSpeed_;
    if (hasSlowed) patience_ = leastPatience;
    return hasSlowed;
  }

  /// True if method k may be faster than the incumbent.
  bool isWorthATrial(std::size_t k) const {
    const AdaptiveSteps& method = methods_[k];
    if (isExplicit(k)) {
      double longest = steadyStep(method);
      if (isExplicit(inUse_) && method.facts().order < methods_[inUse_].facts().order) {
        longest = std::min(longest, farthestOfLowerOrder * incumbentStep_);
      }
      return k != inUse_ && longest > clearly * incumbentSpeed_ * method.cost();
    }
    if (k == inUse_ && !method.facts().errorSeesStiffModes) return false;
    // An explicit incumbent far from its limit is hardly limited by stiffness.
    const double share = isExplicit(inUse_) ? incumbentStep_ / steadyStep(methods_[inUse_]) : 1;
    if (share < farFromTheLimit) return false;
    const bool isUncertain = k == inUse_ || isExplicit(inUse_) || !isFine_;
    const double budget = share < nearTheLimit ? smallTrialBudget : trialBudget;
    if (k != inUse_ && method.facts().errorSeesStiffModes && method.tolerance().value > coarse) return false;
    return !isUncertain || onTrials_ + judged_ * method.cost() <= budget * onIncumbents_;
  }

  void startTrial() {
    incumbentSpeed_ = run_.speed();
    incumbentStep_ = methods_[inUse_].proposal();
    trialCostLeft_ = std::min(run_.cost, mostTrialCost);
    beginRun(incumbentSpeed_);
    for (std::size_t k = 1; k <= methods_.size(); ++k) {
      const std::size_t next = (challenger_ + k) % methods_.size();
      if (!isWorthATrial(next)) continue;
      challenger_ = next;
      lastSpeed_ = 0;
      onTrial_ = true;
      double step = running().proposal();
      if (running().facts().errorSeesStiffModes) {
        leap_ = leap_ < farthestLeap ? shortestLeap * leap_ : shortestLeap;
        step = leaps(next) ? std::max(step, leap_ * incumbentStep_)
                           : clearly * incumbentSpeed_ * running().cost();
      } else if (!isExplicit(next)) {
        step = std::max(step, notFar * incumbentStep_);
      }
      return running().resume(step > 0 ? step : cautious * incumbentStep_);
    }
  }

  /// True if the challenger's step will not grow much any more, and is too short. An explicit method finds
  /// its step at once; a leap gets shorter.
  bool isHopeless() const {
    const AdaptiveSteps& challenger = methods_[challenger_];
    const bool hasFoundItsStep =
        isExplicit(challenger_) ? run_.steps > 0 : run_.cost > 0 && challenger.facts().errorSeesStiffModes;
    return hasFoundItsStep && challenger.proposal() < hopeless * incumbentSpeed_ * challenger.cost();
  }

  /// The challenger wins, or continues as it gets faster, or loses. A stiff method needs time to find its
  /// step if it must first damp the oscillations that an explicit one has left, or if it has made a leap.
  void judgeTrial() {
    const bool isClearlySlower = isHopeless();
    const double speed = isExplicit(challenger_) && !isExplicit(inUse_)
                             ? std::max(run_.speed(), foundSpeed(methods_[challenger_]))
                             : run_.speed();
    trialCostLeft_ -= run_.cost;
    if (speed > clearly * incumbentSpeed_) {
      inUse_ = challenger_;
      usualSpeed_ = speed;
      patience_ = std::max(patience_ / 2, leastPatience);
      onTrial_ = false;
    } else if (isExplicit(challenger_) ||
               (!isExplicit(inUse_) && !methods_[challenger_].facts().errorSeesStiffModes) ||
               (isClearlySlower && !leaps(challenger_)) || trialCostLeft_ <= 0 ||
               speed < hopeful * lastSpeed_) {
      methods_[inUse_].resume(incumbentStep_);
      // One rejection of a step that would have won may be of a transient.
      const bool isSure = isClearlySlower && (isExplicit(challenger_) || leaps(challenger_));
      patience_ = std::min((isSure ? fewerTrials : 2) * patience_, mostPatience);
      onTrial_ = false;
    }
    lastSpeed_ = speed;
    beginRun(usualSpeed_);
  }

  /// Replaces a method that cannot continue. Returns false if none can.
  bool tryTheNext() {
    if (++failures_ >= static_cast<int>(methods_.size())) return false;
    const std::size_t failed = onTrial_ ? challenger_ : inUse_;
    inUse_ = (failed + 1) % methods_.size();
    methods_[inUse_].restart();
    onTrial_ = false;
    beginRun(0);
    return true;
  }

  const bool isFine_;  ///< of the tolerance: radau13 is often faster than rodas5p
  const int judged_;   ///< steps of a trial before each decision
  std::shared_ptr<LocalStiffness> stiffness_;
  std::deque<AdaptiveSteps> methods_;
  std::size_t inUse_ = 0, challenger_ = 0;
  AdaptiveSteps* lastTried_ = nullptr;
  bool started_ = false, onTrial_ = false;
  int patience_ = leastPatience, failures_ = 0;
  double incumbentSpeed_ = 0, incumbentStep_ = 0, lastSpeed_ = 0, trialCostLeft_ = 0;
  double leap_ = 1;
  double end_ = 0;                          ///< of the last step
  double onTrials_ = 0, onIncumbents_ = 0;  ///< cost of all
  double usualSpeed_ = 0;
  Run run_, before_;  ///< before_: when hasSlowed() was last computed
  StepCount count_;
};

}  // namespace

std::unique_ptr<Integrator> fastestSteps(std::vector<std::unique_ptr<Stepper>> steppers, Tolerance tolerance,
                                         std::shared_ptr<LocalStiffness> stiffness, bool jumpsOften) {
  return std::make_unique<FastestSteps>(std::move(steppers), tolerance, std::move(stiffness), jumpsOften);
}

}  // namespace planar_chain::ode
