#pragma once

/// Sums of vectors by the rows of a method's table, in one pass over the components. The constructor
/// and the calls allocate nothing. The vectors k must outlive the row and stay where they are.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "simd/vectors.h"

namespace planar_chain::ode {

/// Returns `stages`.
/// @throws std::invalid_argument if that is more than VectorKernel::mostTerms, which a row may have.
inline std::size_t checkedStages(std::size_t stages, const char* method) {
  if (stages <= simd::VectorKernel::mostTerms) return stages;
  throw std::invalid_argument(std::string(method) + " has " + std::to_string(stages) +
                              " stages; a method may have at most " +
                              std::to_string(simd::VectorKernel::mostTerms));
}

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
  NystromRow(const simd::VectorKernel& kernel, const std::vector<double>& weights, double drift,
             const std::vector<std::vector<double>>& a, const std::vector<double*>& k, Eigen::Index positions,
             Eigen::Index others)
      : drift_(drift), positions_(positions), others_(others) {
    constexpr double vanishing = 1e-14;  // what rounding leaves of sums that are zero
    OfTerms<double> twice{};             // weights a
    for (std::size_t i = 0; i < std::min(weights.size(), a.size()); ++i) {
      for (std::size_t j = 0; j < a[i].size(); ++j) twice[j] += weights[i] * a[i][j];
    }
    std::size_t count = 0;
    for (std::size_t j = 0; j < weights.size(); ++j) {
      const bool isOnlyOne = count == 0 && j + 1 == weights.size();
      const double forPositions = std::abs(twice[j]) > vanishing ? twice[j] : 0;
      if (weights[j] == 0 && forPositions == 0 && !isOnlyOne) continue;
      rates_[count] = weights[j];
      twice_[count] = forPositions;
      terms_[count] = k[j];
      otherTerms_[count] = k[j] + positions;
      ++count;
    }
    if (count == 0) return;
    combineTwice_ = kernel.combineTwice[count - 1];
    combine_ = kernel.combine[count - 1];
  }
  /// A plain sum of `count` components of each k.
  NystromRow(const simd::VectorKernel& kernel, const std::vector<double>& weights,
             const std::vector<double*>& k, Eigen::Index count)
      : NystromRow(kernel, weights, 0, {}, k, 0, count) {}

  /// `sum` gets the sums, `out` those added to `base`. One of the two may be nullptr.
  void run(double h, const double* base, double* sum, double* out) const {
    if (positions_ > 0) return runTwice(h, base, sum, out);
    combine_(h, rates_.data(), terms_.data(), base, sum, out, others_);
  }

 private:
  template <class T>
  using OfTerms = std::array<T, simd::VectorKernel::mostTerms>;

  void runTwice(double h, const double* base, double* sum, double* out) const {
    combineTwice_({rates_.data(), twice_.data(), terms_.data(), drift_, h, base, sum, out}, positions_);
    if (others_ == 0) return;
    const auto behind = [this](auto* values) { return values ? values + 2 * positions_ : nullptr; };
    combine_(h, rates_.data(), otherTerms_.data(), base + 2 * positions_, behind(sum), behind(out), others_);
  }

  simd::VectorKernel::CombineTwice combineTwice_ = nullptr;
  simd::VectorKernel::Combine combine_ = nullptr;
  OfTerms<double> rates_{}, twice_{};
  OfTerms<const double*> terms_{}, otherTerms_{};
  double drift_ = 0;
  Eigen::Index positions_ = 0, others_ = 0;
};

}  // namespace planar_chain::ode
