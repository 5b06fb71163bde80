#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "ode/switches.h"

namespace planar_chain::ode {

Tolerance Tolerance::arrangedBy(const System& f) const {
  Tolerance result = *this;
  const Eigen::Index others = f.size() - ceiling.size();
  Vector all(f.size()), arranged(f.arrangedSize());
  for (Eigen::ArrayXd* of : {&result.unit, &result.ceiling}) {
    all.head(of->size()) = *of;
    f.arrange(all.data(), arranged.data());
    *of = arranged.head(arranged.size() - others);
    *of = (*of > 0).select(*of, 1);  // f may fill gaps between components with 0
  }
  if (firstRate >= f.size()) return result;

  // Rates are arranged behind the angles.
  all.setZero();
  all.tail(f.size() - firstRate).setOnes();
  f.arrange(all.data(), arranged.data());
  result.firstRate = std::find(arranged.data(), arranged.data() + arranged.size(), 1.0) - arranged.data();
  return result;
}

const Crossing& Integrator::crossing() const {
  static const Crossing none;
  return none;
}

Outcome Integrator::integrate(State& state, double end, double longestStep, int mostSteps) {
  // At 0 s two times can be so close that 1/h overflows. Nothing moves meanwhile.
  constexpr double nothing = 1e-300;  // s
  if (end - state.t < nothing) state.t = std::max(state.t, end);
  Outcome outcome = state.t < end ? Outcome::underway : Outcome::arrived;
  for (int k = 0; outcome == Outcome::underway && k < mostSteps; ++k) {
    outcome = advance(state, end, longestStep);
  }
  return outcome;
}

namespace {

// ---- Steps that end behind switches ----------------------------------------------------------

class LandingOnSwitches : public StepsOf {
 public:
  LandingOnSwitches(std::unique_ptr<Integrator> steps, const Switches& switches, SeriesSystem& f)
      : StepsOf(std::move(steps)),
        switches_(switches),
        f_(f),
        course_(f),
        landsByCourse_(f.positions() > 0),
        mostSwitches_(1000 + 10 * f.size()),  // far more than all joints need to stick or slide
        before_(f.arrangedSize()),
        trial_(before_) {
    from_.y.resize(f.size());
    found_ = from_;
    ahead_.fill(from_);
  }

  void restartAfter(Change change) override {
    if (change == Change::all) {
      usual_ = infinity;
      switchedAt_ = stoodAt_ = -infinity;
    }
    course_.forget();
    hasChanged_ = true;
    const bool isBend = change == Change::stiffness && crossing_.by;
    const Change bend = crossing_.changesStiffness ? Change::stiffBend : Change::bend;
    steps_->restartAfter(isBend ? bend : change);
  }
  /// The steps made to land count as rejected.
  StepCount count() const override {
    StepCount count = steps_->count();
    count.rejected += landing_;
    return count;
  }
  const Crossing& crossing() const override { return crossing_; }
  void saveOrRestore(Snapshot& snapshot) override {
    StepsOf::saveOrRestore(snapshot);
    bool wasFound = crossing_.by != nullptr;
    snapshot(course_, landing_, usual_, switchedAt_, wasFound, crossing_.changesStiffness, hasChanged_,
             stoodAt_, switchesThere_);
    crossing_.by = wasFound ? &switches_ : nullptr;  // change() has had it
  }

  Outcome advance(State& state, double end, double longestStep) override {
    before_ = state;
    from_.t = before_.t;
    f_.restore(before_.y.data(), from_.y.data());
    if (std::exchange(hasChanged_, false) && switches_.due(from_.t, from_.y) > 0) {
      crossing_ = {};
      return switchAt(from_.t);
    }
    if (crossing_.by) course_.begin(before_);  // the step needs it, too
    const Outcome outcome = steps_->advance(state, end, std::min(longestStep, longest(state.t)));
    if (hasFailed(outcome)) return outcome;
    f_.endedAt(state);
    evaluate(state, ahead_.front());
    if (course_.isPossible()) course_.take(before_, state, steps_->pieces() > 1 ? steps_.get() : nullptr);
    Outcome found = findOnTheWay();
    if (found == Outcome::underway) {
      usual_ *= farther;
      return outcome;
    }
    if (found == Outcome::switched) {
      crossing_ = {};
      if (!landsByCourse_ || !landWithin(state)) {
        crossing_ = {};
        found = land(state);
      }
    }
    if (found == Outcome::switched) found = switchAt(state.t);
    if (hasFailed(found)) state = before_;
    return found;
  }

 private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();

  /// A state within the step, and Switches::due() there.
  struct Place {
    double t;
    Eigen::VectorXd y;
    double due;
  };

  // Wrong values here cost steps, and no accuracy. `memory`: of earlier times between bends over the last
  // one.
  static constexpr double farther = 1.5, mostOfUsual = 3, memory = 3;

