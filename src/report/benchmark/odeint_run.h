#pragma once

/// Runs of Boost.odeint's methods with error control.

#include <boost/numeric/odeint.hpp>
#include <boost/version.hpp>

#include "report/benchmark/race.h"
#include "report/own_methods.h"

namespace planar_chain::benchmarks {

namespace odeint = boost::numeric::odeint;

template <class State>
State zeros(std::size_t size) {
  if constexpr (std::is_constructible_v<State, std::size_t>) {
    return State(size);
  } else {
    return {};
  }
}

template <class State>
using Fehlberg = odeint::controlled_runge_kutta<odeint::runge_kutta_fehlberg78<State>>;
template <class State>
using DormandPrince = odeint::controlled_runge_kutta<odeint::runge_kutta_dopri5<State>>;
template <class State>
using BulirschStoer = odeint::bulirsch_stoer<State>;

/// The setting is the absolute and the relative tolerance.
template <class Stepper>
Stepper controlled(double setting) {
  if constexpr (std::is_same_v<Stepper, BulirschStoer<typename Stepper::state_type>>) {
    return Stepper(setting, setting);
  } else {
    return Stepper(typename Stepper::error_checker_type(setting, setting));
  }
}

template <class Equations, template <class> class Method>
class OdeintRun : public tools::Run {
 public:
  using State = typename Equations::State;
  using Stepper = Method<State>;

  OdeintRun(const Contest& contest, double setting)
      : n_(contest.scene.chain.size()),
        end_(contest.end),
        equations_(contest.scene),
        y_(zeros<State>(static_cast<std::size_t>(equations_.size()))),
        stepper_(controlled<Stepper>(setting)) {
    tools::readStart(contest.scene, y_.data(), y_.data() + n_);
    until_ = std::min(end_, equations_.enter(0));
  }

  /// One that succeeds; its tries count as rejected.
  Progress step() override {
    for (;;) {
      const double left = until_ - t_;
      const bool isLast = h_ >= left * (1 - 1e-12);
      const double before = h_;
      if (isLast) h_ = left;
      const double tried = h_;
      const auto count = [this](const State& y, State& dydt, double t) {
        ++counts_.evaluations;
        equations_(y, dydt, t);
      };
      if (stepper_.try_step(count, y_, t_, h_) == odeint::success) {
        ++counts_.steps;
        if (isLast) t_ = until_;
        if (isLast && tried < before) h_ = std::max(h_, before);
        break;
      }
      ++counts_.rejected;
      if (!(h_ > 1e-15 * std::max(1.0, t_)))
        return std::isfinite(h_) ? Progress::refused : Progress::diverged;
    }
    if (!std::isfinite(y_[static_cast<std::size_t>(n_ - 1)])) return Progress::diverged;
    if (t_ >= end_) return Progress::arrived;
    if (t_ >= until_) until_ = std::min(end_, equations_.enter(t_));
    return Progress::underway;
  }
  tools::Counts counts() const override { return counts_; }
  void read(double* theta, double* omega) const override {
    std::copy_n(y_.data(), n_, theta);
    std::copy_n(y_.data() + n_, n_, omega);
  }

 private:
  int n_;
  double end_, until_ = 0, t_ = 0, h_ = 1e-3;
  Equations equations_;
  State y_;
  Stepper stepper_;
  tools::Counts counts_;
};

inline std::string odeintVersion() {
  return "Boost " + std::to_string(BOOST_VERSION / 100000) + "." + std::to_string(BOOST_VERSION / 100 % 1000);
}

}  // namespace planar_chain::benchmarks
