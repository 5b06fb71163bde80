#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "ode/integrator.h"
#include "ode/local_stiffness.h"
#include "simd/elementary.h"

namespace planar_chain::ode {

namespace {

// ---- One method ------------------------------------------------------------------------------

constexpr double safety = 0.9;
constexpr double sure = 0.98;        // safety if the error is foreseen
constexpr double nearlyWhole = 0.9;  // of a step: its error is nearly that of the whole one
constexpr double mostBeta = 0.04;    // weight of the last error in the PI control
constexpr double smallestFactor = 0.2;
constexpr double largestFactor = 10;
constexpr double smallestLog = -13.287712;  // log2 of the smallest error that the PI control remembers, 1e-4
constexpr int mostJumps = 10;
constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// The end of the next step of about h. Makes two equal steps rather than a tiny last one.
double landing(double t, double end, double h) {
  const double left = end - t;
  if (h >= left * (1 - 1e-9)) return end;
  return h > left / 2 ? t + left / 2 : t + h;
}

/// Steps chosen so that the error estimate of each meets the tolerance: PI control (Hairer, Wanner, Solving
/// ODEs II, section IV.2), the first step as in Hairer, Nørsett, Wanner, Solving ODEs I, section II.4.
class AdaptiveSteps : public Integrator {
 public:
  AdaptiveSteps(std::unique_ptr<Stepper> stepper, Tolerance tolerance,
                std::shared_ptr<LocalStiffness> stiffness)
      : stepper_(std::move(stepper)), tolerance_(std::move(tolerance)), stiffness_(std::move(stiffness)) {
    if (facts().errorOrder == 0) {
      throw std::invalid_argument(std::string(facts().name) + " has no error estimate to adapt to");
    }
  }

  const char* name() const override { return facts().name; }
  Outcome advance(State& state, double end, double longestStep) override {
    for (;;) {
      if (const std::optional<Outcome> outcome = attempt(state, end, longestStep)) return *outcome;
    }
  }
  bool stepTo(State& state, double t) override { return stepper_->takeAgain(state, t); }
  void restartAfter(Change change) override {
    resume(change == Change::bend ? h_ : 0);
    jumps_ = 0;
    if (change > Change::jump) stiffness_->forget();
  }
  StepCount count() const override { return count_; }