  /// Of a step: little behind the next switch, but long enough to be made.
  double longest(double t) const {
    constexpr double shortest = 256 * std::numeric_limits<double>::epsilon();
    return std::max(mostOfUsual * usual_, shortest * std::max(1.0, std::abs(t)));
  }

  /// switches_.due() at t.
  struct Point {
    double t, due;
  };

  /// The zero between a and b, as the share of the way from a: by inverse interpolation through three points,
  /// if that is safe.
  static std::optional<double> shareToZero(const Point& a, const Point& b, const Point& c) {
    const double xi = (a.t - b.t) / (c.t - b.t), phi = (a.due - b.due) / (c.due - b.due);
    if (!(phi * phi < xi && (1 - phi) * (1 - phi) < 1 - xi)) return {};
    return a.due / (b.due - a.due) * (c.due / (b.due - c.due)) +
           (c.t - a.t) / (b.t - a.t) * (a.due / (c.due - a.due)) * (b.due / (c.due - b.due));
  }

  void evaluate(const State& state, Place& place) const {
    place.t = state.t;
    f_.restore(state.y.data(), place.y.data());
    place.due = switches_.due(place.t, place.y);
  }

  /// Sets trial_ to the state at t, by a step. Returns false if it is not finite.
  bool evaluateAt(double t, Place& place) {
    if (steps_->pieces() == 1) ++landing_;  // else the step is a polynomial, and costs nothing
    return lookAt(t, place);
  }
  /// The same, where it costs nothing.
  bool lookAt(double t, Place& place) {
    trial_ = before_;
    if (!steps_->stepTo(trial_, t)) return false;
    evaluate(trial_, place);
    return true;
  }

  /// The same by the course, if that is known and exact.
  bool evaluateWithin(double t, Place& place) {
    if (!isExactAt(t)) return evaluateAt(t, place);
    lookWithin(t, place);
    return true;
  }
  /// The same by the course, exact or not: what is due there may be due in vain.
  void lookWithin(double t, Place& place) {
    place.t = t;
    place.y = course_.at(t);
    place.due = switches_.due(t, place.y);
  }

  /// True if the course's error there is at most this share of the one that a step may add.
  bool isExactAt(double t, double share = 1) const {
    return course_.isKnown() && steps_->errorNorm(before_.y, t - before_.t, course_.errorAt(t)) <= share;
  }

  Stretch stretch(const Place& to) const {
    return {from_.t, to.t - from_.t, from_.y, to.y, course_.isPossible() ? &course_ : nullptr};
  }

  /// Moves from_, where nothing is due, to the end of the step, or as far as nothing is due. In the second
  /// case returns `switched`, and found_ is the next place, where something is due.
  Outcome findOnTheWay() {
    constexpr int mostCuts = 24;  // an overdamped stop would need millions, each closer to from_
    int cuts = 0;
    std::size_t count = 1;
    const bool isLong = steps_->pieces() > 1, looks = switches_.mayHide(stretch(ahead_.front()), isLong);
    const int pieces = looks ? std::max(steps_->pieces(), course_.isPossible() ? 2 : 1) : 1;
    const double piece = (ahead_.front().t - from_.t) / pieces;
    double hidden = from_.t;
    if (course_.isPossible() && !isLong) hidden += switches_.hidden(stretch(ahead_.front()));
    for (int k = pieces - 1; k >= 0; --k) {
      const double t = from_.t + k * piece;
      if (hidden > t && !evaluateWithin(std::exchange(hidden, from_.t), ahead_[count++]))
        return Outcome::notFinite;
      if (hidden == t) hidden = from_.t;
      if (k == 0) break;
      Place& place = ahead_[count++];
      if (course_.isPossible()) {
        lookWithin(t, place);
      } else if (!lookAt(t, place)) {
        return Outcome::notFinite;
      }
    }
    while (count > 0) {
      Place& to = ahead_[count - 1];
      const double passing = switches_.nearest(stretch(to));
      const double t = from_.t + passing;
      if (passing > 0 && t > from_.t && t < to.t && count < ahead_.size() && cuts < mostCuts) {
        ++cuts;
        if (!evaluateWithin(t, ahead_[count++])) return Outcome::notFinite;
        continue;
      }
      if (to.due > 0) {
        std::swap(found_, to);
        return Outcome::switched;
      }
      std::swap(from_, to);
      --count;
    }
    return Outcome::underway;
  }

  double narrow(const State& state) const {
    return 4 * std::numeric_limits<double>::epsilon() * std::max(std::abs(state.t), state.t - before_.t);
  }

