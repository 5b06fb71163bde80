#include <boost/numeric/odeint.hpp>
#include <boost/version.hpp>

#include "report/benchmark/by_hand.h"
#include "report/benchmark/race.h"
#include "report/own.h"

/// Boost.odeint's Fehlberg 7(8) with error control: under the equations that an expert writes by hand (closed
/// form for two links, else mass matrix and Cholesky), and under this program's.

namespace planar_chain::benchmarks {

namespace {

using State = std::vector<double>;

class ByHand {
 public:
  explicit ByHand(const Scene& scene)
      : n_(scene.chain.size()),
        equations_(n_ == 2 ? doublePendulumByHand(scene.chain) : denseByHand(scene.chain)) {}
  int size() const { return 2 * n_; }
  double enter(double) { return std::numeric_limits<double>::infinity(); }
  void operator()(const State& y, State& dydt, double) {
    equations_->place(y.data(), y.data() + n_);
    equations_->evaluate();
    std::copy_n(y.data() + n_, n_, dydt.data());
    std::copy_n(equations_->alpha().data(), n_, dydt.data() + n_);
  }

 private:
  int n_;
  std::unique_ptr<InAbsoluteAngles> equations_;
};

class Own {
 public:
  explicit Own(const Scene& scene) : dynamics_(scene) {}
  int size() const { return dynamics_.size(); }
  /// From t on; until when.
  double enter(double t) {
    dynamics_.enter(t);
    return dynamics_.effects().until();
  }
  void operator()(const State& y, State& dydt, double t) { dynamics_.derivative(t, y.data(), dydt.data()); }

 private:
  Dynamics dynamics_;
};

template <class Equations>
class OdeintRun : public tools::Run {
 public:
  OdeintRun(const Contest& contest, double setting)
      : n_(contest.scene.chain.size()),
        end_(contest.end),
        equations_(contest.scene),
        y_(static_cast<std::size_t>(equations_.size())),
        stepper_(boost::numeric::odeint::make_controlled<Fehlberg>(setting, setting)) {
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
      if (stepper_.try_step(count, y_, t_, h_) == boost::numeric::odeint::success) {
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
  using Fehlberg = boost::numeric::odeint::runge_kutta_fehlberg78<State>;

  int n_;
  double end_, until_ = 0, t_ = 0, h_ = 1e-3;
  Equations equations_;
  State y_;
  boost::numeric::odeint::controlled_runge_kutta<Fehlberg> stepper_;
  tools::Counts counts_;
};

std::string version() {
  return "Boost " + std::to_string(BOOST_VERSION / 100000) + "." + std::to_string(BOOST_VERSION / 100 % 1000);
}

}  // namespace

Team byHandTeam() {
  const auto takes = [](const Scene& scene) {
    const Link& first = scene.chain.links()[0];
    return scene.loads.empty() && !hasSprings(scene) && scene.chain.size() <= 100 && first.com.y == 0;
  };
  return {"by hand",
          "closed form or Cholesky, " + version() + " odeint",
          {contestant<OdeintRun<ByHand>>("by hand", "odeint Fehlberg 7(8)", false, takes)}};
}

Team odeintTeam() {
  return {"odeint",
          version() + " under this program's equations",
          {contestant<OdeintRun<Own>>("odeint", "Fehlberg 7(8)", false, [](const Scene&) { return true; })}};
}

}  // namespace planar_chain::benchmarks
