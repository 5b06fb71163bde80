#include "ode/leaping_steps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "ode/leap.h"
#include "simd/elementary.h"

namespace planar_chain::ode {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// Square roots of margins, which fall like the distance from the pose.
constexpr double near = 0.5;    ///< leaps begin below it
constexpr double there = 1e-3;  ///< below it f is not exact enough for the beginning of a step

constexpr double mostTurned = 0.8;  ///< rad, in a leap
/// The pose is in sight if two steps agree, but for this share, on when it comes. At infinity: chains that
/// shake near a pose, and never get there, take ten times as many steps.
constexpr double steady = 0.5;
constexpr int mostTrials = 24;
/// Where the pose may be in a leap, in its length: amid two of its points.
constexpr double gaps[] = {0.061, 0.169, 0.323, 0.5, 0.677, 0.831};
constexpr double lastGap = gaps[5];
constexpr double atStart = 0.01;  ///< likewise: before the first point

class LeapingSteps : public StepsOf {
 public:
  LeapingSteps(std::unique_ptr<Integrator> steps, System& f, double most)
      : StepsOf(std::move(steps)), f_(f), most_(most), leap_(f), trial_(f.sizeInLaneOrder()) {}

  Outcome advance(State& state, double end, double longestStep) override {
    if (at_ != state.t) look(state);
    hasLeapt_ = distance_ < heeded_ && mayLeap(state, end) && leap(state, end, longestStep);
    if (hasLeapt_) {
      note(state.t);
      return state.t < end ? Outcome::underway : Outcome::arrived;
    }
    const Outcome outcome = steps_->advance(state, end, std::min(longestStep, longest(state)));
    if (!hasFailed(outcome)) note(state.t);
    return outcome;
  }
  bool stepTo(State& state, double t) override {
    return hasLeapt_ ? leap_.at(t, state) && f_.project(state, state) : steps_->stepTo(state, t);
  }
  bool lookTo(State& state, double t) override {
    return hasLeapt_ ? leap_.at(t, state) : steps_->lookTo(state, t);
  }
  int pieces() const override { return hasLeapt_ ? Leap::points : steps_->pieces(); }
  void endAt(State& state) override {
    hasLeapt_ ? void(f_.project(state, state)) : steps_->endAt(state);
    note(state.t);
  }
  void restartAfter(Change change) override {
    if (change == Change::all) {
      at_ = -infinity;
      limit_ = infinity;
      heeded_ = near;
    }
    steps_->restartAfter(change);
  }
  StepCount count() const override {
    StepCount count = steps_->count();
    count.accepted += leaps_;
    count.rejected += failedLeaps_;
    count.leaps += leaps_;
    return count;
  }
  void saveOrRestore(Snapshot& snapshot) override {
    StepsOf::saveOrRestore(snapshot);
    snapshot(distance_, at_, left_, isInSight_, limit_, heeded_, leaps_, failedLeaps_);
  }

 private:
  /// Finds the distance where nothing is known of it.
  void look(const State& state) {
    trial_ = state;
    f_.project(trial_, state);
    at_ = state.t;
    distance_ = std::sqrt(f_.margin());
    left_ = infinity;
  }
  /// A step has ended here, with a projection.
  void note(double t) {
    const double before = std::exchange(distance_, std::sqrt(f_.margin()));
    const double passed = t - std::exchange(at_, t), expected = left_ - passed;
    left_ = distance_ < before ? distance_ * passed / (before - distance_) : infinity;
    isInSight_ = std::abs(left_ - expected) <= steady * left_;
    if (distance_ > near) heeded_ = near;
    if (distance_ > near && left_ == infinity) limit_ = infinity;
  }
  bool mayLeap(const State& state, double end) const {
    constexpr double wellBefore = 3;
    if (distance_ < there) return fastest(state) > 0;
    return left_ < lastGap * reach(state) && left_ < wellBefore * (end - state.t);
  }
  /// The longest next step that does not go over a pose: it ends where a leap may begin, or well before the
  /// pose. Where none is in sight, it turns no joint so far that one may come and go.
  double longest(const State& state) const {
    constexpr double inSight = 1;  // rad
    const double fewTurns = inSight / fastest(state);
    return isInSight_ ? std::min(std::max(left_ - lastGap * reach(state), left_ / 2), fewTurns) : fewTurns;
  }
  double reach(const State& state) const { return std::min(limit_, mostTurned / fastest(state)); }
  double fastest(const State& state) const {
    const Eigen::Index n = f_.firstRate();
    return state.y.segment(n, n).cwiseAbs().maxCoeff();
  }

