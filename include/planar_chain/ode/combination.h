#pragma once

/// Sums of vectors by rows of a method's table, in one pass over the components. They allocate when they are
/// made, and not later.

#include <Eigen/Core>
#include <vector>

namespace planar_chain::simd {
struct WeightsOfTwo;
}

namespace planar_chain::ode {

/// factor Σ_j w_j x_j, and that added to something.
class Combination {
 public:
  /// Of the first x, which stay where they are and have the same length. Leaves zeros out.
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

/// Two sums of the same vectors.
class TwoCombinations {
 public:
  TwoCombinations(const std::vector<double>& first, const std::vector<double>& second,
                  const std::vector<Eigen::VectorXd>& x);

  /// For `count` components from the one at `begin` on: out = base + Σ first_j x_j, and other = offset +
  /// factor Σ second_j x_j; no offset: nullptr. The arrays begin with the vectors.
  void operator()(Eigen::Index begin, Eigen::Index count, const double* base, double* out, double factor,
                  const double* offset, double* other);

 private:
  void (*run_)(const simd::WeightsOfTwo& weights, double factor, const double* base, double* out,
               const double* offset, double* other, std::ptrdiff_t n) = nullptr;
  std::vector<double> first_, second_;
  std::vector<const double*> x_, terms_;  ///< where they begin, and where they are read
};

}  // namespace planar_chain::ode
