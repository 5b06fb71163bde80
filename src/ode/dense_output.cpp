#include "ode/dense_output.h"

#include <cmath>

#include "ode/integrator.h"

namespace planar_chain::ode {

DenseOutput::DenseOutput(SeriesSystem& f)
    : f_(f),
      vectors_(f.vectors()),
      n_(f.firstRate()),
      turn_(n_),
      quartic_(n_),
      increment_(2 * n_),
      restored_(f.size()),
      quarticInOrder_(restored_),
      at_(f.sizeInLaneOrder()),
      rates_(at_),
      error_(at_),
      slope_(at_) {
  for (Accelerations& one : accelerations_) one.values = restored_;
  forgetStates();
  slope_.setZero();
  within_ = State(f.sizeInLaneOrder());
  for (End* end : {&start_, &end_}) {
    end->state = State(f.sizeInLaneOrder());
    end->slope = rates_;
  }
}

void DenseOutput::begin(const State& from) {
  startAt(from);
  if (!start_.isKnown) evaluate(start_);
}

void DenseOutput::startAt(const State& from) {
  const auto isAt = [&](const End& end) {
    return end.isKnown && end.state.t == from.t && end.state.y == from.y;
  };
  if (isAt(end_)) std::swap(start_, end_);
  end_.isKnown = false;
  if (isAt(start_)) return;
  start_.state = from;
  start_.isKnown = false;
}

void DenseOutput::forget() {
  start_.isKnown = end_.isKnown = false;
  polynomial_ = nullptr;
  forgetStates();
}

void DenseOutput::saveOrRestore(Snapshot& snapshot) {
  for (End* end : {&start_, &end_}) {
    snapshot(end->isKnown);
    if (end->isKnown) snapshot(end->state, end->slope);
  }
}

void DenseOutput::take(const State& from, const State& to, Integrator* polynomial) {
  polynomial_ = polynomial;
  startAt(from);
  end_.state = to;
  isQuarticKnown_ = isTurnKnown_ = false;
  h_ = to.t - from.t;
  turn_ = (to.y.head(n_) - from.y.head(n_)) + (to.carry.head(n_) - from.carry.head(n_));
  forgetStates();
}

void DenseOutput::forgetStates() {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  time_ = timeRestored_ = none;
  for (Accelerations& known : accelerations_) known.t = none;
  isQuarticInOrder_ = false;
}

void DenseOutput::evaluate(End& end) const {
  f_.slope(end.state.t, end.state.y.data(), end.slope.data());
  end.isKnown = true;
}

/// The end first: f was evaluated there last.
void DenseOutput::findRates() const {
  if (!end_.isKnown) evaluate(end_);
  if (!start_.isKnown) evaluate(start_);
  if (isTurnKnown_) return;
  isTurnKnown_ = true;
  // The rounding of angles is a rate of 1e-6 rad/s in a step of 1e-10 s: there the rates alone tell the turn.
  constexpr double rounding = 32 * std::numeric_limits<double>::epsilon();
  const auto v0 = start_.state.y.segment(n_, n_).array(), v1 = end_.state.y.segment(n_, n_).array();
  const auto a0 = start_.rates(n_).array(), a1 = end_.rates(n_).array();
  const auto change = h_ * h_ / 12 * (a0 - a1);
  const auto byRates = h_ / 2 * (v0 + v1) + change;
  const auto size = start_.state.y.head(n_).array().abs() + end_.state.y.head(n_).array().abs();
  turn_ = ((turn_.array() - byRates).abs() <= rounding * size).select(byRates, turn_.array());
  // A projection moves every position by some rounding of the largest, and by more than that. In so short a
  // step that the change of α turns nothing, the rates alone tell the turn, too.
  if (f_.freedoms() == f_.size()) return;
  turn_ = (change.abs() <= rounding * (1 + size.maxCoeff())).select(byRates, turn_.array());
}

void DenseOutput::findQuartic() const {
  if (isQuarticKnown_) return;
  f_.slope(middle(), inLaneOrderAt(middle()).data(), rates_.data());
  const auto v0 = start_.state.y.segment(n_, n_), v1 = end_.state.y.segment(n_, n_);
  const auto a0 = start_.rates(n_), a1 = end_.rates(n_);
  quartic_ = 8. / 3 * h_ * (1.5 * (v1 - v0) - h_ * ((a0 + a1) / 4 + rates_.segment(n_, n_)));
  isQuarticKnown_ = true;
}

const Eigen::VectorXd& DenseOutput::at(double t) const {
  if (t != timeRestored_) f_.toChainOrder(inLaneOrderAt(t).data(), restored_.data());
  timeRestored_ = t;
  return restored_;
}

const Vector& DenseOutput::inLaneOrderAt(double t) const {
  const State &from = start_.state, &to = end_.state;
  if (t == time_) return at_;
  if (t == to.t) {
    at_ = to.y;
  } else if (polynomial_) {
    within_ = from;
    polynomial_->lookTo(within_, t);
    at_ = within_.y;
  } else {
    findRates();
    const bool hasQuartic = t != middle();
    if (hasQuartic) findQuartic();
    const double h = h_, s = (t - from.t) / h, s2 = s * s, s3 = s2 * s, s4 = s2 * s2, s5 = s2 * s3,
                 r = s - s2;
    // What is added to y includes what rounding left of it: from.carry, turn_, v_0, v_1, α_0, α_1, d.
    const double ofAngles[] = {1,
                               s3 * (10 - 15 * s + 6 * s2),
                               h * (s - 6 * s3 + 8 * s4 - 3 * s5),
                               h * (7 * s4 - 4 * s3 - 3 * s5),
                               h * h / 2 * (s2 - 3 * s3 + 3 * s4 - s5),
                               h * h / 2 * (s3 - 2 * s4 + s5),
                               r * r * r};
    const double ofRates[] = {1,
                              30 / h * r * r,
                              32 * s3 - 18 * s2 - 15 * s4,
                              28 * s3 - 12 * s2 - 15 * s4,
                              h * (s - 4.5 * s2 + 6 * s3 - 2.5 * s4),
                              h * (1.5 * s2 - 4 * s3 + 2.5 * s4),
                              3 / h * r * r * (1 - 2 * s)};
    const double* terms[] = {
        from.carry.data(),        turn_.data(),           from.y.data() + n_, to.y.data() + n_,
        start_.slope.data() + n_, end_.slope.data() + n_, quartic_.data()};
    const auto combine = vectors_.combine[hasQuartic ? 6 : 5];
    combine(1, ofAngles, terms, from.y.data(), increment_.data(), at_.data(), n_);
    terms[0] += n_;
    combine(1, ofRates, terms, from.y.data() + n_, increment_.data() + n_, at_.data() + n_, n_);
    at_.tail(at_.size() - 2 * n_) = from.y.tail(at_.size() - 2 * n_);
  }
  time_ = t;
  return at_;
}

const Eigen::VectorXd& DenseOutput::accelerationsAt(double t) const {
  for (const Accelerations& known : accelerations_) {
    if (known.t == t) return known.values;
  }
  if (polynomial_) {
    constexpr double share = 1e-4;  // of the step: beside it, the difference has an error of 1e-8
    const double to = t + share * h_, from = t - share * h_;
    slope_.head(n_) = inLaneOrderAt(to).segment(n_, n_);
    slope_.head(n_) = (slope_.head(n_) - inLaneOrderAt(from).segment(n_, n_)) / (to - from);
  } else {
    findRates();
    const double h = h_, s = (t - start_.state.t) / h, s2 = s * s, s3 = s2 * s;
    if (t == start_.state.t) {
      slope_.head(n_) = start_.rates(n_);
    } else if (t == end_.state.t) {
      slope_.head(n_) = end_.rates(n_);
    } else {
      slope_.head(n_) = 60 / (h * h) * (s - s2) * (1 - 2 * s) * turn_ +
                        12 / h * (8 * s2 - 3 * s - 5 * s3) * start_.state.y.segment(n_, n_) +
                        12 / h * (7 * s2 - 2 * s - 5 * s3) * end_.state.y.segment(n_, n_) +
                        (1 - 9 * s + 18 * s2 - 10 * s3) * start_.rates(n_) +
                        (3 * s - 12 * s2 + 10 * s3) * end_.rates(n_);
    }
  }
  next_ = (next_ + 1) % accelerations_.size();
  Accelerations& found = accelerations_[next_];
  f_.toChainOrder(slope_.data(), found.values.data());
  found.t = t;
  return found.values;
}

const Eigen::VectorXd& DenseOutput::quarticTerm() const {
  if (isQuarticInOrder_) return quarticInOrder_;
  findRates();
  findQuartic();
  slope_.head(n_) = quartic_;
  f_.toChainOrder(slope_.data(), quarticInOrder_.data());
  isQuarticInOrder_ = true;
  return quarticInOrder_;
}

const Vector& DenseOutput::errorAt(double t) const {
  if (polynomial_) {
    error_.setZero();
    return error_;
  }
  findRates();
  findQuartic();
  const double s = (t - start_.state.t) / h_, r = s - s * s;
  error_.head(n_) = r * r * r * quartic_;
  error_.segment(n_, n_) = 3 / h_ * r * r * quartic_;
  return error_;
}

void DenseOutput::land(double t, State& state) const {
  if (t == end_.state.t) {
    state = end_.state;
    return;
  }
  if (polynomial_) {
    state = start_.state;
    polynomial_->stepTo(state, t);
    return;
  }
  // The works by the shorter way, from the start or from the end.
  const bool isNearEnd = t > middle();
  state = isNearEnd ? end_.state : start_.state;
  const double way = t - state.t;
  const auto next = inLaneOrderAt(t).head(2 * n_);
  state.carry.head(2 * n_) = (start_.state.y.head(2 * n_) - next) + increment_;
  state.y.head(2 * n_) = next;
  if (const Eigen::Index works = at_.size() - 2 * n_; works > 0 && f_.hasIntegrands()) {
    const double apart = std::sqrt(0.6);
    const std::pair<double, double> nodes[] = {{1 - apart, 5. / 18}, {1, 8. / 18}, {1 + apart, 5. / 18}};
    for (const auto& [node, weight] : nodes) {
      const double then = state.t + way * node / 2;
      f_.integrands(then, at(then).data(), rates_.data());
      state.y.tail(works) += way * weight * rates_.head(works);
    }
  }
  state.t = t;
}

}  // namespace planar_chain::ode
