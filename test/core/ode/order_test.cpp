/// A system's own order of the components: every method sees nothing else, and the motion is the same.

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>

#include "dynamics/dynamics.h"
#include "ode/events.h"
#include "ode/local_stiffness.h"
#include "ode/methods.h"
#include "support/random_scene.h"
#include "test_system.h"

namespace planar_chain::ode {
namespace {

/// The test system from the end to its beginning, with a place between any two.
class Reordered : public test::TestSystem {
 public:
  int sizeInLaneOrder() const override { return 2 * size() - 1; }
  bool hasOneOrder() const override { return false; }
  void toLaneOrder(const double* y, double* laneOrdered) const override { allToLaneOrder(y, laneOrdered); }
  void toChainOrder(const double* laneOrdered, double* y) const override { allToChainOrder(laneOrdered, y); }

  void rates(double t, const double* y, double* out) override {
    passOn<double>(y, out, [&](const double* from, double* to) { TestSystem::derivative(t, from, to); });
  }
  void linearize(double t, const double* y, double* dydt) override {
    passOn<double>(y, dydt, [&](const double* from, double* to) { TestSystem::linearize(t, from, to); });
  }
  bool timeDerivative(double* ft) override {
    double inOrder[3];
    TestSystem::timeDerivative(inOrder);
    allToLaneOrder(inOrder, ft);
    return true;
  }
  void solve(const double* rhs, double* x) override {
    passOn<double>(rhs, x, [&](const double* from, double* to) { TestSystem::solve(from, to); });
  }
  void solveComplex(int k, const std::complex<double>* rhs, std::complex<double>* x) override {
    using Complex = std::complex<double>;
    passOn<Complex>(rhs, x, [&](const Complex* from, Complex* to) { TestSystem::solveComplex(k, from, to); });
  }

 private:
  template <class Number>
  static void allToLaneOrder(const Number* y, Number* laneOrdered) {
    for (int i = 0; i < 5; ++i) laneOrdered[i] = i % 2 == 0 ? y[2 - i / 2] : Number(0);
  }
  template <class Number>
  static void allToChainOrder(const Number* laneOrdered, Number* y) {
    for (int i = 0; i < 3; ++i) y[i] = laneOrdered[2 * (2 - i)];
  }
  template <class Number, class F>
  static void passOn(const Number* from, Number* to, F f) {
    Number given[3], found[3];
    allToChainOrder(from, given);
    f(given, found);
    allToLaneOrder(found, to);
  }
};

struct Result {
  Eigen::Vector3d y;
  double t = 0;
  StepCount count;
};

const Eigen::Vector3d start = test::testStart().y;

template <class F>
Result resultOf(SeriesSystem& f, const std::string& name, F advance) {
  // No two components count alike.
  const auto method = makeMethod(name, f, 1e-2, {1e-5, Eigen::Array3d(0.1, 3, 0.5)});
  State state(f, start);
  Result result;
  result.count = advance(*method, state);
  result.y = state.restoredBy(f);
  result.t = state.t;
  if (state.y.size() > 3) {
    EXPECT_EQ(state.y[1], 0) << name;
    EXPECT_EQ(state.y[3], 0) << name;
  }
  return result;
}

template <class F>
void expectTheSame(const std::string& name, F advance) {
  test::TestSystem plain;
  Reordered reordered;
  const Result expected = resultOf(plain, name, advance), found = resultOf(reordered, name, advance);
  EXPECT_LT((expected.y - found.y).cwiseAbs().maxCoeff(), 1e-11) << name;
  EXPECT_DOUBLE_EQ(expected.t, found.t) << name;
  EXPECT_EQ(expected.count.accepted, found.count.accepted) << name;
  EXPECT_EQ(expected.count.rejected, found.count.rejected) << name;
  EXPECT_NEAR(expected.count.lastError, found.count.lastError, 1e-3 * expected.count.lastError) << name;
}

TEST(Order, MakesNoDifferenceToAnyMethod) {
  for (const std::string& name : methodNames()) {
    expectTheSame(name, [&](Integrator& method, State& state) {
      EXPECT_EQ(method.integrate(state, 2.5, 100), Outcome::arrived) << name;
      return method.count();
    });
  }
}

/// y_2 = cos t² below a half.
struct Below : EventFunctions {
  int most() const override { return 1; }
  void values(double /*t*/, const double* y, double* g) const override { *g = 0.5 - y[1]; }
  void noise(double /*t*/, const double* /*y*/, double* of) const override { *of = 0; }
};

TEST(Order, MakesNoDifferenceToEvents) {
  const Below below;
  for (const std::string& name : methodNames()) {
    for (const bool isReordered : {false, true}) {
      test::TestSystem plain;
      Reordered reordered;
      SeriesSystem& f = isReordered ? reordered : plain;
      const auto method =
          stepsToEvents(makeMethod(name, f, 1e-2, {1e-8, Eigen::ArrayXd::Constant(3, 1)}), {&below}, f);
      State state(f, start);
      EXPECT_EQ(method->integrate(state, 2, 100), Outcome::switched) << name;
      EXPECT_NEAR(state.restoredBy(f)[1], 0.5, 1e-14) << name << isReordered;
    }
  }
}

/// Another system, whose order nobody knows.
struct Plain : System {
  System& f;
  explicit Plain(System& f_) : f(f_) {}
  int size() const override { return f.size(); }
  void derivative(double t, const double* y, double* dydt) override { f.derivative(t, y, dydt); }
};

TEST(Order, MakesNoDifferenceToTheLocalStiffnessOfAChain) {
  for (const int n : {5, 20, 70}) {
    const Scene scene = planar_chain::test::randomScene(n, 7);
    Dynamics dynamics(scene);
    dynamics.enter(0);
    Plain plain(dynamics);
    const Eigen::VectorXd y = Eigen::VectorXd::LinSpaced(dynamics.size(), -1, 2);
    LocalStiffness expected(plain), found(dynamics);
    for (int k = 0; k < 3; ++k) expected.update(0, y), found.update(0, State(dynamics, y).y);
    EXPECT_NEAR(found.largestEigenvalue(), expected.largestEigenvalue(), 1e-9 * expected.largestEigenvalue());
    State noise(dynamics.sizeInLaneOrder());
    noise.y = found.noise();
    EXPECT_EQ(noise.restoredBy(dynamics), expected.noise()) << n;
  }
}

// ---- Vectors ---------------------------------------------------------------------------------

bool beginsALine(const Vector& vector) {
  return reinterpret_cast<std::uintptr_t>(vector.data()) % 64 == 0;
}

TEST(VectorOf, NumbersBeginsWhereACacheLineDoes) {
  for (Eigen::Index size = 0; size < 40; ++size) {
    Vector zeros(size), sum = Eigen::VectorXd::LinSpaced(size, 0, 1) + zeros, copy = sum;
    EXPECT_EQ(zeros, Eigen::VectorXd::Zero(size));
    EXPECT_EQ(copy, sum);
    copy = Vector(size + 1);
    EXPECT_EQ(copy.size(), size + 1);
    copy = sum;
    const double* place = sum.data();
    const Vector moved = std::move(sum);
    EXPECT_EQ(moved.data(), place);
    EXPECT_EQ(moved, copy);
    EXPECT_TRUE(beginsALine(zeros) && beginsALine(copy) && beginsALine(moved)) << size;
  }
}

}  // namespace
}  // namespace planar_chain::ode
