#pragma once

/// Watches functions along the steps of an integrator, for a caller. The motion does not depend on them.
///
/// A zero of g is where g leaves one side of 0 for the other, or reaches 0 from a side. The search is that of
/// events.h, for the function −g on the positive side and g on the negative one. The states at the zeros
/// are those of the dense output where it is exact, else of shorter steps from the same start.
///
/// Where g is 0 within its noise, it has no side: at a start, and behind each zero. Then it takes the first
/// side that it shows. So a zero where a motion starts is none, and no zero is found twice.

#include <exception>
#include <memory>
#include <optional>
#include <vector>

#include "ode/events.h"
#include "ode/last_step.h"

namespace planar_chain::ode {

/// Allocates. An exception of a function ends the steps: see failure().
class WatchedSteps final : public StepsOf {
 public:
  struct Watched {
    const EventFunctions* g;  ///< one function, whose values and noise count
    int direction = 0;        ///< > 0: only zeros at which it rises count; < 0: at which it falls
    long long terminal = 0;   ///< the steps end at the zero of this number; 0: at none
    double near = 0;          ///< where the steps begin, it is 0 if its size is at most this
    int side = 0;             ///< the sign that it has there; 0: to be found
    long long passed = 0;     ///< zeros that have counted before
  };
  struct Zero {
    std::size_t which;  ///< of the functions
    double t;
    Eigen::VectorXd y;  ///< in chain order
    double near;        ///< the size of g
  };

  /// f and the functions must outlive this object.
  WatchedSteps(const std::vector<Watched>& functions, SeriesSystem& f);
  /// The integrator that makes the next steps.
  void use(Integrator& steps) {
    steps_.release();
    steps_.reset(&steps);
    last_.use(steps);
  }
  ~WatchedSteps() override { steps_.release(); }

  /// Makes a step, which ends at the first terminal zero. Then, and after a failure of a function, it returns
  /// `arrived`, or what the step was, if that ends there anyway.
  Outcome advance(State& state, double end, double longestStep) override;
  /// True if the steps have ended at a terminal zero, or as a function failed.
  bool isOver() const { return terminal_ || failure_; }
  /// The number of the function whose zero it is.
  std::optional<std::size_t> terminal() const { return terminal_; }
  std::exception_ptr failure() const { return failure_; }
  /// In the order of time.
  const std::vector<Zero>& zeros() const { return zeros_; }
  /// The motion goes back to this time.
  void goBack(double t);
  /// The side of a function at the end of the last step; 0: it is 0, or unknown.
  int side(std::size_t which) const { return watches_[which]->function.side; }

 private:
  /// g on the negative side, −g on the positive one; just above 0 where g is 0.
  struct OneSide final : EventFunctions {
    OneSide(const EventFunctions& g_, SeriesSystem& f, std::exception_ptr& failure_)
        : g(g_), failure(failure_), n(f.driving() / 2), near(Eigen::VectorXd::Zero(f.size())) {}
    int most() const override { return 1; }
    void values(double t, const double* y, double* to) const override;
    void noise(double t, const double* y, double* of) const override;
    bool haveSlopes() const override { return true; }
    void slopes(double t, const double* y, const double* accelerations, double* slope) const override;
    double at(double t, const Eigen::VectorXd& y) const;
    const EventFunctions& g;
    std::exception_ptr& failure;
    const Eigen::Index n;  ///< of q
    int side = 0;          ///< 0: g is 0
    double apart = 0;      ///< of the states for a slope, s
    mutable Eigen::VectorXd near;
  };
  class States;
  struct Watch {
    Watch(const Watched& of, SeriesSystem& f, std::exception_ptr& failure);
    Watched watched;
    OneSide function;
    EventSearch search;
    double near = 0;        ///< beside its noise, where it is 0
    double zeroAt = never;  ///< the last zero, s
    long long passed = 0;   ///< zeros that count
  };

  void searchStep(Watch& watch, std::size_t which, double end, double& last);
  double leaveZero(Watch& watch, double from, double end, StatesWithin& states);
  void takeZero(Watch& watch, std::size_t which, const LocatedEvent& located, double from,
                StatesWithin& states, double& last);

  LastStep last_;
  double stepBefore_ = never;  ///< where the step before it started, s
  std::vector<std::unique_ptr<Watch>> watches_;
  std::vector<Zero> zeros_;
  std::optional<std::size_t> terminal_;
  std::exception_ptr failure_;
};

}  // namespace planar_chain::ode
