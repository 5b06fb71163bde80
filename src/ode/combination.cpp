#include "ode/combination.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace planar_chain::ode {

namespace {

constexpr double vanishing = 1e-14;  // what rounding leaves of sums that are zero

/// weights a
std::vector<double> timesTable(const std::vector<double>& weights,
                               const std::vector<std::vector<double>>& a) {
  std::vector<double> product(weights.size());
  for (std::size_t i = 0; i < std::min(weights.size(), a.size()); ++i) {
    for (std::size_t j = 0; j < a[i].size(); ++j) product[j] += weights[i] * a[i][j];
  }
  return product;
}

}  // namespace

std::size_t checkedStages(std::size_t stages, const char* method) {
  if (stages <= simd::VectorKernel::mostTerms) return stages;
  throw std::invalid_argument(std::string(method) + " has " + std::to_string(stages) +
                              " stages; a method may have at most " +
                              std::to_string(simd::VectorKernel::mostTerms));
}

NystromRow::NystromRow(const std::vector<double>& weights, double drift,
                       const std::vector<std::vector<double>>& a, const std::vector<double*>& k,
                       Eigen::Index positions, Eigen::Index others)
    : drift_(drift), positions_(positions), others_(others) {
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
  if (terms_.empty()) return;
  combineTwice_ = simd::vectors().combineTwice[terms_.size() - 1];
  combine_ = simd::vectors().combine[terms_.size() - 1];
}

void NystromRow::runTwice(double h, const double* base, double* sum, double* out) const {
  combineTwice_({rates_.data(), twice_.data(), terms_.data(), drift_, h, base, sum, out}, positions_);
  if (others_ == 0) return;
  const auto behind = [this](auto* values) { return values ? values + 2 * positions_ : nullptr; };
  combine_(h, rates_.data(), otherTerms_.data(), base + 2 * positions_, behind(sum), behind(out), others_);
}

}  // namespace planar_chain::ode