  bool leap(State& state, double end, double longestStep) {
    // Factors of the length if a leap is not made. The error falls with its tenth power.
    constexpr double safety = 0.9, least = 0.25, diverged = 0.4, otherGap = 0.83;
    double left = left_ < infinity ? left_ : 0, most = reach(state);
    for (int k = 0; k < mostTrials; ++k) {
      double h = most;
      if (left > atStart * most) {
        const auto gap = std::find_if(std::begin(gaps), std::end(gaps),
                                      [&](double share) { return left <= share * most; });
        if (gap == std::end(gaps)) break;
        h = left / *gap;
      }
      const Leap::Result result = leap_.attempt(state, distance_, h, *steps_);
      if (result == Leap::Result::nothing) {
        heeded_ = distance_ / 2;
        return false;
      }
      if (leap_.crossing() > state.t) left = leap_.crossing() - state.t;
      if (result == Leap::Result::nearCrossing) {
        if (h == most) most *= otherGap;
        continue;
      }
      if (result == Leap::Result::made && leap_.error() <= 1 &&
          land(state, std::min({state.t + h, end, state.t + longestStep}))) {
        ++leaps_;
        limit_ = 2 * h;
        return true;
      }
      ++failedLeaps_;
      const bool isKnown = result == Leap::Result::made && std::isfinite(leap_.error());
      most = h *
             (isKnown ? std::max(least, safety * simd::power(std::max(leap_.error(), 1.0), -0.1)) : diverged);
    }
    limit_ = most;
    left_ = left > 0 ? left : infinity;
    return false;
  }
  /// Ends a leap. The other branch is as far away as the leap turns from the pose on.
  bool land(State& state, double t) {
    constexpr double branch = 1e-4;
    if (!leap_.at(t, trial_)) return false;
    reached_ = trial_.y;
    if (!f_.project(trial_, state)) return false;
    const Eigen::Index n = f_.firstRate();
    const double rate = branch * fastest(state);
    const auto isSmall = [&](Eigen::Index first, double ofBranch) {
      const auto to = reached_.segment(first, n).array();
      const auto correction = (trial_.y.segment(first, n).array() - to).abs();
      return (correction <= (most_ * (1 + to.abs())).max(ofBranch)).all();
    };
    if (!isSmall(0, rate * leap_.length()) || !isSmall(n, rate)) return false;
    state = trial_;
    steps_->restartAfter(Change::kink);
    return true;
  }

  System& f_;
  const double most_;
  Leap leap_;
  bool hasLeapt_ = false;
  double distance_ = 1;      ///< from the pose
  double at_ = -infinity;    ///< when, s
  double left_ = infinity;   ///< time to the pose, s
  bool isInSight_ = false;   ///< two steps agree on that time
  double limit_ = infinity;  ///< of the length of a leap, s
  double heeded_ = near;     ///< distances below it, as there is no pose where the last leap looked for it
  long long leaps_ = 0, failedLeaps_ = 0;
  State trial_;
  Vector reached_ = trial_.y;
};

}  // namespace

std::unique_ptr<Integrator> leapingSteps(std::unique_ptr<Integrator> steps, System& f, double most) {
  return std::make_unique<LeapingSteps>(std::move(steps), f, most);
}

}  // namespace planar_chain::ode
