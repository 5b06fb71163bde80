#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "ode/dense_output.h"
#include "ode/event_search.h"
#include "ode/events.h"

namespace planar_chain::ode {

namespace {

class StepsToEvents final : public StepsOf, private StepStates {
 public:
  StepsToEvents(std::unique_ptr<Integrator> steps, const EventList& events, SeriesSystem& f)
      : StepsOf(std::move(steps)),
        f_(f),
        dense_(f),
        search_(events, f.size(), dense_.isPossible() ? f.driving() / 2 : 0),
        endsByDenseOutput_(f.positions() > 0),
        mostEvents_(1000 + 10 * f.size()),  // far more than all joints need to stick or slide
        before_(f.sizeInLaneOrder()),
        trial_(before_),
        rates_(before_.y),
        y_(Eigen::VectorXd::Zero(f.size())),
        error_(y_) {}

  void restartAfter(Change change) override {
    if (change == Change::all) {
      usual_ = infinity;
      lastAt_ = stoodAt_ = -infinity;
    }
    dense_.forget();
    hasChanged_ = true;
    if (change == Change::stiffness && isKink_)
      change = event_.by->changeStiffness() ? Change::stiffKink : Change::kink;
    steps_->restartAfter(change);
  }
  /// The steps made to find events count as rejected.
  StepCount count() const override {
    StepCount count = steps_->count();
    count.rejected += stepsToFind_;
    return count;
  }
  const LocatedEvent& event() const override { return event_; }
  void saveOrRestore(Snapshot& snapshot) override {
    StepsOf::saveOrRestore(snapshot);
    snapshot(dense_, search_, stepsToFind_, usual_, lastAt_, isKink_, hasChanged_, stoodAt_, eventsThere_);
    // The last event has been fired.
  }

  Outcome advance(State& state, double end, double longestStep) override {
    before_ = state;
    f_.toChainOrder(before_.y.data(), y_.data());
    const bool hasChanged = std::exchange(hasChanged_, false);
    search_.start(before_.t, y_, hasChanged);
    if (hasChanged && search_.before().most() > 0) {
      event_ = {};
      isKink_ = false;
      return endAtEvent(before_.t);
    }
    if (isKink_) dense_.begin(before_);  // the step needs it, too
    const Outcome outcome = steps_->advance(state, end, std::min(longestStep, longest(state.t)));
    if (hasFailed(outcome)) return outcome;
    f_.endedAt(state);
    Result found = find(state);
    if (found == Result::nothing) {
      usual_ *= farther;
      return outcome;
    }
    isKink_ = found == Result::event && endsByDenseOutput_ && endWithin(state);
    const bool isAtEvent = isKink_ || (found == Result::event && endBySteps(state));
    const Outcome ended = isAtEvent ? endAtEvent(state.t) : Outcome::notFinite;
    if (hasFailed(ended)) state = before_;
    return ended;
  }

 private:
  using Result = EventSearch::Result;
  static constexpr double infinity = std::numeric_limits<double>::infinity();

  // Wrong values here cost steps, and no accuracy. `memory`: of earlier times between events over the last
  // one.
  static constexpr double farther = 1.5, mostOfUsual = 3, memory = 3;

  /// Of a step: little behind the next event, but long enough to be made.
  double longest(double t) const {
    constexpr double shortest = 256 * std::numeric_limits<double>::epsilon();
    return std::max(mostOfUsual * usual_, shortest * std::max(1.0, std::abs(t)));
  }

  // ---- The states within a step -------------------------------------------------------------------------

  /// Those of steps that end there.
  struct BySteps final : StatesWithin {
    explicit BySteps(StepsToEvents& of_) : of(of_) { of.trial_.t = of.before_.t; }
    const Eigen::VectorXd& at(double t) override {
      if (of.trial_.t == t) return of.y_;
      areFinite = of.stepTo(t) && areFinite;
      return of.inOrder(of.trial_);
    }
    StepsToEvents& of;
    bool areFinite = true;
  };

  const Eigen::VectorXd& at(double t) override { return dense_.at(t); }
  const Eigen::VectorXd& accelerationsAt(double t) override { return dense_.accelerationsAt(t); }
  const Eigen::VectorXd* errorAt(double t) override {
    if (isExactAt(t)) return nullptr;
    f_.toChainOrder(dense_.errorAt(t).data(), error_.data());
    return &error_;
  }
  bool make(double t, Eigen::VectorXd& y, Eigen::VectorXd& accelerations) override {
    if (!stepTo(t)) return false;
    f_.toChainOrder(trial_.y.data(), y.data());
    const Eigen::Index n = f_.places();
    f_.slope(t, trial_.y.data(), rates_.data());
    rates_.head(n) = rates_.segment(n, n);  // they do not overlap
    f_.toChainOrder(rates_.data(), accelerations.data());
    return true;
  }

