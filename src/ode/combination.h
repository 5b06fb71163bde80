#pragma once

/// Sums of vectors by rows of a method's table, in one pass over the components. They allocate when they are
/// made, and not later.

#include <Eigen/Core>
#include <vector>

namespace planar_chain::simd {
struct WeightsOfTwo;
}

namespace planar_chain::ode {

/// factor Σ_j w_j x_j
class Combination {
 public:
  /// Of the first x, of `size` components, which stay where they are. Leaves zeros out.
  Combination(const std::vector<double>& weights, const std::vector<double*>& x, Eigen::Index size);

  void operator()(double factor, double* sum) const {
    run_(factor, weights_.data(), terms_.data(), nullptr, sum, nullptr, size_);
  }

 private:
  void (*run_)(double factor, const double* weights, const double* const* terms, const double* base,
               double* sum, double* out, std::ptrdiff_t n) = nullptr;
  std::vector<double> weights_;
  std::vector<const double*> terms_;
  std::ptrdiff_t size_ = 0;
};

/// out = base + Σ_j v_j x_j and other = offset + factor Σ_j w_j x_j, some components of them.
class TwoCombinations {
 public:
  /// Of the first x, which stay where they are: `count` components, from the one at `begin` on.
  TwoCombinations(const std::vector<double>& v, const std::vector<double>& w, const std::vector<double*>& x,
                  Eigen::Index begin, Eigen::Index count);

  /// The arrays begin with these components; no offset: nullptr.
  void operator()(const double* base, double* out, double factor, const double* offset, double* other) const;

 private:
  void (*run_)(const simd::WeightsOfTwo& weights, double factor, const double* base, double* out,
               const double* offset, double* other, std::ptrdiff_t n) = nullptr;
  std::vector<double> v_, w_;
  std::vector<const double*> terms_;
  Eigen::Index count_;
};

}  // namespace planar_chain::ode
