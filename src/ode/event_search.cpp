#include "ode/event_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "ode/event_polynomials.h"

namespace planar_chain::ode {

namespace {

/// A step resolves the motion. So within it a function goes no more than so many times as far beyond its ends
/// as its values and slopes there tell. Larger: more steps are looked at closely. Smaller: a method of high
/// order, whose steps are long, may miss an event.
constexpr double farther = 4;
/// A cut is at least this share of the interval away from its ends. Nearer to an end, it leaves the other
/// part nearly as long, and says nothing about e.
constexpr double leastShare = 1. / 8;

/// The times that differ by more than rounding.
double narrowest(double t, double h) {
  return 8 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t), h);
}

}  // namespace

EventSearch::EventSearch(const EventList& events, Eigen::Index size, Eigen::Index n) : n_(n) {
  Eigen::Index total = 0;
  for (const EventFunctions* functions : events) {
    groups_.push_back({functions, 0, 0, true});
    total += functions->most();
  }
  for (Numbers* numbers : {&noise_, &values_}) numbers->setZero(total);
  accelerations_.setZero(size);
  from_ = {0, Eigen::VectorXd::Zero(size), Numbers::Zero(total), Numbers::Zero(total)};
  to_ = middle_ = from_;
  cuts_.fill({from_, noise_});
}

// ---- Values --------------------------------------------------------------------------------------------

void EventSearch::setCounts() {
  Eigen::Index first = 0;
  for (Group& group : groups_) {
    group.first = first;
    group.count = group.functions->count();
    group.isOpen = true;
    first += group.functions->most();
  }
}

void EventSearch::evaluate(Sample& at, bool openOnly) {
  at.g.setConstant(never);
  for (const Group& group : groups_) {
    if (group.count == 0 || (openOnly && !group.isOpen)) continue;
    group.functions->values(at.t, at.y.data(), at.g.data() + group.first);
  }
}

void EventSearch::findSlopes(Sample& at, const Eigen::VectorXd& accelerations) {
  for (const Group& group : groups_) {
    if (group.count == 0 || !group.isOpen || !group.functions->haveSlopes()) continue;
    group.functions->slopes(at.t, at.y.data(), accelerations.data(), at.slope.data() + group.first);
  }
}

void EventSearch::start(double t, const Eigen::VectorXd& y, bool anew) {
  setCounts();
  if (!anew && isKnown_ && from_.t == t && from_.y == y) return;
  from_.t = t;
  from_.y = y;
  evaluate(from_, false);
  isKnown_ = true;
}

bool EventSearch::shorten(double t, const Eigen::VectorXd& y) {
  middleBy_ = nullptr;
  middle_.t = t;
  middle_.y = y;
  evaluate(middle_, true);
  if (!(middle_.most() > 0)) return false;
  std::swap(to_, middle_);
  return true;
}

// ---- The search ----------------------------------------------------------------------------------------

EventSearch::Result EventSearch::look(double t, const Eigen::VectorXd& y) {
  to_.t = t;
  to_.y = y;
  evaluate(to_, false);
  if (to_.most() > 0) return setBracket(from_, to_);
  std::swap(from_, to_);
  return Result::nothing;
}

EventSearch::Result EventSearch::search(double t, const Eigen::VectorXd& y, StepStates& states) {
  to_.t = t;
  to_.y = y;
  middleBy_ = nullptr;
  setCounts();
  evaluate(to_, false);
  Result result = Result::nothing;
  if (!isQuiet(states) && !isQuietByHalves(states)) {
    findErrors(states);
    cutsMade_ = stepsMade_ = 0;
    result = resolve(from_, to_, 1, states);
  }
  if (result == Result::nothing) std::swap(from_, to_);
  return result;
}

