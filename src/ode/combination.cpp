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

std::vector<Combination> combinationsOf(const std::vector<std::vector<double>>& rows,
                                        const std::vector<Eigen::VectorXd>& x) {
  std::vector<Combination> combinations;
  for (const std::vector<double>& row : rows) combinations.emplace_back(row, x);
  return combinations;
}

}  // namespace planar_chain::ode