  /// True if the error of the dense output there is at most this share of the one that a step may add.
  bool isExactAt(double t, double share = 1) const {
    return dense_.isKnown() && steps_->errorNorm(before_.y, t - before_.t, dense_.errorAt(t)) <= share;
  }
  /// Sets trial_ to the state at t, by a step. Returns false if it is not finite.
  bool stepTo(double t) {
    if (steps_->pieces() == 1) ++stepsToFind_;  // else the step is a polynomial, and costs nothing
    trial_ = before_;
    return steps_->stepTo(trial_, t);
  }
  const Eigen::VectorXd& inOrder(const State& state) {
    f_.toChainOrder(state.y.data(), y_.data());
    return y_;
  }

  // ---- The event in a step --------------------------------------------------------------------------------

  /// Searches the step to this state.
  Result find(const State& state) {
    if (!dense_.isPossible()) return search_.look(state.t, inOrder(state));
    const int pieces = steps_->pieces();
    dense_.take(before_, state, pieces > 1 ? steps_.get() : nullptr);
    const double piece = (state.t - before_.t) / pieces;
    Result found = Result::nothing;
    for (int k = 1; k < pieces && found == Result::nothing; ++k) {
      const double t = before_.t + k * piece;
      y_ = dense_.at(t);
      found = search_.search(t, y_, *this);
    }
    return found == Result::nothing ? search_.search(state.t, inOrder(state), *this) : found;
  }

  /// Sets `state` to the first time at which an event has happened. Returns false, and changes nothing, if
  /// the dense output is not exact enough.
  bool endWithin(State& state) {
    constexpr int mostSteps = 4;
    // Shares of a step, and of the last: shorter steps end before the event, whose time is not exact yet;
    // after longer ones the dense output is less exact there. A wrong share costs steps.
    constexpr double behind = 1e-3, nearer = 1e-4, more = 10;
    // Of the error that a step may add, where the stiffness changes: the first such event is before it is
    // known that the error of a rate may last longer than a stiff mode (integrator.h).
    constexpr double ofStiffness = 1e-4;
    double beyond = behind * (search_.behind().t - before_.t);
    for (int steps = 0;; ++steps) {
      event_ = search_.locate(*this);
      const double t = event_.t;
      if (isExactAt(t, event_.by->changeStiffness() ? ofStiffness : 1)) {
        dense_.land(t, state);
        steps_->endAt(state);
        countTime(state.t);
        return true;
      }
      // The dense output is exact near the end of a step. Make one that ends just behind the event.
      for (bool hasHappened = false; !hasHappened;) {
        const double end = t + beyond;
        if (steps == mostSteps || !(end < search_.behind().t) || !stepTo(end)) return false;
        beyond *= more;
        hasHappened = search_.shorten(end, inOrder(trial_));
        if (!hasHappened) ++steps;
      }
      dense_.take(before_, trial_);
      beyond *= nearer;
    }
  }

  void countTime(double t) {
    const double passed = t - std::exchange(lastAt_, t);
    usual_ = std::isfinite(usual_) ? (memory * usual_ + passed) / (memory + 1) : passed;
  }

  /// The same by steps of the method, from the same state. Returns false if they are not finite.
  bool endBySteps(State& state) {
    BySteps states(*this);
    event_ = search_.locate(states);
    states.at(event_.t);
    if (states.areFinite) state = trial_;
    return states.areFinite;
  }

  /// Returns `switched`, unless too many events came since time last passed.
  Outcome endAtEvent(double t) {
    constexpr double nothing = 1e-12;  // of t
    if (t - stoodAt_ > nothing * std::abs(t)) {
      stoodAt_ = t;
      eventsThere_ = 0;
    }
    return ++eventsThere_ > mostEvents_ ? Outcome::endless : Outcome::switched;
  }

  SeriesSystem& f_;
  DenseOutput dense_;
  EventSearch search_;
  const bool endsByDenseOutput_;  ///< false: steps cost little beside it
  long long stepsToFind_ = 0;
  double usual_ = infinity;     ///< time between events, s
  double lastAt_ = -infinity;   ///< the last one, s
  LocatedEvent event_;          ///< the last one
  bool isKink_ = false;         ///< it ended a step within, by its dense output
  bool hasChanged_ = true;      ///< f or the state: an event may have happened where the next step starts
  double stoodAt_ = -infinity;  ///< when time last passed, s
  int eventsThere_ = 0;         ///< since then
  const int mostEvents_;
  State before_, trial_;
  Vector rates_;
  Eigen::VectorXd y_, error_;
};

}  // namespace

std::unique_ptr<Integrator> stepsToEvents(std::unique_ptr<Integrator> steps, const EventList& events,
                                          SeriesSystem& f) {
  return std::make_unique<StepsToEvents>(std::move(steps), events, f);
}

}  // namespace planar_chain::ode