/// The first look. Closes the groups in which nothing happens. Returns true if all are closed.
bool EventSearch::isQuiet(StepStates& states) {
  const double h = to_.t - from_.t;
  const auto v0 = from_.y.segment(n_, n_), v1 = to_.y.segment(n_, n_);
  const auto turn = 6 / h * (to_.y.head(n_) - from_.y.head(n_));
  bool isQuiet = true, hasSlopes = false;
  for (const Group& group : groups_)
    hasSlopes = hasSlopes || (group.count > 0 && group.functions->haveSlopes());
  if (hasSlopes) {
    accelerations_.head(n_) = (turn - 4 * v0 - 2 * v1) / h;
    findSlopes(from_, accelerations_);
    accelerations_.head(n_) = (4 * v1 + 2 * v0 - turn) / h;
    findSlopes(to_, accelerations_);
  }
  for (Group& group : groups_) {
    const auto a = group.of(from_.g), b = group.of(to_.g);
    if (group.functions->haveSlopes()) {
      const auto sizes = group.of(from_.slope).abs() + group.of(to_.slope).abs();
      group.isOpen = !(a.max(b) + farther * ((b - a).abs() + h * sizes) <= 0).all();
    } else if (group.count > 0) {
      setMiddle(states);
      group.functions->values(middle_.t, middle_.y.data(), middle_.g.data() + group.first);
      const auto m = group.of(middle_.g);
      group.isOpen = !(2 * a.max(b).max(m) - a.min(b).min(m) <= 0).all();
    } else {
      group.isOpen = false;
    }
    isQuiet = isQuiet && !group.isOpen;
  }
  return isQuiet;
}

void EventSearch::setMiddle(StepStates& states) {
  if (std::exchange(middleBy_, &states)) return;
  middle_.t = from_.t + (to_.t - from_.t) / 2;
  middle_.y = states.at(middle_.t);
}

/// The second look. Closes groups, and returns as isQuiet().
bool EventSearch::isQuietByHalves(StepStates& states) {
  const double h = to_.t - from_.t;
  setMiddle(states);
  for (Sample* at : {&from_, &middle_, &to_}) findSlopes(*at, states.accelerationsAt(at->t));
  bool isQuiet = true;
  for (Group& group : groups_) {
    if (group.isOpen) group.functions->noise(to_.t, to_.y.data(), noise_.data() + group.first);
    if (group.isOpen && group.functions->haveSlopes()) {
      group.functions->values(middle_.t, middle_.y.data(), middle_.g.data() + group.first);
      const auto a = group.of(from_.g), b = group.of(to_.g), m = group.of(middle_.g);
      const auto highest = (a + h / 6 * group.of(from_.slope))
                               .max(m + h / 6 * group.of(middle_.slope).abs())
                               .max(b - h / 6 * group.of(to_.slope))
                               .max(a)
                               .max(b);
      group.isOpen = !(2 * highest - a.min(b).min(m) <= group.of(noise_)).all();
    }
    isQuiet = isQuiet && !group.isOpen;
  }
  return isQuiet;
}

/// Sets e of the whole.
void EventSearch::findErrors(StepStates& states) {
  const double h = to_.t - from_.t;
  const Eigen::VectorXd* error = states.errorAt(middle_.t);
  if (error) accelerations_ = middle_.y + *error;
  Numbers& e = cuts_.front().e;
  for (const Group& group : groups_) {
    if (!group.isOpen) continue;
    const auto a = group.of(from_.g), b = group.of(to_.g), m = group.of(middle_.g);
    auto slopeA = group.of(from_.slope), slopeB = group.of(to_.slope);
    if (!group.functions->haveSlopes()) {
      slopeA = (4 * m - 3 * a - b) / h;
      slopeB = (a - 4 * m + 3 * b) / h;
      group.of(e) = 3. / 8 * (m - (a + b) / 2).abs();
      continue;
    }
    group.of(e) = (m - (a + b) / 2 - h / 8 * (slopeA - slopeB)).abs();
    if (!error) continue;
    group.functions->values(middle_.t, accelerations_.data(), values_.data());
    group.of(e) += (values_.head(group.count) - m).abs();
  }
}