  /// One attempt of a step towards `end`. Returns nothing if it is rejected, which shortens the next.
  std::optional<Outcome> attempt(State& state, double end, double longestStep) {
    // Choose the step.
    stiffness_->maybeUpdate(state.t, state.y);
    if (h_ <= 0) propose(state, end - state.t);
    const bool isForeseen = stepper_->foresees(state.t, h_, state.y);
    const double lengthened = isForeseen ? foreseen(errorNorm(state.y, h_)) : 1;
    h_ *= lengthened;
    double next = landing(state.t, end, std::min(h_, longestStep));

    // A motion that settles within the spacing of the numbers at t, or at 1 s, is a jump. A method that damps
    // it and whose error does not see it may take up to ten steps without error control.
    const double shortest = 4 * epsilon * std::max(1.0, std::abs(state.t));
    bool isJump = false;
    if (next < end && !(next - state.t > shortest)) {
      if (!finite_) return Outcome::notFinite;
      if (isExplicit() || facts().errorSeesStiffModes || jumps_ == mostJumps) return Outcome::stepTooSmall;
      isJump = true;
      ++jumps_;
      next = std::min(state.t + 2 * shortest, end);
    }
    const double h = next - state.t;

    // Attempt it.
    stepper_->step(state.t, h, state.y);
    const double most = aimed_ * std::max(lengthened, 1 / lengthened);
    const bool isAsForeseen = isForeseen && most <= 1 && h > nearlyWhole * h_;
    const double error = isAsForeseen ? most : errorNorm(state.y, h);
    const bool mayPass = error <= 1 || isJump;
    const bool taken = mayPass && std::isfinite(error) && stepper_->take(state, next);
    finite_ = std::isfinite(error) && (taken || !mayPass);
    if (taken) {
      // Choose the next step from this one, but at most ten times the one proposed before: a step that was
      // cut short says little about far longer ones.
      stepper_->accept();
      if (!isForeseen) {
        const double log = simd::log2(std::max(error, 1e-30));
        const double wanted = h * std::max(growth(log), isJump ? 1 : smallestFactor);
        h_ = std::min(wanted, justRejected_ ? h : largestFactor * h_);
        lastLog_ = std::max(log, smallestLog);
      }
      justRejected_ = false;
      count_.lastError = error;
      ++count_.accepted;
      return state.t < end ? Outcome::underway : Outcome::arrived;
    }

    // Reject it and shorten the next one.
    const double factor = finite_ ? safety * simd::power(error, -exponent_) : 0.1;
    h_ = h * std::min(std::max(factor, finite_ ? smallestFactor : 0.0), 0.9);
    justRejected_ = true;
    ++count_.rejected;
    return std::nullopt;
  }
  /// Call this when another integrator has moved the state. The next step is about h long.
  void resume(double h) {
    stepper_->forget();
    h_ = h;
    lastLog_ = smallestLog;
    justRejected_ = false;
    finite_ = true;
  }
  /// The length of the next step, unless `end` comes before. 0: unknown.
  double proposal() const { return h_; }
  /// The cost of an attempt, in evaluations of f.
  double cost() const { return stepper_->cost(); }
  const MethodFacts& facts() const { return stepper_->facts(); }
  bool isExplicit() const { return std::isfinite(facts().stabilityLimit); }
  /// Computes a first step, which becomes proposal(), and returns it: a step with a small error of the
  /// explicit Euler method, h² |ÿ| about 1 % of the scale, then adapted to the order.
  double propose(const State& state, double left) {
    const Vector& slope = stepper_->derivative(state.t, state.y);
    const auto norm = [&](auto component) {
      double worst = 0;
      for (Eigen::Index i = 0; i < tolerance_.ceiling.size(); ++i) {
        const double scale = tolerance_.value * tolerance_.size(state.y, i);
        worst = std::max(worst, std::abs(component(i)) / scale);
      }
      return worst;
    };
    const double d0 = norm([&](Eigen::Index i) { return tolerance_.size(state.y, i) - 1; });
    const double d1 = norm([&](Eigen::Index i) { return slope[i]; });
    const double h0 = std::min(left, d0 > 1e-5 && d1 > 1e-5 ? 0.01 * d0 / d1 : 1e-6);
    trial_ = state.y + h0 * slope;
    stepper_->system().slope(state.t + h0, trial_.data(), trialDerivative_.data());
    const double d2 = norm([&](Eigen::Index i) { return (trialDerivative_[i] - slope[i]) / h0; });
    const double most = std::max(d1, d2);
    const double h1 = most > 1e-15 ? simd::power(0.01 / most, exponent_) : std::max(1e-6, 1e-3 * h0);
    return h_ = std::isfinite(h1) ? std::min({100 * h0, h1, left}) : h0;
  }

 private:
  /// safety × error^−(exponent − ¾ β) × lastError^β, from log2 of the error.
  double growth(double log) const {
    return safety * simd::exp2(beta_ * lastLog_ - (exponent_ - 0.75 * beta_) * log);
  }

  /// The factor by which a step may grow whose error is known before the attempt.
  double foreseen(double error) const {
    if (!std::isfinite(error)) return smallestFactor;
    const double factor = sure * simd::power(error, -exponent_);
    return std::min(std::max(factor, smallestFactor), largestFactor);
  }

  /// The largest ratio of a component's error to its Allowance for a step of h. NaN if one is not finite.
  double errorNorm(const Vector& y, double h) const {
    const Allowance allowance(tolerance_, *stiffness_, h);
    const Eigen::Index all = tolerance_.ceiling.size(), angles = std::min(tolerance_.firstRate, all);
    const auto largest = [&](double most, Eigen::Index from, Eigen::Index to) {
      return vectors_.largestRatio({stepper_->error().data() + from, y.data() + from,
                                    tolerance_.ceiling.data() + from, stiffness_->noise().data() + from},
                                   most, allowance.perNoise, to - from);
    };
    const double ofAngles = largest(allowance.most, 0, angles);
    const double ofRates = largest(allowance.mostOfRates, angles, all);
    return ofAngles > ofRates || std::isnan(ofAngles) ? ofAngles : ofRates;
  }

