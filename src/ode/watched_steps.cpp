#include "ode/watched_steps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace planar_chain::ode {

/// The value that counts as just above 0.
constexpr double atZero = std::numeric_limits<double>::denorm_min();

/// The states of the last step: by the dense output where it is exact, as at the end; else by shorter steps.
class WatchedSteps::States final : public StatesWithin {
 public:
  States(LastStep& last, double end) : last_(last), end_(end), within_(last) {}
  const Eigen::VectorXd& at(double t) override { return isDense(t) ? last_.at(t) : within_.at(t); }
  /// Sets `state` to that at t. Returns false if it is not finite.
  bool land(double t, State& state) {
    if (isDense(t)) {
      last_.dense.land(t, state);
      return true;
    }
    within_.at(t);
    if (within_.areFinite()) state = last_.trial;
    return within_.areFinite();
  }

 private:
  bool isDense(double t) const { return t == end_ || last_.isExactAt(t); }
  LastStep& last_;
  const double end_;
  ByShorterSteps within_;
};

// ---- One function ----------------------------------------------------------------------------------------

void WatchedSteps::OneSide::values(double t, const double* y, double* to) const {
  *to = never;
  if (failure) return;
  try {
    g.values(t, y, to);
  } catch (...) {
    failure = std::current_exception();
    return;
  }
  if (side > 0) *to = -*to;
  if (side != 0 && *to == 0) *to = atZero;
}

void WatchedSteps::OneSide::noise(double t, const double* y, double* of) const {
  *of = atZero;
  if (failure) return;
  try {
    g.noise(t, y, of);
  } catch (...) {
    failure = std::current_exception();
  }
}

/// By the difference of two values.
void WatchedSteps::OneSide::slopes(double t, const double* y, const double* accelerations,
                                   double* slope) const {
  double values[2] = {};
  for (const int k : {0, 1}) {
    const double ahead = (k - 0.5) * apart;
    near.head(2 * n) = Eigen::VectorXd::Map(y, 2 * n);
    near.head(n) += ahead * Eigen::VectorXd::Map(y + n, n);
    near.segment(n, n) += ahead * Eigen::VectorXd::Map(accelerations, n);
    this->values(t + ahead, near.data(), &values[k]);
  }
  *slope = (values[1] - values[0]) / apart;
}

/// g
double WatchedSteps::OneSide::at(double t, const Eigen::VectorXd& y) const {
  double value = 0;
  values(t, y.data(), &value);
  return value;
}

WatchedSteps::Watch::Watch(const Watched& of, SeriesSystem& f, std::exception_ptr& failure)
    : watched(of),
      function(*of.g, f, failure),
      search({&function}, f.size(), f.driving() / 2),
      near(of.near),
      passed(of.passed) {
  function.side = of.side;
}

// ---- The steps -------------------------------------------------------------------------------------------

WatchedSteps::WatchedSteps(const std::vector<Watched>& functions, SeriesSystem& f)
    : StepsOf(nullptr), last_(f) {
  for (const Watched& function : functions)
    watches_.push_back(std::make_unique<Watch>(function, f, failure_));
}

Outcome WatchedSteps::advance(State& state, double end, double longestStep) {
  stepBefore_ = last_.before.t;
  last_.before = state;
  last_.dense.forget();  // f may have jumped
  const Outcome outcome = steps_->advance(state, end, longestStep);
  if (hasFailed(outcome) || !(state.t > last_.before.t)) return outcome;
  last_.take(state);

  // Find the zeros up to the first terminal one.
  const std::size_t found = zeros_.size();
  double last = state.t;
  for (std::size_t i = 0; i < watches_.size() && !failure_; ++i) searchStep(*watches_[i], i, state.t, last);
  const auto first = zeros_.begin() + static_cast<std::ptrdiff_t>(found);
  zeros_.erase(std::remove_if(first, zeros_.end(), [&](const Zero& zero) { return zero.t > last; }),
               zeros_.end());
  std::stable_sort(zeros_.begin() + static_cast<std::ptrdiff_t>(found), zeros_.end(),
                   [](const Zero& a, const Zero& b) { return a.t < b.t; });

  if (terminal_ && last < state.t) {
    const bool isFinite = States(last_, state.t).land(last, state);
    if (!isFinite) state = last_.before;
    if (!isFinite) return Outcome::notFinite;
    steps_->endAt(state);
    return Outcome::arrived;
  }
  return isOver() && outcome == Outcome::underway ? Outcome::arrived : outcome;
}

