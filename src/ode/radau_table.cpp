#include <Eigen/Dense>

#include "ode/radau.h"

namespace planar_chain::ode {

namespace {

constexpr int s = RadauTable::stages;
using Wide = long double;
using WideVector = Eigen::Matrix<Wide, Eigen::Dynamic, 1>;
using WideSquare = Eigen::Matrix<Wide, Eigen::Dynamic, Eigen::Dynamic>;

/// Zeros of P_7 − P_6, computed with 40 digits.
constexpr Wide points[s] = {0.0293164271597848919721L,
                            0.14807859966848429185L,
                            0.336984690281154299097L,
                            0.558671518771550132081L,
                            0.769233862030054500917L,
                            0.926945671319741114852L,
                            1.0L};

/// Columns v, or Re v and −Im v, of W's eigenvectors; any length does.
void transform(const WideSquare& W, RadauTable& table) {
  const Eigen::EigenSolver<WideSquare> eigen(W);
  WideSquare T(s, s);
  int pair = 0;
  for (int k = 0; k < s; ++k) {
    const std::complex<Wide> value = eigen.eigenvalues()[k];
    const auto vector = eigen.eigenvectors().col(k).eval();
    if (value.imag() == 0) {
      table.lambda = static_cast<double>(value.real());
      T.col(0) = vector.real();
    } else if (value.imag() > 0) {
      table.mu[pair] = std::complex<double>(value);
      T.col(1 + 2 * pair) = vector.real();
      T.col(2 + 2 * pair) = -vector.imag();
      ++pair;
    }
  }
  table.T = T.cast<double>();
  table.inverseT = T.inverse().cast<double>();
}

RadauTable make() {
  RadauTable table;
  const WideVector c = Eigen::Map<const WideVector>(points, s);
  // Rows of c_i^k and of ∫₀^{c_i} x^k.
  WideSquare V(s, s), P(s, s);
  V.col(0).setOnes();
  for (int k = 0; k < s; ++k) {
    if (k > 0) V.col(k) = V.col(k - 1).cwiseProduct(c);
    P.col(k) = V.col(k).cwiseProduct(c) / (k + 1);
  }
  const WideSquare inverseV = V.inverse();
  const WideSquare A = P * inverseV;
  const WideSquare W = A.inverse();
  table.c = c.cast<double>();
  table.A = A.cast<double>();
  table.W = W.cast<double>();
  transform(W, table);
  // h f(t, y)/λ + h Σ d_i f_i = 0 for f = 1, x … x⁶: Σ d_i c_i^k = −1/λ for k = 0, else 0. h f_i is Σ W_ij
  // Z_j.
  table.e = (W.transpose() * inverseV.row(0).transpose() / -table.lambda).cast<double>();
  for (int j = 0; j < s; ++j) {
    Wide product = c[j];
    for (int m = 0; m < s; ++m) {
      if (m != j) product *= c[j] - c[m];
    }
    table.p[j] = static_cast<double>(1 / product);
  }
  return table;
}

}  // namespace

const RadauTable& radau13() {
  static const RadauTable table = make();
  return table;
}

}  // namespace planar_chain::ode