  std::unique_ptr<Stepper> stepper_;
  Tolerance tolerance_;
  std::shared_ptr<LocalStiffness> stiffness_;
  const simd::VectorKernel& vectors_ = simd::vectors();
  const double exponent_ = 1.0 / facts().errorOrder, beta_ = std::min(mostBeta, 7 * mostBeta * exponent_);
  const double aimed_ = simd::power(sure, facts().errorOrder);
  double lastLog_ = smallestLog;  ///< of the last step's error, to base 2
  double h_ = 0;
  bool justRejected_ = false;
  bool finite_ = true;
  int jumps_ = 0;  ///< made since the last restart
  StepCount count_;
  Vector trial_ = stepper_->increment(), trialDerivative_ = trial_;
};

// ---- The fastest of several methods ----------------------------------------------------------

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
/// itself.
class FastestSteps : public Integrator {
 public:
  FastestSteps(std::vector<std::unique_ptr<Stepper>> steppers, const Tolerance& tolerance,
               std::shared_ptr<LocalStiffness> stiffness)
      : stiffness_(std::move(stiffness)) {
    for (auto& stepper : steppers) methods_.emplace_back(std::move(stepper), tolerance, stiffness_);
  }

  const char* name() const override { return methods_[inUse_].name(); }

  Outcome advance(State& state, double end, double longestStep) override {
    if (!started_) start(state, end);
    for (;;) {
      // Start or judge a trial.
      if (onTrial_ && (run_.steps >= judged || run_.cost > trialCostLeft_)) {
        judgeTrial();
      } else if (!onTrial_ && run_.steps >= patience_) {
        startTrial();
      }

      // Attempt a step.
      const double before = state.t;
      lastTried_ = &running();
      const std::optional<Outcome> outcome =
          lastTried_->attempt(state, end, std::min(longestStep, steadyStep(*lastTried_)));

      // Count it.
      const double cost = lastTried_->cost();
      run_.cost += cost;
      run_.progress += state.t - before;
      (onTrial_ ? onTrials_ : onIncumbents_) += cost;
      if (!outcome) {
        ++count_.rejected;
      } else if (hasFailed(*outcome)) {
        if (tryTheNext()) continue;
        return *outcome;
      } else {
        ++count_.accepted;
        ++run_.steps;
        failures_ = 0;
        count_.lastError = lastTried_->count().lastError;
      }
      end_ = state.t;
      if (outcome) return *outcome;
    }
  }

  bool stepTo(State& state, double t) override {
    const bool isFinite = lastTried_->stepTo(state, t);
    run_.cost += lastTried_->cost();
    run_.progress += t - std::exchange(end_, t);
    return isFinite;
  }

  void restartAfter(Change change) override {
    for (AdaptiveSteps& method : methods_) method.restartAfter(change);
    if (change != Change::all) return;
    started_ = onTrial_ = false;
    patience_ = leastPatience;
    failures_ = 0;
    run_ = {};
    onTrials_ = onIncumbents_ = 0;
  }
  StepCount count() const override { return count_; }

 private:
  static constexpr int leastPatience = 25;  // steps between trials; doubled when the incumbent wins,
  static constexpr int fewerTrials = 4;     // or multiplied by this when it wins clearly
  static constexpr int mostPatience = 1600;
  static constexpr int judged = 3;                // steps of a trial before each decision
  static constexpr double clearly = 1.15;         // the challenger's speed over the incumbent's to win
  static constexpr double hopeful = 1.3;          // its speed over its last one to go on
  static constexpr double hopeless = 0.7;         // an explicit challenger with less than this loses
  static constexpr double farEnough = 0.75;       // of the limit of stability
  static constexpr double clearlyNotStiff = 0.1;  // of that step, for a start with an explicit method
  static constexpr double mostTrialCost = 600;    // evaluations
  static constexpr double trialBudget = 0.2;      // of the incumbents' cost, for uncertain trials
  static constexpr double farthestLeap = 1000;    // times the incumbent's step

  /// Progress, s, and cost of a method, in evaluations.
  struct Run {
    double progress = 0, cost = 0;
    int steps = 0;
    double speed() const { return cost > 0 ? progress / cost : 0; }
  };

  AdaptiveSteps& running() { return methods_[onTrial_ ? challenger_ : inUse_]; }
  bool isExplicit(std::size_t method) const { return methods_[method].isExplicit(); }

  /// The longest step well within the limit of stability.
  double steadyStep(const AdaptiveSteps& method) const {
    return farEnough * method.facts().stabilityLimit / stiffness_->largestEigenvalue();
  }

