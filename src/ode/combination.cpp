#include "ode/combination.h"

#include <cstddef>

#include "simd/vectors.h"

namespace planar_chain::ode {

Combination::Combination(const std::vector<double>& weights, const std::vector<double*>& x, Eigen::Index size)
    : size_(size) {
  if (weights.empty()) return;  // the row of the first stage, or of what the method has not
  for (std::size_t j = 0; j < weights.size(); ++j) {
    const bool isOnlyOne = terms_.empty() && j + 1 == weights.size();
    if (weights[j] == 0 && !isOnlyOne) continue;
    weights_.push_back(weights[j]);
    terms_.push_back(x[j]);
  }
  run_ = simd::vectorsFor(size_).combine[terms_.size() - 1];
}

TwoCombinations::TwoCombinations(const std::vector<double>& v, const std::vector<double>& w,
                                 const std::vector<double*>& x, Eigen::Index begin, Eigen::Index count)
    : v_(v), w_(w), count_(count) {
  for (std::size_t j = 0; j < v.size(); ++j) terms_.push_back(x[j] + begin);
  if (!terms_.empty()) run_ = simd::vectorsFor(count).combineForTwo[terms_.size() - 1];
}

void TwoCombinations::operator()(const double* base, double* out, double factor, const double* offset,
                                 double* other) const {
  run_({v_.data(), w_.data(), terms_.data()}, factor, base, out, offset, other, count_);
}

}  // namespace planar_chain::ode
