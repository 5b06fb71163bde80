#pragma once

/// Sums of vectors by the rows of a method's table, in one pass over the components. The constructor
/// allocates; the calls do not. The vectors k must outlive the row and stay where they are.

#include <Eigen/Core>
#include <vector>

#include "simd/vectors.h"

namespace planar_chain::ode {

/// Returns `stages`.
/// @throws std::invalid_argument if that is more than VectorKernel::mostTerms, which a row may have.
std::size_t checkedStages(std::size_t stages, const char* method);

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
  NystromRow(const std::vector<double>& weights, double drift, const std::vector<std::vector<double>>& a,
             const std::vector<double*>& k, Eigen::Index positions, Eigen::Index others);
  /// A plain sum of `count` components of each k.
  NystromRow(const std::vector<double>& weights, const std::vector<double*>& k, Eigen::Index count)
      : NystromRow(weights, 0, {}, k, 0, count) {}

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
