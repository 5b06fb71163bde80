#pragma once

/// The last step of an integrator, and the states within it.

#include "ode/dense_output.h"
#include "ode/event_search.h"
#include "ode/integrator.h"

namespace planar_chain::ode {

/// By the dense output, or by shorter steps from the same start. Only the constructor allocates.
class LastStep final : public StepStates {
 public:
  /// f must outlive this object.
  explicit LastStep(SeriesSystem& f)
      : dense(f),
        before(f.sizeInLaneOrder()),
        trial(before),
        f_(f),
        rates_(before.y),
        y_(Eigen::VectorXd::Zero(f.size())),
        error_(y_) {}
  /// The integrator that makes the steps. It must outlive this object.
  void use(Integrator& steps) { steps_ = &steps; }

  DenseOutput dense;
  State before;  ///< where the step starts
  State trial;   ///< where the last shorter one has ended

  /// The step ends here. A polynomial knows its states for nothing.
  void take(const State& to) { dense.take(before, to, steps_->pieces() > 1 ? steps_ : nullptr); }

  const Eigen::VectorXd& at(double t) override { return dense.at(t); }
  const Eigen::VectorXd& accelerationsAt(double t) override { return dense.accelerationsAt(t); }
  const Eigen::VectorXd* errorAt(double t) override {
    if (isExactAt(t)) return nullptr;
    f_.toChainOrder(dense.errorAt(t).data(), error_.data());
    return &error_;
  }
  bool make(double t, Eigen::VectorXd& y, Eigen::VectorXd& accelerations) override {
    if (!stepTo(t)) return false;
    f_.toChainOrder(trial.y.data(), y.data());
    const Eigen::Index n = f_.firstRate();
    f_.slope(t, trial.y.data(), rates_.data());
    rates_.head(n) = rates_.segment(n, n);  // they do not overlap
    f_.toChainOrder(rates_.data(), accelerations.data());
    return true;
  }

  /// True if the error of the dense output there is at most this share of the one that a step may add.
  bool isExactAt(double t, double share = 1) const {
    return dense.isKnown() && steps_->errorNorm(before.y, t - before.t, dense.errorAt(t)) <= share;
  }
  /// Sets `trial` to the state at t, by a step. Returns false if it is not finite.
  bool stepTo(double t) {
    if (steps_->pieces() == 1) ++made_;  // else the step is a polynomial, and costs nothing
    trial = before;
    return steps_->stepTo(trial, t);
  }
  /// Valid until the next call.
  const Eigen::VectorXd& inOrder(const State& state) {
    f_.toChainOrder(state.y.data(), y_.data());
    return y_;
  }
  /// Counts the shorter steps.
  long long& made() { return made_; }
  long long made() const { return made_; }

 private:
  SeriesSystem& f_;
  Integrator* steps_ = nullptr;
  Vector rates_;
  Eigen::VectorXd y_, error_;
  long long made_ = 0;
};

/// The states within by shorter steps alone.
class ByShorterSteps final : public StatesWithin {
 public:
  explicit ByShorterSteps(LastStep& of) : of_(of) { of_.trial = of_.before; }
  const Eigen::VectorXd& at(double t) override {
    if (of_.trial.t != t) areFinite_ = of_.stepTo(t) && areFinite_;
    return of_.inOrder(of_.trial);
  }
  /// False: a step is not finite.
  bool areFinite() const { return areFinite_; }

 private:
  LastStep& of_;
  bool areFinite_ = true;
};

}  // namespace planar_chain::ode
