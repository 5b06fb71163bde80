#pragma once

/// An initial value problem ẏ = f(t, y), and where its solution stands. Knows no chain.

#include <Eigen/Core>

namespace planar_chain::ode {

class System {
 public:
  virtual ~System() = default;
  virtual int size() const = 0;
  /// dydt = f(t, y); both of length size(). Must allocate nothing and may write numbers that are not finite.
  virtual void derivative(double t, const double* y, double* dydt) = 0;
};

/// y at t. The part of the solution that is lost when a small increment is added to a larger y is carried
/// to the next step (Kahan's summation), so rounding does not grow with the number of steps.
struct State {
  double t = 0;
  Eigen::VectorXd y;
  Eigen::VectorXd carry;

  State() = default;
  explicit State(Eigen::Index size) : y(Eigen::VectorXd::Zero(size)), carry(Eigen::VectorXd::Zero(size)) {}
};

}  // namespace planar_chain::ode
