#include "report/benchmark/odeint_run.h"
#include "report/benchmark/pinocchio_chain.h"

/// Pinocchio computes accelerations and has no integrator: Boost.odeint's methods around its articulated-body
/// algorithm.

namespace planar_chain::benchmarks {

namespace {

class Articulated {
 public:
  using State = std::vector<double>;

  explicit Articulated(const Scene& scene)
      : coordinates_(scene.chain.coordinates()), chain_(pinocchioChain(scene.chain)) {
    relative_.resize(2 * scene.q.size());
  }
  int size() const { return 2 * coordinates_.size(); }
  double enter(double) { return std::numeric_limits<double>::infinity(); }
  void operator()(const State& y, State& dydt, double) {
    const int n = coordinates_.size();
    coordinates_.toRelative(y.data(), relative_.data());
    coordinates_.toRelative(y.data() + n, relative_.data() + n);
    chain_->place(relative_.data(), relative_.data() + n);
    std::copy_n(y.data() + n, n, dydt.data());
    coordinates_.toAbsolute(chain_->accelerations(), dydt.data() + n);
  }

 private:
  Coordinates coordinates_;
  std::unique_ptr<PinocchioChain> chain_;
  State relative_;
};

bool takes(const Scene& scene) {
  return !scene.tip && scene.loads.empty() && scene.chain.size() <= 100;
}

}  // namespace

Team pinocchioTeam() {
  return {"Pinocchio",
          std::string(pinocchioVersion()) + " (ABA, header-only, for this processor; odeint of " +
              odeintVersion() + ")",
          {contestant<OdeintRun<Articulated, Fehlberg>>("Pinocchio", "odeint Fehlberg 7(8)", false, takes),
           contestant<OdeintRun<Articulated, DormandPrince>>("Pinocchio", "odeint Dormand-Prince 5(4)", false,
                                                             takes)}};
}

}  // namespace planar_chain::benchmarks