  /// Starts with the first explicit method if its first step is far from the limit, else with the stiff one.
  void start(const State& state, double end) {
    stiffness_->update(state.t, state.y);
    inUse_ = 0;
    while (!isExplicit(inUse_)) ++inUse_;
    AdaptiveSteps& first = methods_[inUse_];
    if (first.propose(state, end - state.t) >= clearlyNotStiff * steadyStep(first)) inUse_ = 0;
    challenger_ = inUse_;
    started_ = true;
  }

  /// True if method k may be faster than the incumbent.
  bool isWorthATrial(std::size_t k) const {
    const AdaptiveSteps& method = methods_[k];
    if (isExplicit(k)) {
      return k != inUse_ && steadyStep(method) > clearly * incumbentSpeed_ * method.cost();
    }
    if (k == inUse_ && !method.facts().errorSeesStiffModes) return false;
    // An explicit incumbent far from its limit is not limited by stiffness.
    if (isExplicit(inUse_) && incumbentStep_ < clearlyNotStiff * steadyStep(methods_[inUse_])) return false;
    const bool isUncertain = k == inUse_ || isExplicit(inUse_);
    return !isUncertain || onTrials_ + judged * method.cost() <= trialBudget * onIncumbents_;
  }

  void startTrial() {
    incumbentSpeed_ = run_.speed();
    incumbentStep_ = methods_[inUse_].proposal();
    trialCostLeft_ = std::min(run_.cost, mostTrialCost);
    run_ = {};
    for (std::size_t k = 1; k <= methods_.size(); ++k) {
      const std::size_t next = (challenger_ + k) % methods_.size();
      if (!isWorthATrial(next)) continue;
      challenger_ = next;
      lastSpeed_ = 0;
      onTrial_ = true;
      double step = running().proposal();
      if (running().facts().errorSeesStiffModes) {
        leap_ = leap_ < farthestLeap ? 10 * leap_ : 10;
        step = std::max(step, leap_ * incumbentStep_);
      }
      return running().resume(step > 0 ? step : incumbentStep_);
    }
  }

  /// The challenger wins, or goes on as it gets faster, or loses. A stiff method needs time to find its step
  /// if it must first damp the oscillations that an explicit one has left.
  void judgeTrial() {
    const double speed = run_.speed();
    const AdaptiveSteps& challenger = methods_[challenger_];
    // An explicit method has found its step by now.
    const bool isHopeless =
        isExplicit(challenger_) && challenger.proposal() < hopeless * incumbentSpeed_ * challenger.cost();
    trialCostLeft_ -= run_.cost;
    if (speed > clearly * incumbentSpeed_) {
      inUse_ = challenger_;
      patience_ = std::max(patience_ / 2, leastPatience);
      onTrial_ = false;
    } else if (isHopeless || trialCostLeft_ <= 0 || speed < hopeful * lastSpeed_) {
      methods_[inUse_].resume(incumbentStep_);
      patience_ = std::min((isHopeless ? fewerTrials : 2) * patience_, mostPatience);
      onTrial_ = false;
    }
    lastSpeed_ = speed;
    run_ = {};
  }

  /// Replaces a method that cannot continue. Returns false if none can.
  bool tryTheNext() {
    if (++failures_ >= static_cast<int>(methods_.size())) return false;
    const std::size_t failed = onTrial_ ? challenger_ : inUse_;
    inUse_ = (failed + 1) % methods_.size();
    methods_[inUse_].restart();
    onTrial_ = false;
    run_ = {};
    return true;
  }

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
  Run run_;
  StepCount count_;
};

}  // namespace

std::unique_ptr<Integrator> adaptiveSteps(std::unique_ptr<Stepper> stepper, Tolerance tolerance,
                                          std::shared_ptr<LocalStiffness> stiffness) {
  return std::make_unique<AdaptiveSteps>(std::move(stepper), std::move(tolerance), std::move(stiffness));
}

std::unique_ptr<Integrator> fastestSteps(std::vector<std::unique_ptr<Stepper>> steppers, Tolerance tolerance,
                                         std::shared_ptr<LocalStiffness> stiffness) {
  return std::make_unique<FastestSteps>(std::move(steppers), tolerance, std::move(stiffness));
}

}  // namespace planar_chain::ode
