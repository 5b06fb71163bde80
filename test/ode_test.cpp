/// Every method against its own promises: order conditions, measured order, landing, honest failure.

#include <gtest/gtest.h>

#include <cmath>

#include "planar_chain/ode/explicit_runge_kutta.h"
#include "planar_chain/ode/integrator.h"
#include "planar_chain/ode/methods.h"

namespace planar_chain::ode {
namespace {

/// A system from a lambda.
template <class F>
class Lambda : public System {
 public:
  Lambda(int size, F f) : size_(size), f_(f) {}
  int size() const override { return size_; }
  void derivative(double t, const double* y, double* dydt) override { f_(t, y, dydt); }

 private:
  int size_;
  F f_;
};
template <class F>
Lambda<F> systemOf(int size, F f) {
  return Lambda<F>(size, f);
}

/// Not autonomous, not linear, solved exactly: y_1 = sin t², y_2 = cos t², y_3 = exp(sin t).
auto testSystem() {
  return systemOf(3, [](double t, const double* y, double* dydt) {
    dydt[0] = 2 * t * y[1];
    dydt[1] = -2 * t * y[0];
    dydt[2] = y[2] * std::cos(t);
  });
}
State testStart() {
  State state(3);
  state.y << 0, 1, 1;
  return state;
}
double testError(const State& state) {
  const double t = state.t;
  const Eigen::Vector3d exact(std::sin(t * t), std::cos(t * t), std::exp(std::sin(t)));
  return (state.y - exact).cwiseAbs().maxCoeff();
}

/// Error of `steps` equal steps over [0, 2].
double errorOfFixedSteps(const Tableau& table, int steps) {
  auto f = testSystem();
  State state = testStart();
  const auto integrator = fixedSteps(std::make_unique<ExplicitRungeKutta>(table, 3), 2.0 / steps);
  EXPECT_EQ(integrator->integrate(f, state, 2.0, 1.0), Outcome::arrived);
  EXPECT_EQ(integrator->count().accepted, steps);
  return testError(state);
}

/// Σ over a tree, for the order conditions up to 5 (Hairer, Nørsett, Wanner I, table II.2.2).
struct Conditions {
  const Tableau& table;
  std::vector<double> Ac(const std::vector<double>& v) const {
    std::vector<double> out(table.a.size(), 0.0);
    for (std::size_t i = 0; i < table.a.size(); ++i) {
      for (std::size_t j = 0; j < table.a[i].size(); ++j) out[i] += table.a[i][j] * v[j];
    }
    return out;
  }
  static std::vector<double> times(std::vector<double> u, const std::vector<double>& v) {
    for (std::size_t i = 0; i < u.size(); ++i) u[i] *= v[i];
    return u;
  }
  static double sum(const std::vector<double>& weights, const std::vector<double>& v) {
    double total = 0;
    for (std::size_t i = 0; i < v.size(); ++i) total += weights[i] * v[i];
    return total;
  }
  /// The largest violation among the 17 conditions of orders up to `order`.
  double violation(const std::vector<double>& weights, int order) const {
    const auto& c = table.c;
    const std::vector<double> one(c.size(), 1.0);
    const auto c2 = times(c, c), c3 = times(c2, c), c4 = times(c3, c);
    const auto ac = Ac(c), ac2 = Ac(c2), ac3 = Ac(c3), aac = Ac(ac), aac2 = Ac(ac2), aaac = Ac(aac);
    const auto acac = Ac(times(c, ac));
    struct Tree {
      int order;
      std::vector<double> value;
      double gamma;
    };
    const std::vector<Tree> trees{{1, one, 1},
                                  {2, c, 2},
                                  {3, c2, 3},
                                  {3, ac, 6},
                                  {4, c3, 4},
                                  {4, times(c, ac), 8},
                                  {4, ac2, 12},
                                  {4, aac, 24},
                                  {5, c4, 5},
                                  {5, times(c2, ac), 10},
                                  {5, times(ac, ac), 20},
                                  {5, times(c, ac2), 15},
                                  {5, ac3, 20},
                                  {5, times(c, aac), 30},
                                  {5, acac, 40},
                                  {5, aac2, 60},
                                  {5, aaac, 120}};
    double worst = 0;
    for (const Tree& tree : trees) {
      if (tree.order <= order) worst = std::max(worst, std::abs(sum(weights, tree.value) - 1 / tree.gamma));
    }
    return worst;
  }
};

class EveryTableau : public testing::TestWithParam<const Tableau*> {};

TEST_P(EveryTableau, RowsSumToC) {
  const Tableau& table = *GetParam();
  for (std::size_t i = 0; i < table.c.size(); ++i) {
    double sum = 0;
    for (const double a : table.a[i]) sum += a;
    EXPECT_NEAR(sum, table.c[i], 5e-15) << "stage " << i;
  }
}

TEST_P(EveryTableau, MeetsTheOrderConditions) {
  const Tableau& table = *GetParam();
  const Conditions conditions{table};
  EXPECT_LT(conditions.violation(table.b, table.order), 1e-14);
  if (table.order < 5) {
    EXPECT_GT(conditions.violation(table.b, table.order + 1), 1e-4);
  }
  if (table.e.empty()) return;
  std::vector<double> embedded = table.b;
  for (std::size_t i = 0; i < embedded.size(); ++i) embedded[i] -= table.e[i];
  EXPECT_LT(conditions.violation(embedded, table.errorOrder), 1e-14);
  EXPECT_GT(conditions.violation(embedded, table.errorOrder + 1), 1e-4);
}

TEST_P(EveryTableau, HasItsMeasuredOrder) {
  const Tableau& table = *GetParam();
  const double order = std::log2(errorOfFixedSteps(table, 80) / errorOfFixedSteps(table, 160));
  EXPECT_NEAR(order, table.order, 0.25);
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryTableau, testing::Values(&rk4(), &dopri5()),
                         [](const auto& method) { return method.param->name; });

std::unique_ptr<Integrator> dopri5For(int size, double tolerance) {
  return adaptiveSteps(std::make_unique<ExplicitRungeKutta>(dopri5(), size),
                       {tolerance, Eigen::ArrayXd::Constant(size, 1e300)});
}

TEST(AdaptiveSteps, KeepTheErrorBelowTheTolerance) {
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    auto f = testSystem();
    State state = testStart();
    const auto integrator = dopri5For(3, tolerance);
    ASSERT_EQ(integrator->integrate(f, state, 5, 100), Outcome::arrived);
    EXPECT_EQ(state.t, 5);
    // Five seconds, and no growth of errors but that of exp(sin t).
    EXPECT_LT(testError(state), 5 * tolerance + 2e-14);
  }
}

TEST(AdaptiveSteps, DoNotBreakOnACornerTheyLandOn) {
  // f jumps at t = 1; the caller lands there and restarts, so the result is exact.
  bool late = false;
  auto f = systemOf(1, [&](double, const double*, double* dydt) { dydt[0] = late ? -1 : 1; });
  State state(1);
  const auto integrator = dopri5For(1, 1e-6);
  ASSERT_EQ(integrator->integrate(f, state, 1, 100), Outcome::arrived);
  late = true;
  integrator->restart();
  ASSERT_EQ(integrator->integrate(f, state, 3, 100), Outcome::arrived);
  EXPECT_NEAR(state.y[0], -1, 1e-15);
}

TEST(AdaptiveSteps, SayWhenTheMotionLeavesTheFiniteNumbers) {
  // ẏ = y²: y = 1/(1 − t) has no value at t = 1.
  auto f = systemOf(1, [](double, const double* y, double* dydt) { dydt[0] = y[0] * y[0]; });
  State state(1);
  state.y[0] = 1;
  const auto integrator = dopri5For(1, 1e-8);
  EXPECT_NE(integrator->integrate(f, state, 2, 100), Outcome::arrived);
  EXPECT_TRUE(std::isfinite(state.y[0]));
  EXPECT_LE(state.t, 1.0001);
}

TEST(AdaptiveSteps, StopBeforeARegionThatHasNoNumbers) {
  auto f = systemOf(1, [](double t, const double*, double* dydt) { dydt[0] = t < 0.5 ? 1 : std::nan(""); });
  State state(1);
  const auto integrator = dopri5For(1, 1e-8);
  EXPECT_EQ(integrator->integrate(f, state, 1, 100), Outcome::notFinite);
  EXPECT_NEAR(state.y[0], 0.5, 1e-9);
}

TEST(FixedSteps, StopAtTheLastFiniteState) {
  auto f = systemOf(1, [](double, const double* y, double* dydt) { dydt[0] = y[0] * y[0]; });
  State state(1);
  state.y[0] = 1;
  const auto integrator = fixedSteps(std::make_unique<ExplicitRungeKutta>(rk4(), 1), 0.1);
  EXPECT_EQ(integrator->integrate(f, state, 5, 100), Outcome::notFinite);
  EXPECT_TRUE(std::isfinite(state.y[0]));
}

TEST(FixedSteps, CountWholeStepsDespiteRounding) {
  auto f = testSystem();
  for (const double h : {1e-3, 1. / 3, 0.1}) {
    State state = testStart();
    const auto integrator = fixedSteps(std::make_unique<ExplicitRungeKutta>(rk4(), 3), h);
    for (int k = 1; k <= 30; ++k) ASSERT_EQ(integrator->integrate(f, state, k * h, 1), Outcome::arrived);
    EXPECT_EQ(integrator->count().accepted, 30);
  }
}

TEST(Rounding, DoesNotGrowWithTheNumberOfSteps) {
  // ẏ = 1/10: a million additions of 1e-7 · 0.1 lose 1e-11 when nothing is carried.
  auto f = systemOf(1, [](double, const double*, double* dydt) { dydt[0] = 0.1; });
  State state(1);
  state.y[0] = 1;
  const auto integrator = fixedSteps(std::make_unique<ExplicitRungeKutta>(rk4(), 1), 1e-6);
  ASSERT_EQ(integrator->integrate(f, state, 1, 1), Outcome::arrived);
  EXPECT_NEAR(state.y[0], 1.1, 1e-15);
}

TEST(Methods, AreRefusedByNameOnly) {
  for (const std::string& name : methodNames()) {
    EXPECT_NO_THROW(makeMethod(name, 2, 1e-3, {1e-6, Eigen::ArrayXd::Ones(2)}));
  }
  EXPECT_THROW(makeMethod("magic", 2, 1e-3, {1e-6, Eigen::ArrayXd::Ones(2)}), std::invalid_argument);
  EXPECT_THROW(adaptiveSteps(std::make_unique<ExplicitRungeKutta>(rk4(), 1), {}), std::invalid_argument);
}

}  // namespace
}  // namespace planar_chain::ode
