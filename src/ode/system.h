#pragma once

/// An initial value problem ẏ = f(t, y), and where its solution stands. Knows no chain.
///
/// A system may go through the components in an order of its own. "Arranged", y has arrangedSize() numbers;
/// those beside y's are 0 and stay 0. Methods and their states know only this order, so nothing is reordered
/// but what somebody wants to read. By default both orders are the same.

#include <Eigen/Core>
#include <algorithm>
#include <complex>

#include "ode/nystrom.h"
#include "ode/vector.h"

namespace planar_chain::ode {

class System {
 public:
  virtual ~System() = default;
  virtual int size() const = 0;
  /// dydt = f(t, y); both of length size(). Must allocate nothing and may write numbers that are not finite.
  virtual void derivative(double t, const double* y, double* dydt) = 0;

  virtual int arrangedSize() const { return size(); }
  /// To the other order and back; not in place.
  virtual void arrange(const double* y, double* arranged) const { std::copy_n(y, size(), arranged); }
  virtual void restore(const double* arranged, double* y) const { std::copy_n(arranged, size(), y); }

  /// So many components at the head of an arranged y are known to be positions: their derivatives are the
  /// next so many, and nothing depends on those behind.
  virtual int positions() const { return 0; }
  /// The derivative of all but the positions, arrangedSize() − positions() numbers, at an arranged y; as
  /// derivative().
  virtual void rates(double t, const double* y, double* out) { derivative(t, y, out); }
  /// And a row whose last term they are, which may write to y; where there are positions.
  virtual void ratesAndRow(double t, const double* y, double* out, const RowAhead& ahead) {
    rates(t, y, out);
    ahead.run();
  }
  /// All of it, at an arranged y and arranged.
  void slope(double t, const double* y, double* out) {
    const int count = positions();
    std::copy_n(y + count, count, out);
    rates(t, y, out + count);
  }
};

/// What the exact solve takes, in evaluations of f.
struct LinearCosts {
  double factor;  ///< with linearize()
  double solve;
  double factorComplex, solveComplex;
};

/// A system whose Jacobian J = ∂f/∂y can be solved with exactly. All of it is arranged.
class LinearizedSystem : public System {
 public:
  /// Room for what follows, with at least so many factorizations with complex s, kept beside each other and
  /// the real one. Allocates.
  virtual void reserve(int complexCount) = 0;
  /// Takes J and ∂f/∂t at (t, y), and writes f(t, y) on the way.
  virtual void linearize(double t, const double* y, double* dydt) = 0;
  /// ∂f/∂t at the last linearize(). False, and nothing is written, when f does not depend on t there.
  virtual bool timeDerivative(double* ft) = 0;
  virtual LinearCosts linearCosts() const = 0;
  /// Factors s·1 − J.
  virtual void factor(double s) = 0;
  /// x = (s·1 − J)⁻¹ rhs with the last factor(); x may be rhs.
  virtual void solve(const double* rhs, double* x) = 0;

  /// Factors s·1 − J as number k < count.
  virtual void factorComplex(int k, std::complex<double> s) = 0;
  /// x = (s·1 − J)⁻¹ rhs with factorization k; x may be rhs.
  virtual void solveComplex(int k, const std::complex<double>* rhs, std::complex<double>* x) = 0;
};

/// And whose solution has a Taylor series, which is not arranged. Its first driving() components drive
/// themselves; the others are integrals along the way.
class SeriesSystem : public LinearizedSystem {
 public:
  /// Whether they may pay, which depends on what else there is.
  virtual bool seriesAreWorthwhile() const = 0;
  /// Room for series up to this order. Allocates.
  virtual void reserveSeries(int order) = 0;
  virtual int driving() const = 0;
  /// The solution through (t, y): to row k = 0 … order of c, of driving() numbers each, y^(k)/k!.
  virtual void series(double t, const double* y, int order, double* c) = 0;
  /// Whether the others change at all, as things are.
  virtual bool hasIntegrands() const = 0;
  /// The rates of the others.
  virtual void integrands(double t, const double* y, double* rates) = 0;
  /// What a series takes, in evaluations of f.
  virtual double seriesCost(int order) const = 0;
};

/// y at t, arranged. The part of the solution that is lost when a small increment is added to a larger y is
/// carried to the next step (Kahan's summation), so rounding does not grow with the number of steps.
struct State {
  double t = 0;
  Vector y;
  Vector carry;

  State() = default;
  explicit State(Eigen::Index size) : y(size), carry(size) {}
  /// From and to y as others have it.
  State(const System& f, const Eigen::VectorXd& values) : State(f.arrangedSize()) {
    f.arrange(values.data(), y.data());
  }
  Eigen::VectorXd restoredBy(const System& f) const {
    Eigen::VectorXd values(f.size());
    f.restore(y.data(), values.data());
    return values;
  }
};

}  // namespace planar_chain::ode
