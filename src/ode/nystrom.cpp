#include "ode/nystrom.h"

#include <cmath>

#include "simd/vectors.h"

namespace planar_chain::ode {

namespace {

constexpr double vanishing = 1e-14;  // what rounding leaves of sums that are zero

/// weights a
std::vector<double> timesTable(const std::vector<double>& weights,
                               const std::vector<std::vector<double>>& a) {
  std::vector<double> product(weights.size());
  for (std::size_t i = 0; i < weights.size(); ++i) {
    for (std::size_t j = 0; j < a[i].size(); ++j) product[j] += weights[i] * a[i][j];
  }
  return product;
}

}  // namespace

NystromRow::NystromRow(const std::vector<double>& weights, double drift,
                       const std::vector<std::vector<double>>& a, const std::vector<double*>& k,
                       Eigen::Index positions, Eigen::Index others)
    : drift_(drift), positions_(positions), others_(others) {
  if (weights.empty()) return;  // the row of the first stage, or of what the method has not
  const std::vector<double> twice = timesTable(weights, a);
  for (std::size_t j = 0; j < weights.size(); ++j) {
    const bool isOnlyOne = terms_.empty() && j + 1 == weights.size();
    const double forPositions = std::abs(twice[j]) > vanishing ? twice[j] : 0;
    if (weights[j] == 0 && forPositions == 0 && !isOnlyOne) continue;
    rates_.push_back(weights[j]);
    twice_.push_back(forPositions);
    terms_.push_back(k[j]);
    otherTerms_.push_back(k[j] + positions);
  }
  combineTwice_ = simd::vectorsFor(positions).combineTwice[terms_.size() - 1];
  combine_ = simd::vectorsFor(others).combine[terms_.size() - 1];
}

simd::NystromSums NystromRow::sums(double h, const double* base, double* sum, double* out) const {
  return {rates_.data(),
          twice_.data(),
          terms_.data(),
          static_cast<int>(terms_.size()),
          drift_,
          h,
          base,
          sum,
          out};
}

void NystromRow::runTwice(double h, const double* base, double* sum, double* out) const {
  combineTwice_(sums(h, base, sum, out), positions_);
  runOthers(h, base, sum, out);
}

void NystromRow::runOthers(double h, const double* base, double* sum, double* out) const {
  if (others_ == 0) return;
  const auto behind = [this](auto* values) { return values ? values + 2 * positions_ : nullptr; };
  combine_(h, rates_.data(), otherTerms_.data(), base + 2 * positions_, behind(sum), behind(out), others_);
}

}  // namespace planar_chain::ode
