#include "run/event_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "planar_chain/fault.h"

namespace planar_chain {

/// g of a state in chain order.
class EventWatch::Function final : public ode::EventFunctions {
 public:
  Function(const MotionEvent& event, std::size_t which, std::size_t n, const ToRelative& toRelative)
      : event_(event), which_(which), toRelative_(toRelative), q_(n), qd_(n), nearQ_(n), nearQd_(n) {}

  int most() const override { return 1; }
  void values(double t, const double* y, double* g) const override {
    toRelative_(t, y, q_, qd_);
    *g = valueOf(t, q_, qd_);
  }
  /// By what roundings of the state change. In two patterns, as they may cancel in one.
  void noise(double t, const double* y, double* of) const override {
    toRelative_(t, y, q_, qd_);
    const double g = valueOf(t, q_, qd_);
    *of = std::numeric_limits<double>::denorm_min();
    for (const bool isSecond : {false, true}) {
      for (std::size_t i = 0; i < q_.size(); ++i) {
        nearQ_[i] = q_[i] * (1 + roundings * (isSecond && i % 2 == 0 ? -0.75 : 1));
        nearQd_[i] = qd_[i] * (1 + roundings * (isSecond && i % 2 == 1 ? -0.75 : 1));
      }
      *of = std::max(*of, std::abs(valueOf(t, nearQ_, nearQd_) - g));
    }
  }

 private:
  static constexpr double roundings = 8 * std::numeric_limits<double>::epsilon();

  double valueOf(double t, const std::vector<double>& q, const std::vector<double>& qd) const {
    const double value = event_.g(t, q, qd);
    if (std::isfinite(value)) return value;
    throw Refused(
        {{"events/" + std::to_string(which_), "a finite number at t = " + toText(t) + " s", toText(value)}});
  }

  const MotionEvent& event_;
  std::size_t which_;
  const ToRelative& toRelative_;
  mutable std::vector<double> q_, qd_, nearQ_, nearQd_;
};

EventWatch::EventWatch(const std::vector<MotionEvent>& events, FoundEvents& found, bool goesOn,
                       const std::vector<double>& near, ode::SeriesSystem& f, int n,
                       const ToRelative& toRelative)
    : found_(found), before_(found.all.size()), toRelative_(toRelative), n_(static_cast<std::size_t>(n)) {
  std::vector<Fault> faults;
  std::vector<ode::WatchedSteps::Watched> watched;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const std::string path = "events/" + std::to_string(i);
    if (!events[i].g) faults.push_back({path, "a function g(t, q, qd)", "none"});
    if (events[i].terminal < 0)
      faults.push_back({path + "/terminal", "a number >= 0", std::to_string(events[i].terminal)});
    functions_.push_back(std::make_unique<Function>(events[i], i, n_, toRelative_));
    ode::WatchedSteps::Watched& one = watched.emplace_back();
    one = {functions_.back().get(), events[i].direction, events[i].terminal};
    if (i < near.size()) one.near = near[i];
    if (!goesOn) continue;
    one.side = found.signs[i];
    one.passed = std::count_if(found.all.begin(), found.all.end(),
                               [i](const FoundEvent& before) { return before.which == i; });
  }
  if (!faults.empty()) throw Refused(std::move(faults));
  steps_ = std::make_unique<ode::WatchedSteps>(watched, f);
}

EventWatch::~EventWatch() = default;

void EventWatch::take() {
  for (std::size_t k = found_.all.size() - before_; k < steps_->zeros().size(); ++k) {
    const auto& zero = steps_->zeros()[k];
    found_.all.push_back({zero.which, zero.t, std::vector<double>(n_), std::vector<double>(n_)});
    toRelative_(zero.t, zero.y.data(), found_.all.back().q, found_.all.back().qd);
  }
}

void EventWatch::goBack(double t) {
  steps_->goBack(t);
  found_.all.resize(before_ + steps_->zeros().size());
}

void EventWatch::end(double t, std::vector<double>& near) {
  near.assign(functions_.size(), 0);
  found_.signs.clear();
  for (std::size_t i = 0; i < functions_.size(); ++i) found_.signs.push_back(isOver() ? 0 : steps_->side(i));
  for (const auto& zero : steps_->zeros()) {
    if (zero.t == t) near[zero.which] = zero.near;
  }
  found_.terminal = steps_->terminal();
  if (steps_->failure()) std::rethrow_exception(steps_->failure());
}

}  // namespace planar_chain
