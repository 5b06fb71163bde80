#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "ode/events.h"
#include "ode/last_step.h"

namespace planar_chain::ode {

namespace {

class StepsToEvents final : public StepsOf {
 public:
  StepsToEvents(std::unique_ptr<Integrator> steps, const EventList& events, SeriesSystem& f)
      : StepsOf(std::move(steps)),
        f_(f),
        last_(f),
        search_(events, f.size(), last_.dense.isPossible() ? f.driving() / 2 : 0),
        endsByDenseOutput_(f.positions() > 0),
        mostEvents_(1000 + 10 * f.size()) {  // far more than all joints need to stick or slide
    last_.use(*steps_);
  }

  void restartAfter(Change change) override {
    if (change == Change::all) {
      usual_ = infinity;
      lastAt_ = stoodAt_ = -infinity;
    }
    last_.dense.forget();
    hasChanged_ = true;
    if (change == Change::stiffness && isKink_)
      change = event_.by->changeStiffness() ? Change::stiffKink : Change::kink;
    steps_->restartAfter(change);
  }
  /// The steps made to find events count as rejected.
  StepCount count() const override {
    StepCount count = steps_->count();
    count.rejected += last_.made();
    return count;
  }
  const LocatedEvent& event() const override { return event_; }
  void saveOrRestore(Snapshot& snapshot) override {
    StepsOf::saveOrRestore(snapshot);
    snapshot(last_.dense, search_, last_.made(), usual_, lastAt_, isKink_, hasChanged_, stoodAt_,
             eventsThere_);
    // The last event has been fired.
  }

  Outcome advance(State& state, double end, double longestStep) override {
    last_.before = state;
    const bool hasChanged = std::exchange(hasChanged_, false);
    search_.start(state.t, last_.inOrder(state), hasChanged);
    if (hasChanged && search_.before().most() > 0) {
      event_ = {};
      isKink_ = false;
      return endAtEvent(state.t);
    }
    if (isKink_) last_.dense.begin(last_.before);  // the step needs it, too
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
    if (hasFailed(ended)) state = last_.before;
    return ended;
  }

 private:
  using Result = EventSearch::Result;
  static constexpr double infinity = std::numeric_limits<double>::infinity();

  // Wrong values here cost steps, and no accuracy. `memory`: of earlier times between events over the last
  // one.
  static constexpr double farther = 1.5, mostOfUsual = 3, memory = 3;

  /// The longest step: it ends little behind the next event, but is long enough to be made.
  double longest(double t) const {
    constexpr double shortest = 256 * std::numeric_limits<double>::epsilon();
    return std::max(mostOfUsual * usual_, shortest * std::max(1.0, std::abs(t)));
  }

  // ---- The event in a step --------------------------------------------------------------------------------

  /// Searches the step to this state.
  Result find(const State& state) {
    if (!last_.dense.isPossible()) return search_.look(state.t, last_.inOrder(state));
    last_.take(state);
    const int pieces = steps_->pieces();
    const double piece = (state.t - last_.before.t) / pieces;
    Result found = Result::nothing;
    for (int k = 1; k < pieces && found == Result::nothing; ++k) {
      const double t = last_.before.t + k * piece;
      found = search_.search(t, last_.at(t), last_);
    }
    return found == Result::nothing ? search_.search(state.t, last_.inOrder(state), last_) : found;
  }

  /// Sets `state` to the first time at which an event has happened. Returns false, and changes nothing, if
  /// the dense output is not exact enough.
  bool endWithin(State& state) {
    constexpr int mostSteps = 4;
    // Shares of a step, and of the last: shorter steps end before the event, whose time is not exact yet;
    // after longer ones the dense output is less exact there. A wrong share costs steps.
    constexpr double behind = 1e-3, nearer = 1e-4, more = 10;
    // A share of the error that a step may add, where the stiffness changes: the first such event is before
    // it is known that the error of a rate may last longer than a stiff mode (integrator.h).
    constexpr double ofStiffness = 1e-4;
    double beyond = behind * (search_.behind().t - last_.before.t);
    for (int steps = 0;; ++steps) {
      event_ = search_.locate(last_);
      const double t = event_.t;
      if (last_.isExactAt(t, event_.by->changeStiffness() ? ofStiffness : 1)) {
        last_.dense.land(t, state);
        steps_->endAt(state);
        countTime(state.t);
        return true;
      }
      // The dense output is exact near the end of a step. Make one that ends just behind the event.
      for (bool hasHappened = false; !hasHappened;) {
        const double end = t + beyond;
        if (steps == mostSteps || !(end < search_.behind().t) || !last_.stepTo(end)) return false;
        beyond *= more;
        hasHappened = search_.shorten(end, last_.inOrder(last_.trial));
        if (!hasHappened) ++steps;
      }
      last_.dense.take(last_.before, last_.trial);
      beyond *= nearer;
    }
  }

  void countTime(double t) {
    const double passed = t - std::exchange(lastAt_, t);
    usual_ = std::isfinite(usual_) ? (memory * usual_ + passed) / (memory + 1) : passed;
  }

  /// endWithin() by steps of the method. Returns false if they are not finite.
  bool endBySteps(State& state) {
    ByShorterSteps states(last_);
    event_ = search_.locate(states);
    states.at(event_.t);
    if (states.areFinite()) state = last_.trial;
    return states.areFinite();
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
  LastStep last_;
  EventSearch search_;
  const bool endsByDenseOutput_;  ///< false: steps cost little beside it
  double usual_ = infinity;       ///< time between events, s
  double lastAt_ = -infinity;     ///< the last one, s
  LocatedEvent event_;            ///< the last one
  bool isKink_ = false;           ///< it ended a step within, by its dense output
  bool hasChanged_ = true;        ///< f or the state: an event may have happened where the next step starts
  double stoodAt_ = -infinity;    ///< when time last passed, s
  int eventsThere_ = 0;           ///< since then
  const int mostEvents_;
};

}  // namespace

std::unique_ptr<Integrator> stepsToEvents(std::unique_ptr<Integrator> steps, const EventList& events,
                                          SeriesSystem& f) {
  return std::make_unique<StepsToEvents>(std::move(steps), events, f);
}

}  // namespace planar_chain::ode
