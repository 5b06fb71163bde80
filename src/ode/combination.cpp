#include "planar_chain/ode/combination.h"

#include <cstddef>

#include "../simd/kernel.h"

namespace planar_chain::ode {

Combination::Combination(const std::vector<double>& weights, const std::vector<Eigen::VectorXd>& x) {
  if (weights.empty()) return;  // the row of the first stage, or of what the method has not
  for (std::size_t j = 0; j < weights.size(); ++j) {
    const bool isOnlyOne = terms_.empty() && j + 1 == weights.size();
    if (weights[j] == 0 && !isOnlyOne) continue;
    weights_.push_back(weights[j]);
    terms_.push_back(x[j].data());
  }
  size_ = x.front().size();
  run_ = simd::kernelFor(size_).vectors.combine[terms_.size() - 1];
}

TwoCombinations::TwoCombinations(const std::vector<double>& first, const std::vector<double>& second,
                                 const std::vector<Eigen::VectorXd>& x)
    : run_(simd::kernelFor(x.front().size()).vectors.combineForTwo), first_(first), second_(second) {
  for (std::size_t j = 0; j < first.size(); ++j) x_.push_back(x[j].data());
  terms_.resize(x_.size());
}

void TwoCombinations::operator()(Eigen::Index begin, Eigen::Index count, const double* base, double* out,
                                 double factor, const double* offset, double* other) {
  for (std::size_t j = 0; j < x_.size(); ++j) terms_[j] = x_[j] + begin;
  run_({first_.data(), second_.data(), terms_.data(), static_cast<int>(terms_.size())}, factor, base + begin,
       out + begin, offset ? offset + begin : nullptr, other + begin, count);
}

}  // namespace planar_chain::ode
