#pragma once

/// Sums of vectors by the rows of a method's table, in one pass over the components. The constructors
/// allocate; the calls do not. A row has at most simd::VectorKernel::mostTerms terms, TwoCombinations at most
/// mostTermsForTwo. The vectors x, k must outlive these objects and stay where they are.

#include <Eigen/Core>
#include <vector>

#include "simd/vectors.h"

namespace planar_chain::ode {

/// @throws std::invalid_argument if a method has more stages than sums have terms.
void requireAtMost(std::size_t most, std::size_t stages, const char* method);

/// out = base + Σ_j v_j x_j and other = offset + factor Σ_j w_j x_j, for some components.
class TwoCombinations {
 public:
  /// For `count` components of each x, from component `begin` on.
  TwoCombinations(const std::vector<double>& v, const std::vector<double>& w, const std::vector<double*>& x,
                  Eigen::Index begin, Eigen::Index count);

  /// Each array begins with the first of these components. `offset` may be nullptr.
  void operator()(const double* base, double* out, double factor, const double* offset, double* other) const;

 private:
  simd::VectorKernel::CombineForTwo run_ = nullptr;
  std::vector<double> v_, w_;
  std::vector<const double*> terms_;
  Eigen::Index count_;
};

/// A row of an explicit method's table for a system with positions θ, whose rates are θ̇ = ω, and ω̇ = α:
///
///     ω_i = ω + h Σ_j a_ij α_j
///     θ_i = θ + h c_i ω + h² Σ_j ā_ij α_j            ā = a a
///
/// This is Nyström's form (Hairer, Nørsett, Wanner, Solving ODEs I, section II.14). The rates of the stages
/// are neither stored nor read, and each α_j is read once for both sums. Components behind the rates use the
/// row itself; without positions, all do.
class NystromRow {
 public:
  /// No row: run() must not be called.
  NystromRow() = default;
  /// weights: at most one a stage, and their sum `drift`. a: the method's. k_j: α_j of `positions`
  /// components, and behind them the derivatives of `others`.
  /// Without positions the row is a plain sum: `drift` and `a` do not matter.
  NystromRow(const std::vector<double>& weights, double drift, const std::vector<std::vector<double>>& a,
             const std::vector<double*>& k, Eigen::Index positions, Eigen::Index others);

  /// `sum` gets the sums, `out` those added to `base`. One of the two may be nullptr.
  void run(double h, const double* base, double* sum, double* out) const {
    if (positions_ > 0) return runTwice(h, base, sum, out);
    combine_(h, rates_.data(), terms_.data(), base, sum, out, others_);
  }

 private:
  void runTwice(double h, const double* base, double* sum, double* out) const;

  simd::VectorKernel::CombineTwice combineTwice_ = nullptr;
  simd::VectorKernel::Combine combine_ = nullptr;
  std::vector<double> rates_, twice_;
  std::vector<const double*> terms_, otherTerms_;
  double drift_ = 0;
  Eigen::Index positions_ = 0, others_ = 0;
};

}  // namespace planar_chain::ode