/// The number of the first function that is left open between two samples; −1: there is none.
Eigen::Index EventSearch::firstOpen(const Sample& a, const Sample& b, const Numbers& errors) const {
  const double h = b.t - a.t;
  for (const Group& group : groups_) {
    if (!group.isOpen) continue;
    for (Eigen::Index i = group.first; i < group.first + group.count; ++i) {
      // Rounding since the last event may have lifted the start above 0.
      const double lift = std::max(0.0, a.g[i]), e2 = errors[i] * 8 / 3;
      const double c1 = a.g[i] + h / 4 * a.slope[i] - lift, c3 = b.g[i] - h / 4 * b.slope[i] - lift,
                   c2 = (a.g[i] + b.g[i]) / 2 + h / 6 * (a.slope[i] - b.slope[i]) - lift;
      const bool isOpen = b.g[i] > 0 ? (c1 > 0 && (c2 < e2 || c3 < 0)) || (c2 + e2 > 0 && c3 < 0)
                                     : std::max({c1, c2 + e2, c3}) > noise_[i];
      if (isOpen) return i;
    }
  }
  return -1;
}

/// The last look, from `depth` on: cuts [a, b], whose e is that of the cut before.
EventSearch::Result EventSearch::resolve(Sample& a, Sample& b, std::size_t depth, StepStates& states) {
  const Eigen::Index open = firstOpen(a, b, cuts_[depth - 1].e);
  // A function that is still open at the last cut is above 0 for a share of the step that moves nothing. If
  // so many steps do not decide, equal ones are unstable.
  const bool isLast = depth > deepest || cutsMade_ == mostCuts || stepsMade_ == mostSteps ||
                      !(b.t - a.t > narrowest(a.t, b.t - a.t));
  if (open < 0 || isLast) return mostOfOpen(b) > 0 ? setBracket(a, b) : Result::nothing;
  ++cutsMade_;
  if (!cut(a, b, open, depth, states)) return Result::notFinite;
  Sample& between = cuts_[depth].sample;
  const Result first = resolve(a, between, depth + 1, states);
  return first == Result::nothing ? resolve(between, b, depth + 1, states) : first;
}

/// Returns the share of [a, b] at which to cut: behind the first event if this function is not the one that
/// happens; else where its cubic is highest, or in the middle.
double EventSearch::shareOfCut(const Sample& a, const Sample& b, Eigen::Index open) const {
  const double h = b.t - a.t;
  const auto isWithin = [](double s) { return s >= leastShare && s <= 1 - leastShare; };
  if (b.g[open] > 0 || mostOfOpen(b) <= 0) {
    const double top = topOfCubic(a.g[open], h * a.slope[open], b.g[open], h * b.slope[open]);
    return isWithin(top) ? top : 0.5;
  }
  double first = 1;
  for (const Group& group : groups_) {
    for (Eigen::Index i = group.first; group.isOpen && i < group.first + group.count; ++i)
      if (b.g[i] > 0) first = std::min(first, zeroOfCubic(a.g[i], h * a.slope[i], b.g[i], h * b.slope[i]));
  }
  const double behind = first + leastShare * (1 - first);
  return isWithin(behind) ? behind : 0.5;
}

/// Sets the sample of a cut.
bool EventSearch::cut(const Sample& a, const Sample& b, Eigen::Index open, std::size_t depth,
                      StepStates& states) {
  const double h = b.t - a.t;
  double s = shareOfCut(a, b, open);
  Sample& c = cuts_[depth].sample;
  c.t = a.t + s * h;
  s = (c.t - a.t) / h;
  const double r = 1 - s;
  if (!states.errorAt(c.t)) {
    c.y = states.at(c.t);
    evaluate(c, true);
    findSlopes(c, states.accelerationsAt(c.t));
  } else {
    ++stepsMade_;
    if (!states.make(c.t, c.y, accelerations_)) return false;
    evaluate(c, true);
    findSlopes(c, accelerations_);
  }
  // The cubic differs from g by 16 e s² r². It is the sum of these.
  const double ofA = r * r * (r + 3 * s), ofB = s * s * (s + 3 * r), ofSlopeA = h * s * r * r,
               ofSlopeB = -h * r * s * s, ofError = 1 / (16 * s * s * r * r);
  for (const Group& group : groups_) {
    if (!group.isOpen) continue;
    const auto gA = group.of(a.g), gB = group.of(b.g);
    const auto gC = group.of(c.g);
    group.of(cuts_[depth].e) =
        ofError *
        (gC - ofA * gA - ofB * gB - ofSlopeA * group.of(a.slope) - ofSlopeB * group.of(b.slope)).abs();
    if (!group.functions->haveSlopes()) group.of(c.slope) = ((gC - gA) * (r / s) + (gB - gC) * (s / r)) / h;
  }
  return true;
}

