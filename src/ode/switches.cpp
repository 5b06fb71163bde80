#include "planar_chain/ode/switches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace planar_chain::ode {

namespace {

class LandingOnSwitches : public Integrator {
 public:
  LandingOnSwitches(std::unique_ptr<Integrator> steps, const Switches& switches, const System& f)
      : steps_(std::move(steps)),
        switches_(switches),
        f_(f),
        before_(f.arrangedSize()),
        trial_(before_),
        y_(f.size()),
        yBefore_(y_) {}

  const char* name() const override { return steps_->name(); }
  void restart() override { steps_->restart(); }
  void begin() override { steps_->begin(); }
  const StepCount& count() const override { return steps_->count(); }
  bool stepTo(State& state, double t) override { return steps_->stepTo(state, t); }

  Outcome advance(State& state, double end, double longestStep) override {
    before_ = state;
    const Outcome outcome = steps_->advance(state, end, longestStep);
    if (outcome != Outcome::arrived && outcome != Outcome::underway) return outcome;
    if (due(state) > 0) return land(state);
    f_.restore(before_.y.data(), yBefore_.data());
    const double passing = switches_.nearest(yBefore_, y_, state.t - before_.t);
    if (passing <= 0 || !(tryTo(before_.t + passing) > 0)) return outcome;
    state = trial_;
    return land(state);
  }

 private:
  /// Leaves the restored state in y_.
  double due(const State& state) {
    f_.restore(state.y.data(), y_.data());
    return switches_.due(y_);
  }

  /// What is due at t; trial_ is the state there.
  double tryTo(double t) {
    trial_ = before_;
    return steps_->stepTo(trial_, t) ? due(trial_) : std::numeric_limits<double>::quiet_NaN();
  }

  /// Something is due at state and was not before: to the first numbers at which it is.
  Outcome land(State& state) {
    constexpr double narrow = 4 * std::numeric_limits<double>::epsilon();
    constexpr double leastShare = 1. / 64;  // of the bracket, cut off each time
    double low = before_.t;
    double dueLow = due(before_);
    double dueHigh = due(state);
    int side = 0;  // of the bracket that moved last
    while (state.t - low > narrow * std::max(std::abs(state.t), state.t - before_.t)) {
      const double share = -dueLow / (dueHigh - dueLow);
      const double t = low + (state.t - low) * std::min(std::max(share, leastShare), 1 - leastShare);
      if (t <= low || t >= state.t) break;
      const double due = tryTo(t);
      if (std::isnan(due)) {
        state = before_;
        return Outcome::notFinite;
      }
      if (due > 0) {
        state = trial_;
        dueHigh = due;
        if (side > 0) dueLow /= 2;
        side = 1;
      } else {
        low = t;
        dueLow = due;
        if (side < 0) dueHigh /= 2;
        side = -1;
      }
    }
    return Outcome::switched;
  }

  std::unique_ptr<Integrator> steps_;
  const Switches& switches_;
  const System& f_;
  State before_, trial_;
  Eigen::VectorXd y_, yBefore_;
};

}  // namespace

std::unique_ptr<Integrator> landingOnSwitches(std::unique_ptr<Integrator> steps, const Switches& switches,
                                              const System& f) {
  return std::make_unique<LandingOnSwitches>(std::move(steps), switches, f);
}

}  // namespace planar_chain::ode
