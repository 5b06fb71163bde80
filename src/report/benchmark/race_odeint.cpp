#include <array>

#include "report/benchmark/by_hand.h"
#include "report/benchmark/odeint_run.h"

/// Boost.odeint's methods with error control, Fehlberg 7(8) if no other is named: under the equations that an
/// expert writes by hand (closed form for two links and for a cart with a pole, else mass matrix and
/// Cholesky), and under this program's.

namespace planar_chain::benchmarks {

namespace {

class ByHand {
 public:
  using State = std::vector<double>;

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

/// A pole on a cart whose rail is level, r from the pin to its centre of mass, J = I + m r²:
///
///     (m_c + m) s̈ − m r sin θ θ̈ = m r cos θ θ̇²
///     −m r sin θ s̈ + J θ̈ = −m r g cos θ
class CartPoleByHand {
 public:
  using State = std::array<double, 4>;

  explicit CartPoleByHand(const Scene& scene) {
    const Link &cart = scene.chain.links()[0], &pole = scene.chain.links()[1];
    mass_ = cart.mass + pole.mass;
    reach_ = pole.mass * pole.com.x;
    inertia_ = pole.inertia + reach_ * pole.com.x;
    g_ = -scene.chain.gravity().y;
  }
  static bool takes(const Scene& scene) {
    const Chain& chain = scene.chain;
    return chain.coordinates().leading() == 1 && chain.size() == 2 && chain.joints()[0].axis.y == 0 &&
           chain.joints()[0].axis.x > 0 && chain.links()[1].com.y == 0 && chain.gravity().x == 0;
  }
  int size() const { return 4; }
  double enter(double) { return std::numeric_limits<double>::infinity(); }
  void operator()(const State& y, State& dydt, double) const {
    const double c = std::cos(y[1]), s = std::sin(y[1]);
    const double b = -reach_ * s, along = reach_ * c * y[3] * y[3], turning = -reach_ * g_ * c;
    const double inverse = 1 / (mass_ * inertia_ - b * b);
    dydt = {y[2], y[3], (inertia_ * along - b * turning) * inverse, (mass_ * turning - b * along) * inverse};
  }

 private:
  double mass_, reach_, inertia_, g_;
};

class Own {
 public:
  using State = std::vector<double>;

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

}  // namespace

Team byHandTeam() {
  const auto takes = [](const Scene& scene) {
    const Link& first = scene.chain.links()[0];
    return isPinned(scene) && scene.loads.empty() && !hasSprings(scene) && scene.chain.size() <= 100 &&
           first.com.y == 0;
  };
  const auto takesCart = [](const Scene& scene) { return CartPoleByHand::takes(scene); };
  return {
      "by hand",
      "closed form or Cholesky, " + odeintVersion() + " odeint",
      {contestant<OdeintRun<ByHand, Fehlberg>>("by hand", "odeint Fehlberg 7(8)", false, takes),
       contestant<OdeintRun<CartPoleByHand, Fehlberg>>("by hand", "odeint Fehlberg 7(8)", false, takesCart),
       contestant<OdeintRun<CartPoleByHand, DormandPrince>>("by hand", "odeint Dormand-Prince 5(4)", false,
                                                            takesCart),
       contestant<OdeintRun<CartPoleByHand, BulirschStoer>>("by hand", "odeint Bulirsch-Stoer", false,
                                                            takesCart)}};
}

Team odeintTeam() {
  return {"odeint",
          odeintVersion() + " under this program's equations",
          {contestant<OdeintRun<Own, Fehlberg>>("odeint", "Fehlberg 7(8)", false,
                                                [](const Scene&) { return true; })}};
}

}  // namespace planar_chain::benchmarks