void WatchedSteps::goBack(double t) {
  const auto isLater = [t](const Zero& zero) { return zero.t > t; };
  zeros_.erase(std::remove_if(zeros_.begin(), zeros_.end(), isLater), zeros_.end());
  terminal_.reset();
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    const auto isOf = [i](const Zero& zero) { return zero.which == i; };
    watches_[i]->passed = watches_[i]->watched.passed + std::count_if(zeros_.begin(), zeros_.end(), isOf);
    watches_[i]->function.side = 0;
  }
}

// ---- The zeros in a step ---------------------------------------------------------------------------------

/// Finds the zeros of a function in the step to `end`, up to `last`, which a terminal one brings forward.
void WatchedSteps::searchStep(Watch& watch, std::size_t which, double end, double& last) {
  double from = last_.before.t;
  const int pieces = steps_->pieces();
  const double piece = (end - from) / pieces;
  constexpr double smallShare = 1e-5;  // larger: the slope errs by curvature; smaller: by rounding
  States states(last_, end);
  for (int k = 1; k <= pieces; ++k) {
    const double to = k == pieces ? end : last_.before.t + k * piece;
    watch.function.apart = smallShare * piece;
    while (from < std::min(to, last) && !failure_) {
      const bool isAtZero = watch.function.side == 0;
      if (isAtZero) from = leaveZero(watch, from, to, states);
      if (watch.function.side == 0 || !(from < to)) break;
      watch.search.start(from, states.at(from), isAtZero);
      LocatedEvent zero{from};  // if it has passed 0 where f changed
      const double passed = watch.search.before().most();
      if (passed == atZero && watch.zeroAt >= stepBefore_) {  // what passed 0 is held there: the same zero
        watch.function.side = 0;
        continue;
      }
      if (!(passed > 0)) {
        if (watch.search.search(to, states.at(to), last_) != EventSearch::Result::event) break;
        zero = watch.search.locate(states);
      }
      takeZero(watch, which, zero, from, states, last);
      from = zero.t;
    }
    from = to;
  }
}

/// Sets the side of a function that may be 0 at `from`: the first one that it shows. Returns the time then.
double WatchedSteps::leaveZero(Watch& watch, double from, double end, StatesWithin& states) {
  const double least = 16 * std::numeric_limits<double>::epsilon() * std::max(std::abs(from), end - from);
  double noise = 0;
  watch.function.noise(from, states.at(from).data(), &noise);
  noise = std::max(noise, std::exchange(watch.near, 0));
  double t = from;
  for (double ahead = least;; ahead *= 4) {
    const double value = watch.function.at(t, states.at(t));
    if (std::abs(value) > noise) watch.function.side = value > 0 ? 1 : -1;
    if (watch.function.side != 0 || t == end || failure_) return t;
    t = std::min(from + ahead, end);
  }
}

/// Unless the dense output passes 0 here, and the motion does not. What is located is behind the zero by some
/// roundings: one step of Newton's method leads back.
void WatchedSteps::takeZero(Watch& watch, std::size_t which, const LocatedEvent& located, double from,
                            StatesWithin& states, double& last) {
  double t = located.t;
  const double value = watch.function.at(t, states.at(t));
  if (!(value > 0)) return;
  const double back = located.slope > 0 ? std::max(t - value / located.slope, from) : t;
  if (std::abs(watch.function.at(back, states.at(back))) < value) t = back;
  watch.near = 2 * value;
  watch.zeroAt = t;
  const int direction = -std::exchange(watch.function.side, 0);
  if (direction * watch.watched.direction < 0) return;
  zeros_.push_back({which, t, states.at(t), watch.near});
  if (++watch.passed != watch.watched.terminal || (terminal_ && !(t < last))) return;
  last = t;
  terminal_ = which;
}

}  // namespace planar_chain::ode