  /// A switch is due at found_ and not at from_. Sets `state` to the first time at which it is due. Returns
  /// false, and changes nothing, if that is unknown.
  bool landWithin(State& state) {
    constexpr int mostSteps = 4;
    // Shares of a step, and of the last: shorter steps end before the switch, whose time is not exact yet;
    // after longer ones the course is less exact there. A wrong share costs steps.
    constexpr double behind = 1e-3, nearer = 1e-4, more = 10;
    // Of the error that a step may add, where the stiffness changes: the first such landing is before it is
    // known that the error of a rate may last longer than a stiff mode (integrator.h).
    constexpr double ofStiffness = 1e-4;
    double beyond = behind * (found_.t - before_.t);
    for (int steps = 0;; ++steps) {
      const std::optional<Crossing> crossing = switches_.crossing(stretch(found_));
      if (!crossing) return false;
      const double t = crossing->t;
      crossing_ = *crossing;
      if (isExactAt(t, crossing->changesStiffness ? ofStiffness : 1)) {
        course_.land(t, state);
        steps_->endAt(state);
        countBend(state.t);
        return true;
      }
      // The course is exact near the end of a step. Make one that ends just behind the switch.
      do {
        const double end = t + beyond;
        if (steps == mostSteps || !(end < found_.t) || !evaluateAt(end, ahead_.front())) return false;
        beyond *= more;
      } while (ahead_.front().due <= 0 && ++steps);
      std::swap(found_, ahead_.front());
      course_.take(before_, trial_);
      beyond *= nearer;
    }
  }

  /// Returns `switched`, unless too many switches came since time last passed.
  Outcome switchAt(double t) {
    constexpr double nothing = 1e-12;  // of t
    if (t - stoodAt_ > nothing * std::abs(t)) {
      stoodAt_ = t;
      switchesThere_ = 0;
    }
    return ++switchesThere_ > mostSwitches_ ? Outcome::endless : Outcome::switched;
  }

  void countBend(double t) {
    const double passed = t - std::exchange(switchedAt_, t);
    usual_ = std::isfinite(usual_) ? (memory * usual_ + passed) / (memory + 1) : passed;
  }

  /// The same by a bracket, of which `state` is the upper end.
  Outcome land(State& state) {
    if (found_.t < state.t) {
      if (!evaluateAt(found_.t, found_)) return Outcome::notFinite;
      state = trial_;
    }
    Place& place = ahead_.front();
    // The last point, the end of the bracket opposite to it, and the one that the last point replaced.
    Point last{found_.t, found_.due}, opposite{from_.t, switches_.due(from_.t, from_.y)}, before = opposite;
    const double narrow = this->narrow(state);
    constexpr double leastShare = 1. / 64;
    bool isSecant = false;
    constexpr int most = 40;  // where steps err wildly, other points may shorten the bracket by roundings
    int tried = 0;
    for (double width; (width = std::abs(last.t - opposite.t)) > narrow;) {
      // Choose the next point, but not too near the ends. Secants alone would shorten one side only.
      double margin = narrow / 2 / width, share = 0.5;
      if (++tried > most) {
        margin = 0.5;
      } else if (const std::optional<double> found = shareToZero(last, opposite, before)) {
        share = *found;
      } else if ((isSecant = !isSecant)) {
        share = last.due / (last.due - opposite.due);
        margin = std::max(margin, leastShare);
      }
      share = std::min(std::max(share, margin), 1 - margin);
      const double t = last.t + share * (opposite.t - last.t);
      if (!(t > std::min(last.t, opposite.t) && t < std::max(last.t, opposite.t))) break;
      if (!evaluateAt(t, place)) return Outcome::notFinite;

      // Replace one end.
      const bool isDue = place.due > 0;
      if (isDue) state = trial_;
      before = last;
      if (isDue != (last.due > 0)) std::swap(before, opposite);
      last = {t, place.due};
    }
    return Outcome::switched;
  }

  const Switches& switches_;
  SeriesSystem& f_;
  Course course_;
  const bool landsByCourse_;       ///< false: steps cost little beside it
  long long landing_ = 0;          ///< steps made to land
  double usual_ = infinity;        ///< time between bends, s
  double switchedAt_ = -infinity;  ///< the last one, s
  Crossing crossing_;              ///< the last one
  bool hasChanged_ = true;         ///< f or the state: a switch may be due where the next step starts
  double stoodAt_ = -infinity;     ///< when time last passed, s
  int switchesThere_ = 0;          ///< since then
  const int mostSwitches_;
  State before_, trial_;
  Place from_{}, found_{};
  std::array<Place, 12> ahead_;  ///< the nearest last; deeper cuts make no sense
};

}  // namespace

std::unique_ptr<Integrator> landingOnSwitches(std::unique_ptr<Integrator> steps, const Switches& switches,
                                              SeriesSystem& f) {
  return std::make_unique<LandingOnSwitches>(std::move(steps), switches, f);
}

}  // namespace planar_chain::ode
