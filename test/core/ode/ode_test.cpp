/// Every method against its own promises: order conditions, measured order, landing, honest failure.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <stdexcept>
#include <string>

#include "ode/events.h"
#include "ode/explicit_runge_kutta.h"
#include "ode/integrator.h"
#include "ode/methods.h"
#include "ode/rosenbrock.h"
#include "test_system.h"

namespace planar_chain::ode {
namespace {

using test::errorOfEqualSteps;
using test::testError;
using test::testStart;
using test::testSystem;

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

/// A rooted tree: the order conditions of every one-step method are one equation a tree (Hairer, Nørsett,
/// Wanner I, section II.2; Hairer, Wanner II, section IV.7).
struct Tree {
  std::vector<Tree> branches;

  int order() const {
    int total = 1;
    for (const Tree& branch : branches) total += branch.order();
    return total;
  }
  double gamma() const {
    double product = order();
    for (const Tree& branch : branches) product *= branch.gamma();
    return product;
  }
  /// Elementary weight of the stages. Where one branch grows alone, a Rosenbrock method has alpha + gamma.
  Eigen::VectorXd weight(const Eigen::MatrixXd& alpha, const Eigen::MatrixXd& beta) const {
    Eigen::VectorXd product = Eigen::VectorXd::Ones(alpha.rows());
    const Eigen::MatrixXd& coefficients = branches.size() == 1 ? beta : alpha;
    for (const Tree& branch : branches) {
      product = product.cwiseProduct(coefficients * branch.weight(alpha, beta));
    }
    return product;
  }
};

/// All trees of the given order: forests of order − 1 on a new root, each forest once.
void plant(int left, int largest, std::size_t from, const std::vector<std::vector<Tree>>& smaller, Tree& tree,
           std::vector<Tree>& out) {
  if (left == 0) out.push_back(tree);
  for (int size = std::min(left, largest); size >= 1; --size) {
    const auto& choice = smaller[static_cast<std::size_t>(size)];
    for (std::size_t k = size == largest ? from : 0; k < choice.size(); ++k) {
      tree.branches.push_back(choice[k]);
      plant(left - size, size, k, smaller, tree, out);
      tree.branches.pop_back();
    }
  }
}
std::vector<std::vector<Tree>> treesUpTo(int order) {
  std::vector<std::vector<Tree>> trees(static_cast<std::size_t>(order) + 1);
  for (int p = 1; p <= order; ++p) {
    Tree root;
    plant(p - 1, p - 1, 0, trees, root, trees[static_cast<std::size_t>(p)]);
  }
  return trees;
}

/// A method as matrices, in the classical form that the order conditions speak.
struct Weights {
  std::string name;
  int order, errorOrder;
  Eigen::MatrixXd alpha, beta;
  Eigen::VectorXd b, e, c, cGiven;
  double precision;  ///< of the published digits, as they add up
};

Eigen::MatrixXd lower(const std::vector<std::vector<double>>& rows) {
  Eigen::MatrixXd matrix =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t j = 0; j < rows[i].size(); ++j) {
      matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i][j];
    }
  }
  return matrix;
}
Eigen::VectorXd vectorOf(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

Weights weightsOf(const Tableau& table) {
  const Eigen::MatrixXd alpha = lower(table.a);
  return {table.name,        table.order,           table.errorOrder,  alpha, alpha, vectorOf(table.b),
          vectorOf(table.e), alpha.rowwise().sum(), vectorOf(table.c), 2e-14};
}

/// From the form without products with J: Γ⁻¹ = 1/γ − C, α = A Γ, bᵀ = mᵀ Γ.
Weights weightsOf(const RosenbrockTableau& table) {
  const Eigen::MatrixXd A = lower(table.a);
  const Eigen::MatrixXd inverse =
      Eigen::MatrixXd::Identity(A.rows(), A.cols()) / table.gamma - lower(table.C);
  const Eigen::MatrixXd gamma = inverse.inverse();
  const Eigen::MatrixXd alpha = A * gamma;
  EXPECT_LT((gamma.rowwise().sum() - vectorOf(table.d)).cwiseAbs().maxCoeff(), 2e-13) << table.name;
  return {table.name,
          table.order,
          table.errorOrder,
          alpha,
          alpha + gamma,
          gamma.transpose() * vectorOf(table.m),
          gamma.transpose() * vectorOf(table.e),
          alpha.rowwise().sum(),
          vectorOf(table.c),
          1e-12};
}

double violation(const Weights& method, const Eigen::VectorXd& b, int order) {
  double worst = 0;
  const auto trees = treesUpTo(order);
  for (const Tree& tree : trees[static_cast<std::size_t>(order)]) {
    worst = std::max(worst, std::abs(b.dot(tree.weight(method.alpha, method.beta)) - 1 / tree.gamma()));
  }
  return worst;
}

TEST(Trees, AreAsManyAsThereAre) {
  const auto trees = treesUpTo(9);
  const std::vector<std::size_t> known{0, 1, 1, 2, 4, 9, 20, 48, 115, 286};
  for (std::size_t p = 1; p < known.size(); ++p) EXPECT_EQ(trees[p].size(), known[p]);
}

class EveryMethod : public testing::TestWithParam<Weights> {};

TEST_P(EveryMethod, RowsSumToC) {
  EXPECT_LT((GetParam().c - GetParam().cGiven).cwiseAbs().maxCoeff(), GetParam().precision);
}

TEST_P(EveryMethod, MeetsTheConditionsOfItsOrderAndNotOfTheNext) {
  const Weights& method = GetParam();
  for (int p = 1; p <= method.order; ++p) EXPECT_LT(violation(method, method.b, p), method.precision) << p;
  EXPECT_GT(violation(method, method.b, method.order + 1), 1e-6);
}

TEST_P(EveryMethod, HasAnEmbeddedSolutionOfTheOrderItSays) {
  const Weights& method = GetParam();
  if (method.errorOrder == 0) GTEST_SKIP() << "no embedded solution";
  const Eigen::VectorXd embedded = method.b - method.e;
  // DOP853 combines its estimate of order 5 with one of order 3 to act like one of order 7.
  const int order = method.name == "dop853" ? 5 : method.errorOrder;
  for (int p = 1; p <= order; ++p) EXPECT_LT(violation(method, embedded, p), method.precision) << p;
  EXPECT_GT(violation(method, embedded, order + 1), 1e-6);
}

TEST(Dop853, HasACoarserEstimateOfOrderThree) {
  const Weights method = weightsOf(dop853());
  const Eigen::VectorXd embedded = method.b - vectorOf(dop853().coarse);
  for (int p = 1; p <= 3; ++p) EXPECT_LT(violation(method, embedded, p), method.precision) << p;
  EXPECT_GT(violation(method, embedded, 4), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryMethod,
                         testing::Values(weightsOf(rk4()), weightsOf(dopri5()), weightsOf(dop853()),
                                         weightsOf(rodas5p()), weightsOf(ros34pw2())),
                         [](const auto& method) { return method.param.name; });

/// R(z) = 1 + z bᵀ (1 − z β)⁻¹ 1 of a Rosenbrock method.
std::complex<double> stability(const Weights& method, std::complex<double> z) {
  const Eigen::Index s = method.b.size();
  const Eigen::MatrixXcd system = Eigen::MatrixXcd::Identity(s, s) - z * method.beta;
  const Eigen::VectorXcd one = Eigen::VectorXcd::Ones(s);
  return 1.0 + z * (method.b.transpose() * system.partialPivLu().solve(one))(0);
}

TEST(ExplicitRungeKutta, IsStableUpToItsLimit) {
  for (const Tableau* table : {&rk4(), &dopri5(), &dop853()}) {
    const Weights method = weightsOf(*table);
    for (double y = 0.01; y < table->stabilityLimit; y += 0.01) {
      EXPECT_LE(std::abs(stability(method, {0, y})), 1 + 1e-9) << table->name << " at " << y;
    }
    EXPECT_GT(std::abs(stability(method, {0, table->stabilityLimit + 0.1})), 1 + 1e-9) << table->name;
  }
}

/// Positions, so many that their rows are in Nyström's form, driven, with their mean power behind them. Known
/// as positions or not.
class Driven : public System {
 public:
  explicit Driven(bool isKnown) : isKnown_(isKnown) {}
  int size() const override { return 2 * n + 1; }
  int positions() const override { return isKnown_ ? n : 0; }
  void derivative(double t, const double* y, double* dydt) override {
    std::copy(y + n, y + 2 * n, dydt);
    ratesTo(t, y, dydt + n);
  }
  void rates(double t, const double* y, double* out) override {
    isKnown_ ? ratesTo(t, y, out) : derivative(t, y, out);
  }

  static constexpr int n = 70;

 private:
  static void ratesTo(double t, const double* y, double* out) {
    out[n] = 0;
    for (int i = 0; i < n; ++i) {
      out[i] = std::sin(t + i) - y[i] * y[(i + 1) % n] - 0.3 * y[n + i] * std::abs(y[n + i]);
      out[n] += out[i] * y[n + i] / n;
    }
  }
  bool isKnown_;
};

TEST(ExplicitRungeKutta, IsTheSameInNystromsForm) {
  for (const Tableau* table : {&rk4(), &dopri5(), &dop853()}) {
    Driven plain(false), known(true);
    ExplicitRungeKutta one(*table, plain), other(*table, known);
    Eigen::VectorXd y = Eigen::VectorXd::LinSpaced(plain.size(), -1, 1);
    for (double t = 0; t < 0.5; t += 0.1) {
      EXPECT_LT((one.derivative(t, y) - other.derivative(t, y)).norm(), 3e-15) << table->name;
      one.step(t, 0.1, y);
      other.step(t, 0.1, y);
      // Each component is compared, as there are many.
      EXPECT_LT((one.increment() - other.increment()).lpNorm<Eigen::Infinity>(), 3e-16) << table->name;
      if (!table->e.empty()) {
        EXPECT_LT((one.error() - other.error()).head(2 * Driven::n).lpNorm<Eigen::Infinity>(), 3e-16)
            << table->name;
        EXPECT_GT(one.error().norm(), 1e-15) << table->name;
      }
      y += one.increment();
      one.accept();
      other.accept();
    }
  }
}

/// The message that a method is refused with; empty: none.
std::string refusalOf(const std::function<void()>& make) {
  try {
    make();
  } catch (const std::invalid_argument& refusal) {
    return refusal.what();
  }
  return "";
}

TEST(Methods, OfMoreStagesThanThereAreSumsForAreRefused) {
  auto f = testSystem();
  Tableau table = dop853();
  const auto explicitOf = [&](std::size_t stages) {
    table.b.resize(stages), table.c.resize(stages), table.e.resize(stages), table.coarse.resize(stages);
    while (table.a.size() < stages) table.a.emplace_back(table.a.size());
    return refusalOf([&] { ExplicitRungeKutta(table, f); });
  };
  EXPECT_EQ(explicitOf(13), "");
  EXPECT_EQ(explicitOf(14), "dop853 has 14 stages; a method may have at most 13");

  RosenbrockTableau linear = rodas5p();
  EXPECT_EQ(refusalOf([&] { Rosenbrock(linear, f); }), "");
  for (auto* numbers : {&linear.c, &linear.d, &linear.m, &linear.e}) numbers->resize(14);
  for (auto* rows : {&linear.a, &linear.C}) {
    while (rows->size() < 14) rows->emplace_back(rows->size());
  }
  EXPECT_EQ(refusalOf([&] { Rosenbrock(linear, f); }), "rodas5p has 14 stages; a method may have at most 13");
}

TEST(Rosenbrock, IsLStable) {
  for (const Weights& method : {weightsOf(rodas5p()), weightsOf(ros34pw2())}) {
    // A-stable: |R| ≤ 1 on the imaginary axis (R has no pole to its left). L-stable: R(−∞) = 0.
    for (double w = 1e-3; w < 1e6; w *= 1.2) EXPECT_LE(std::abs(stability(method, {0, w})), 1 + 1e-9) << w;
    EXPECT_LT(std::abs(stability(method, -1e8)), 1e-6) << method.name;
    EXPECT_LT(std::abs(stability(method, {0, 1e8})), 1e-6) << method.name;
  }
}

TEST(FixedStepping, HasTheMeasuredOrder) {
  for (const Tableau* table : {&rk4(), &dopri5(), &dop853()}) {
    const int steps = table->order > 5 ? 20 : 80;
    auto f = testSystem();
    const auto error = [&](int count) { return errorOfEqualSteps(ExplicitRungeKutta(*table, f), count); };
    EXPECT_NEAR(std::log2(error(steps) / error(2 * steps)), table->order, 0.3) << table->name;
  }
  for (const RosenbrockTableau* table : {&rodas5p(), &ros34pw2()}) {
    auto f = testSystem();
    const auto error = [&](int count) { return errorOfEqualSteps(Rosenbrock(*table, f), count); };
    EXPECT_NEAR(std::log2(error(80) / error(160)), table->order, 0.3) << table->name;
  }
}

std::unique_ptr<Integrator> dopri5For(System& f, double tolerance) {
  return test::adaptiveSteps(std::make_unique<ExplicitRungeKutta>(dopri5(), f),
                             {tolerance, Eigen::ArrayXd::Constant(f.size(), 1e300)});
}

TEST(AdaptiveSteps, KeepTheErrorBelowTheTolerance) {
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    auto f = testSystem();
    State state = testStart();
    const auto integrator = dopri5For(f, tolerance);
    ASSERT_EQ(integrator->integrate(state, 5, 100), Outcome::arrived);
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
  const auto integrator = dopri5For(f, 1e-6);
  ASSERT_EQ(integrator->integrate(state, 1, 100), Outcome::arrived);
  late = true;
  integrator->restart();
  ASSERT_EQ(integrator->integrate(state, 3, 100), Outcome::arrived);
  EXPECT_NEAR(state.y[0], -1, 1e-15);
}

TEST(AdaptiveSteps, SayWhenTheMotionLeavesTheFiniteNumbers) {
  // ẏ = y²: y = 1/(1 − t) has no value at t = 1.
  auto f = systemOf(1, [](double, const double* y, double* dydt) { dydt[0] = y[0] * y[0]; });
  State state(1);
  state.y[0] = 1;
  const auto integrator = dopri5For(f, 1e-8);
  EXPECT_NE(integrator->integrate(state, 2, 100), Outcome::arrived);
  EXPECT_TRUE(std::isfinite(state.y[0]));
  EXPECT_LE(state.t, 1.0001);
}

TEST(AdaptiveSteps, StopBeforeARegionThatHasNoNumbers) {
  auto f = systemOf(1, [](double t, const double*, double* dydt) { dydt[0] = t < 0.5 ? 1 : std::nan(""); });
  State state(1);
  const auto integrator = dopri5For(f, 1e-8);
  EXPECT_EQ(integrator->integrate(state, 1, 100), Outcome::notFinite);
  EXPECT_NEAR(state.y[0], 0.5, 1e-9);
}

/// As a motion so fast that high derivatives of one component exceed the range of double.
class OverflowingSeries : public test::TestSystem {
 public:
  void series(double t, const double* y, const double* carry, int order, double* c) override {
    TestSystem::series(t, y, carry, order, c);
    c[3 * order + 1] = std::nan("");
  }
};

TEST(AdaptiveSteps, EndIfASeriesOverflows) {
  OverflowingSeries f;
  State state = testStart();
  const auto integrator = makeMethod("taylor", f, 0, {1e-8, Eigen::ArrayXd::Constant(3, 1)});
  EXPECT_EQ(integrator->integrate(state, 1, 100), Outcome::notFinite);
  EXPECT_EQ(state.t, 0);
}

/// An event that has happened wherever f is, whatever is fired.
struct Always : EventFunctions {
  int most() const override { return 1; }
  void values(double /*t*/, const double* /*y*/, double* g) const override { *g = 1; }
  void noise(double /*t*/, const double* /*y*/, double* of) const override { *of = 0; }
};

TEST(Landing, MakesNoStepFromWhereASwitchIsDueAndGivesUpIfThatDoesNotEnd) {
  const Always always;
  test::TestSystem f;
  const auto method =
      stepsToEvents(makeMethod("dopri5", f, 0, {1e-8, Eigen::ArrayXd::Constant(3, 1)}), {&always}, f);
  State state = testStart();
  state.t = 0.5;
  const State before = state;
  int switches = 0;
  Outcome outcome;
  while ((outcome = method->advance(state, 1, 1)) == Outcome::switched && switches < 5000) {
    ++switches;
    method->passEvent();
  }
  EXPECT_EQ(outcome, Outcome::endless);
  EXPECT_GT(switches, 1000);
  EXPECT_EQ(state.t, before.t);
  EXPECT_EQ(state.y, before.y);
}

TEST(FixedSteps, StopAtTheLastFiniteState) {
  auto f = systemOf(1, [](double, const double* y, double* dydt) { dydt[0] = y[0] * y[0]; });
  State state(1);
  state.y[0] = 1;
  const auto integrator = fixedSteps(std::make_unique<ExplicitRungeKutta>(rk4(), f), 0.1);
  EXPECT_EQ(integrator->integrate(state, 5, 100), Outcome::notFinite);
  EXPECT_TRUE(std::isfinite(state.y[0]));
}

TEST(FixedSteps, CountWholeStepsDespiteRounding) {
  auto f = testSystem();
  for (const double h : {1e-3, 1. / 3, 0.1}) {
    State state = testStart();
    const auto integrator = fixedSteps(std::make_unique<ExplicitRungeKutta>(rk4(), f), h);
    for (int k = 1; k <= 30; ++k) ASSERT_EQ(integrator->integrate(state, k * h, 1), Outcome::arrived);
    EXPECT_EQ(integrator->count().accepted, 30);
  }
}

TEST(Rounding, DoesNotGrowWithTheNumberOfSteps) {
  // ẏ = 1/10: a million additions of 1e-7 · 0.1 lose 1e-11 when nothing is carried.
  auto f = systemOf(1, [](double, const double*, double* dydt) { dydt[0] = 0.1; });
  State state(1);
  state.y[0] = 1;
  const auto integrator = fixedSteps(std::make_unique<ExplicitRungeKutta>(rk4(), f), 1e-6);
  ASSERT_EQ(integrator->integrate(state, 1, 1), Outcome::arrived);
  EXPECT_NEAR(state.y[0], 1.1, 1e-15);
}

TEST(Methods, SolveToTheToleranceByName) {
  for (const std::string& name : methodNames()) {
    if (hasFixedStep(name)) continue;
    for (const double tolerance : {1e-5, 1e-7, 1e-9}) {
      auto f = testSystem();
      State state = testStart();
      const auto method = makeMethod(name, f, 1e-3, {tolerance, Eigen::ArrayXd::Constant(3, 1e300)});
      ASSERT_EQ(method->integrate(state, 3, 100), Outcome::arrived);
      EXPECT_LT(testError(state), 5 * tolerance) << name << " at " << tolerance;
    }
  }
}

/// A system for which the methods compute nothing.
struct Idle : test::TestSystem {
  const simd::VectorKernel& vectors() const override { return test::idleVectors(); }
};

TEST(Methods, UseTheKernelOfTheirSystem) {
  for (const std::string& name : methodNames()) {
    if (name == "radau13") continue;  // its iteration does not converge without sums
    Idle f;
    State state = testStart();
    const auto method = makeMethod(name, f, 0.1, {1e-5, Eigen::ArrayXd::Constant(3, 1e300)});
    ASSERT_EQ(method->integrate(state, 1, 100), Outcome::arrived) << name;
    EXPECT_EQ(state.y, testStart().y) << name;
    EXPECT_EQ(method->count().rejected, 0) << name;
  }
}

TEST(Methods, AreRefusedByNameOnly) {
  auto f = testSystem();
  EXPECT_THROW(makeMethod("magic", f, 1e-3, {1e-6, Eigen::ArrayXd::Ones(3)}), std::invalid_argument);
  EXPECT_THROW(test::adaptiveSteps(std::make_unique<ExplicitRungeKutta>(rk4(), f), {}),
               std::invalid_argument);
}

}  // namespace
}  // namespace planar_chain::ode
