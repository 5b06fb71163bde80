#pragma once

/// A row of an explicit method's table for a system with positions θ, whose rates are θ̇ = ω, and ω̇ = α:
///
///     ω_i = ω + h Σ_j a_ij α_j
///     θ_i = θ + h c_i ω + h² Σ_j ā_ij α_j            ā = a a
///
/// Nyström's form (Hairer, Nørsett, Wanner, Solving ODEs I, section II.14) of what the method does in any
/// case: the rates of the stages are neither kept nor read, and each α_j is read once for both. What stands
/// behind the rates, or all of it where there are no positions, goes by the row itself.

#include <Eigen/Core>
#include <vector>

namespace planar_chain::simd {
struct NystromSums;
}

namespace planar_chain::ode {

class NystromRow {
 public:
  /// No row at all.
  NystromRow() = default;
  /// weights: a row with at most one entry a stage; drift: what they add up to; a: the method's; k_j: α_j and
  /// the derivatives of so many others behind, which stay where they are. Allocates.
  NystromRow(const std::vector<double>& weights, double drift, const std::vector<std::vector<double>>& a,
             const std::vector<double*>& k, Eigen::Index positions, Eigen::Index others);

  /// sum: without θ and ω, from those of base; out: with them; either may be nullptr. Allocates nothing.
  void run(double h, const double* base, double* sum, double* out) const {
    if (positions_ > 0) return runTwice(h, base, sum, out);
    combine_(h, rates_.data(), terms_.data(), base, sum, out, others_);
  }

  /// The two parts of run(), where there are positions: what is to be summed for them and their rates, by
  /// whoever makes the last term; and the others behind.
  simd::NystromSums sums(double h, const double* base, double* sum, double* out) const;
  void runOthers(double h, const double* base, double* sum, double* out) const;
  /// Whether that is the last term.
  bool endsWith(const double* k) const { return !terms_.empty() && terms_.back() == k; }

 private:
  void runTwice(double h, const double* base, double* sum, double* out) const;

  void (*combineTwice_)(const simd::NystromSums& row, std::ptrdiff_t n) = nullptr;
  void (*combine_)(double factor, const double* weights, const double* const* terms, const double* base,
                   double* sum, double* out, std::ptrdiff_t n) = nullptr;
  std::vector<double> rates_, twice_;
  std::vector<const double*> terms_, otherTerms_;
  double drift_ = 0;
  Eigen::Index positions_ = 0, others_ = 0;
};

/// A row that is to be run as soon as its last term is there.
struct RowAhead {
  const NystromRow& row;
  double h;
  const double* base;
  double *sum, *out;

  void run() const { row.run(h, base, sum, out); }
};

}  // namespace planar_chain::ode
