#pragma once

/// An initial value problem ẏ = f(t, y), and the state of its solution. Nothing here depends on the chain.
///
/// A system may store the components in an order of its own, its lane order, with additional zeros that stay
/// 0. It then has sizeInLaneOrder() numbers. The order of y is called chain order. Methods and states use
/// only vectors in lane order, so a step reorders nothing. By default both orders are the same. Only
/// functions that say so allocate.

#include <Eigen/Core>
#include <algorithm>
#include <complex>
#include <utility>

#include "simd/cache_lines.h"
#include "simd/snapshot.h"
#include "simd/vectors.h"

namespace planar_chain::ode {

/// A vector of Eigen's that begins where a cache line does.
class Vector : public Eigen::Map<Eigen::VectorXd> {
  using Map = Eigen::Map<Eigen::VectorXd>;

 public:
  /// Zeros.
  explicit Vector(Eigen::Index size = 0) : Map(nullptr, 0), lines_(static_cast<std::size_t>(size)) { show(); }
  template <class Derived>
  Vector(const Eigen::MatrixBase<Derived>& values) : Vector(values.size()) {
    Map::operator=(values);
  }
  Vector(const Vector& other) : Map(nullptr, 0), lines_(other.lines_) { show(); }
  Vector(Vector&& other) noexcept : Map(nullptr, 0), lines_(std::move(other.lines_)) { show(); }
  /// Requires equal sizes.
  using Map::operator=;
  /// Takes any size; allocates where it is larger.
  Vector& operator=(const Vector& other) {
    lines_ = other.lines_;
    show();
    return *this;
  }
  Vector& operator=(Vector&& other) noexcept {
    lines_ = std::move(other.lines_);
    show();
    return *this;
  }
  void saveOrRestore(Snapshot& snapshot) {
    snapshot(lines_);
    show();
  }

 private:
  void show() { new (static_cast<Map*>(this)) Map(lines_.data(), static_cast<Eigen::Index>(lines_.size())); }

  CacheLines lines_;
};

struct State;

class System {
 public:
  virtual ~System() = default;
  virtual int size() const = 0;
  /// dydt = f(t, y), both of length size(). May write numbers that are not finite.
  virtual void derivative(double t, const double* y, double* dydt) = 0;

  /// The number of components that its conditions, see project(), leave free.
  virtual int freedoms() const { return size(); }

  /// The kernel for the vectors of its methods.
  virtual const simd::VectorKernel& vectors() const { return simd::vectors({}); }

  virtual int sizeInLaneOrder() const { return size(); }
  /// True if both orders are the same.
  virtual bool hasOneOrder() const { return true; }
  /// toLaneOrder() copies y to lane order, toChainOrder() copies it back. The arrays must be different ones.
  virtual void toLaneOrder(const double* y, double* laneOrdered) const {
    std::copy_n(y, size(), laneOrdered);
  }
  virtual void toChainOrder(const double* laneOrdered, double* y) const {
    std::copy_n(laneOrdered, size(), y);
  }

