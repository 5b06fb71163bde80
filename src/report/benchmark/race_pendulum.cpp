#include <array>
#include <boost/numeric/odeint.hpp>

#include "planar_chain/simulation.h"
#include "report/benchmark/race.h"

/// ẍ = −sin x from 1.3 rad for 10⁴ s: Boost.odeint's Fehlberg 7(8) at 1e-15, the equation by hand, and the
/// whole simulation with taylor. Then a double pendulum by taylor, 1000 s there and back.

namespace planar_chain::benchmarks {

namespace {

constexpr double start = 1.3, end = 1e4;

/// x = 2 asin(k sn(K − t)), k = sin(start/2), by arithmetic-geometric means: M. Abramowitz, I. Stegun,
/// Handbook of Mathematical Functions (1964), 16.4 and 17.6.
double exact(double t) {
  constexpr int means = 8;
  const long double k = std::sin(start / 2.0L);
  std::array<long double, means + 1> a{1}, c{k};
  long double b = std::sqrt(1 - k * k);
  for (std::size_t i = 0; i < means; ++i) {
    a[i + 1] = (a[i] + b) / 2;
    c[i + 1] = (a[i] - b) / 2;
    b = std::sqrt(a[i] * b);
  }
  const long double quarter = std::acos(-1.0L) / (2 * a[means]);
  long double phi =
      std::ldexp(a[means] * (quarter - std::fmod(static_cast<long double>(t), 4 * quarter)), means);
  for (std::size_t i = means; i > 0; --i) phi = (phi + std::asin(c[i] / a[i] * std::sin(phi))) / 2;
  return static_cast<double>(2 * std::asin(k * std::sin(phi)));
}

double byOdeint() {
  namespace odeint = boost::numeric::odeint;
  using State = std::array<double, 2>;
  State y{start, 0};
  const auto equation = [](const State& at, State& rates, double) { rates = {at[1], -std::sin(at[0])}; };
  auto fehlberg = odeint::make_controlled<odeint::runge_kutta_fehlberg78<State>>(1e-15, 1e-15);
  odeint::integrate_adaptive(std::ref(fehlberg), equation, y, 0.0, end, 1e-3);
  return y[0];
}

IntegratorSettings taylorAt(double tolerance) {
  IntegratorSettings settings;
  settings.method = "taylor";
  settings.tolerance = tolerance;
  return settings;
}

/// Hanging along x, so that the angle of the link is x.
double bySimulation(double tolerance) {
  Simulation simulation({Chain({{"rod", 1, 1, {1, 0}, {1, 0}}}, {{"joint"}}, {2, 0}),
                         {start},
                         {0},
                         {},
                         taylorAt(tolerance),
                         {},
                         0});
  return simulation.advanceTo(end) ? simulation.q()[0] : std::numeric_limits<double>::quiet_NaN();
}

/// How far from its start two rods are after `duration`, and as long with reversed rates.
double thereAndBack(double duration, double tolerance) {
  const Link rod{"", 1, 1. / 12, {0.5, 0}, {1, 0}};
  Link upper = rod, lower = rod;
  upper.name = "upper";
  lower.name = "lower";
  const std::vector<double> q{0.05 - pi / 2, 0.025 - 0.05};
  Simulation simulation(
      {Chain({upper, lower}, {{"first"}, {"second"}}, {0, -9.8}), q, {0, 0}, {}, taylorAt(tolerance), {}, 0});
  simulation.advanceTo(duration);
  simulation.setState(simulation.q(), {-simulation.qd()[0], -simulation.qd()[1]});
  simulation.advanceTo(2 * duration);
  double worst = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    worst = std::max({worst, std::abs(simulation.q()[i] - q[i]), std::abs(simulation.qd()[i])});
  }
  return worst;
}

}  // namespace

void pendulum(const tools::Arguments& given) {
  const double reference = exact(end), errorOfOdeint = std::abs(byOdeint() - reference);
  std::puts("tolerance,seconds,error,odeint_seconds,odeint_error,ratio,there_and_back");
  for (const double tolerance : {1e-15, 1e-14, 1e-13}) {
    double x = 0;
    const std::vector<double> seconds = tools::secondsPerCall(
        {[&] { x = bySimulation(tolerance); }, [] { byOdeint(); }}, 1, given.has("quick") ? 5 : 41);
    std::printf("%g,%.4e,%.1e,%.4e,%.1e,%.3f,%.1e\n", tolerance, seconds[0], std::abs(x - reference),
                seconds[1], errorOfOdeint, seconds[0] / seconds[1], thereAndBack(1000, tolerance));
  }
}

}  // namespace planar_chain::benchmarks
