#pragma once

/// factor Σ_j w_j x_j for a row w of a method's table, and that added to something, in one pass over the
/// components. Zeros are left out when it is made. Allocates then, and not later.

#include <Eigen/Core>
#include <vector>

namespace planar_chain::ode {

class Combination {
 public:
  /// Of the first x, which stay where they are and have the same length.
  Combination(const std::vector<double>& weights, const std::vector<Eigen::VectorXd>& x);

  /// sum = factor Σ w_j x_j
  void operator()(double factor, Eigen::VectorXd& sum) const { run(factor, nullptr, sum.data(), nullptr); }
  /// out = base + factor Σ w_j x_j; the two may be the same.
  void addTo(const Eigen::VectorXd& base, double factor, Eigen::VectorXd& out) const {
    run(factor, base.data(), nullptr, out.data());
  }
  /// Both.
  void addTo(const Eigen::VectorXd& base, double factor, Eigen::VectorXd& sum, Eigen::VectorXd& out) const {
    run(factor, base.data(), sum.data(), out.data());
  }

 private:
  void run(double factor, const double* base, double* sum, double* out) const {
    run_(factor, weights_.data(), terms_.data(), base, sum, out, size_);
  }

  void (*run_)(double factor, const double* weights, const double* const* terms, const double* base,
               double* sum, double* out, std::ptrdiff_t n) = nullptr;
  std::vector<double> weights_;
  std::vector<const double*> terms_;
  std::ptrdiff_t size_ = 0;
};

/// One a row.
std::vector<Combination> combinationsOf(const std::vector<std::vector<double>>& rows,
                                        const std::vector<Eigen::VectorXd>& x);

}  // namespace planar_chain::ode