  /// The number p of positions: the first p components of a y in lane order. Their derivatives are the next p
  /// components, and f does not depend on the components behind. 0: unknown.
  virtual int positions() const { return 0; }
  /// The index of the first rate in lane order. It is positions(), unless rates() writes all derivatives.
  virtual int firstRate() const { return positions(); }
  /// The derivatives of all but the positions, sizeInLaneOrder() − positions() numbers, at a y in lane order.
  virtual void rates(double t, const double* y, double* out) { derivative(t, y, out); }
  /// A step has ended at this state. If it differs from the last y of rates() by rounding alone, the system
  /// may move it there, and the difference to `carry`: then the next step, which begins there, is free.
  virtual void endedAt(State& /*state*/) {}
  /// Moves a state onto the conditions that a solution keeps, and which it met `before` the step that ends
  /// here. Returns false if it cannot.
  virtual bool project(State& /*state*/, const State& /*before*/) { return true; }
  /// How independent of each other the conditions are where the last project() ended: from 1 to 0. Near 0 it
  /// falls with the square of the distance.
  virtual double margin() const { return 1; }
  /// All derivatives, in lane order, at a y in lane order.
  void slope(double t, const double* y, double* out) {
    const int count = positions();
    std::copy_n(y + count, count, out);
    rates(t, y, out + count);
  }
};

/// The cost of the exact solve, in evaluations of f.
struct LinearCosts {
  double factor;  ///< with linearize()
  double solve;
  double factorComplex, solveComplex;
};

/// A system that solves equations with its Jacobian J = ∂f/∂y exactly. All vectors are in lane order.
class LinearizedSystem : public System {
 public:
  /// Reserves memory for one real and at least complexCount complex factorizations. Allocates.
  virtual void reserve(int complexCount) = 0;
  /// Computes J and ∂f/∂t at (t, y), and dydt = f(t, y).
  virtual void linearize(double t, const double* y, double* dydt) = 0;
  /// ∂f/∂t at the last linearize(). Returns false, and writes nothing, if f does not depend on t there.
  virtual bool timeDerivative(double* ft) = 0;
  virtual LinearCosts linearCosts() const = 0;
  /// Factors s·1 − J.
  virtual void factor(double s) = 0;
  /// x = (s·1 − J)⁻¹ rhs by the last factor(). x may be rhs.
  virtual void solve(const double* rhs, double* x) = 0;

  /// Factors s·1 − J as number k < count.
  virtual void factorComplex(int k, std::complex<double> s) = 0;
  /// x = (s·1 − J)⁻¹ rhs by factorization k. x may be rhs.
  virtual void solveComplex(int k, const std::complex<double>* rhs, std::complex<double>* x) = 0;
};

/// A linearized system whose solution has a Taylor series. Its vectors are in chain order. The rates of the
/// first driving() components depend on these components and t alone. The other components are integrals:
/// their rates depend on the first ones and t, too.
class SeriesSystem : public LinearizedSystem {
 public:
  /// True if f often jumps, so that steps are short.
  virtual bool jumpsOften() const { return false; }
  /// True if a series may be faster than the other methods.
  virtual bool seriesAreWorthwhile() const = 0;
  /// Reserves memory for series up to this order. Allocates.
  virtual void reserveSeries(int order) = 0;
  virtual int driving() const = 0;
  /// Writes y^(k)/k! of the solution through (t, y) to row k = 0 … order of c, driving() numbers each. carry:
  /// as in State, or nullptr. A system may ignore it.
  virtual void series(double t, const double* y, const double* carry, int order, double* c) = 0;
  /// True if the integrals change at present.
  virtual bool hasIntegrands() const = 0;
  /// The rates of the integrals.
  virtual void integrands(double t, const double* y, double* rates) = 0;
  /// The cost of a series, in evaluations of f.
  virtual double seriesCost(int order) const = 0;
};

/// y at t, in lane order. `carry` is the rounding error of the last sum of y and an increment. The next step
/// adds it (Kahan's summation), so rounding errors do not grow with the number of steps.
struct State {
  double t = 0;
  Vector y;
  Vector carry;

  State() = default;
  explicit State(Eigen::Index size) : y(size), carry(size) {}
  void saveOrRestore(Snapshot& snapshot) { snapshot(t, y, carry); }
  /// Converts y from the order of derivative(). restoredBy() converts it back. Both allocate.
  State(const System& f, const Eigen::VectorXd& values) : State(f.sizeInLaneOrder()) {
    f.toLaneOrder(values.data(), y.data());
  }
  Eigen::VectorXd restoredBy(const System& f) const {
    Eigen::VectorXd values(f.size());
    f.toChainOrder(y.data(), values.data());
    return values;
  }
};

}  // namespace planar_chain::ode