/// The largest value of the functions that are open.
double EventSearch::mostOfOpen(const Sample& at) const {
  double most = never;
  for (const Group& group : groups_) {
    if (group.isOpen) most = std::max(most, group.of(at.g).maxCoeff());
  }
  return most;
}

EventSearch::Result EventSearch::setBracket(Sample& a, Sample& b) {
  if (&a != &from_) std::swap(a, from_);
  if (&b != &to_) std::swap(b, to_);
  isKnown_ = false;
  return Result::event;
}

// ---- The instant ---------------------------------------------------------------------------------------

double EventSearch::valueAt(double t, const Group& group, Eigen::Index i, StatesWithin& states) {
  if (t == from_.t) return from_.g[group.first + i];
  if (t == to_.t) return to_.g[group.first + i];
  if (middleBy_ == &states && t == middle_.t) return middle_.g[group.first + i];
  group.functions->values(t, states.at(t).data(), values_.data());
  return values_[i];
}

LocatedEvent EventSearch::locate(StatesWithin& states) {
  // The function that is first above 0 along the chord, then those that are so before.
  const Group* likelyOf = nullptr;
  Eigen::Index likely = 0;
  double least = std::numeric_limits<double>::infinity();
  const auto forAll = [&](const auto& visit) {
    for (const Group& group : groups_) {
      for (Eigen::Index i = 0; i < group.count; ++i)
        if (group.isOpen && to_.g[group.first + i] > 0) visit(group, i);
    }
  };
  forAll([&](const Group& group, Eigen::Index i) {
    const double ratio = -from_.g[group.first + i] / to_.g[group.first + i];
    if (likelyOf && !(ratio < least)) return;
    likelyOf = &group;
    likely = i;
    least = ratio;
  });
  LocatedEvent first = root(*likelyOf, likely, to_.t, states);
  forAll([&](const Group& group, Eigen::Index i) {
    if ((&group != likelyOf || i != likely) && valueAt(first.t, group, i, states) > 0)
      first = root(group, i, first.t, states);
  });
  return first;
}

/// The first time up to `last` at which a function is above 0, by no more than its noise and what it changes
/// by within rounding of t; or one so near behind it that rounding hides which is first: then `which` is −1.
LocatedEvent EventSearch::root(const Group& group, Eigen::Index i, double last, StatesWithin& states) {
  const double t0 = from_.t, h = to_.t - t0;
  const double begin = valueAt(t0, group, i, states), end = valueAt(to_.t, group, i, states);
  const double half = valueAt(t0 + h / 2, group, i, states);
  const double fastest = 2 * std::max(std::abs(half - begin), std::abs(end - half)) / h;
  const double narrow = narrowest(t0, h);
  group.functions->noise(to_.t, to_.y.data(), values_.data());
  const double beyond = narrow * fastest + values_[i];
  Interpolation curve;
  curve.add(0, begin - beyond / 2);
  curve.add(0.5, half - beyond / 2);
  curve.add(1, end - beyond / 2);
  LocatedEvent found{last, group.functions, -1, 0};
  double low = t0, high = last;
  while (high - low > narrow) {
    // Halve the interval if rounding leaves the polynomial no zero.
    double t = t0 + h * curve.zero((low - t0) / h, (high - t0) / h);
    const bool isOfUse = !curve.isFull() && t > low && t < high;
    if (!isOfUse) t = low + (high - low) / 2;
    const double value = valueAt(t, group, i, states), s = (t - t0) / h;
    if (isOfUse) curve.add(s, value - beyond / 2);
    if (value > 0 && value <= beyond) {
      found.t = t;
      found.which = static_cast<int>(i);
      curve.value(s, found.slope);
      found.slope /= h;
      return found;
    }
    (value > 0 ? high : low) = t;
  }
  found.t = high;
  return found;
}

}  // namespace planar_chain::ode
