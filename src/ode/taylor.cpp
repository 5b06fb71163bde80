#include "ode/taylor.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <mutex>

#include "simd/elementary.h"

namespace planar_chain::ode {

namespace {

/// Returns of(number). Only the first call for a number computes it.
template <auto of>
const auto& known(int number) {
  static std::mutex mutex;
  static std::map<int, decltype(of(number))> values;
  const std::lock_guard<std::mutex> lock(mutex);
  const auto found = values.find(number);
  return found != values.end() ? found->second : values.emplace(number, of(number)).first->second;
}

/// The longest stretch |z| of the imaginary axis on which the truncated exponential Σ z^k/k! does not grow,
/// by more than `unnoticed`.
double stabilityLimitOf(int order) {
  constexpr double fine = 0.1, unnoticed = 1e-6;  // growth by e in a million steps
  for (double size = fine;; size += fine) {
    std::complex<double> sum = 1, term = 1;
    for (int k = 1; k <= order; ++k) sum += term *= std::complex<double>(0, size) / static_cast<double>(k);
    if (std::abs(sum) > 1 + unnoticed) return size - fine;
  }
}

MethodFacts factsFor(int order) {
  constexpr int pieces = 4;
  return {"taylor", order, order - 1, known<stabilityLimitOf>(order), false, pieces};
}

/// x^k by squaring. std::pow takes as long as an order of the series.
double power(double x, int k) {
  double result = 1;
  for (; k > 0; k /= 2, x *= x) {
    if (k % 2 == 1) result *= x;
  }
  return result;
}

}  // namespace

/// The cheapest order for two and ten links by trials. Jorba and Zou's 1 − ½ ln(tolerance) is best if the
/// work grows with the order's square. Here most of it grows with the order. Another order costs time alone.
int Taylor::orderFor(double tolerance) {
  constexpr int least = 14, most = 34;
  return std::min(std::max(static_cast<int>(std::lround(14 - 0.388 * simd::log2(tolerance))), least), most);
}

Taylor::Taylor(SeriesSystem& f, double tolerance)
    : Stepper(factsFor(orderFor(tolerance)), f),
      f_(f),
      c_(static_cast<std::size_t>((order_ + 1) * f.driving())) {
  f_.reserveSeries(order_);
  cost_ = f_.seriesCost(order_);
  if (integrandRates_.size() > 0) rule_ = gaussRule(order_ / 2 + 1);
}

namespace {

/// By Golub and Welsch: eigenvalues of the Legendre polynomials' recurrence.
Eigen::MatrixX2d golubWelsch(int count) {
  Eigen::VectorXd beside(count - 1);
  for (int k = 1; k < count; ++k) beside[k - 1] = k / std::sqrt(4.0 * k * k - 1);
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> roots;
  roots.computeFromTridiagonal(Eigen::VectorXd::Zero(count), beside);
  Eigen::MatrixX2d rule(count, 2);
  rule.col(0) = (roots.eigenvalues().array() + 1) / 2;
  rule.col(1) = roots.eigenvectors().row(0).array().square();
  return rule;
}

}  // namespace

Eigen::MatrixX2d Taylor::gaussRule(int count) {
  return known<golubWelsch>(count);
}

const Vector& Taylor::derivative(double t, const Vector& y) {
  findSeries(t, y);
  const auto driving = f_.driving();
  std::copy_n(c_.data() + driving, driving, sum_.data());
  if (integrandRates_.size() > 0) f_.integrands(t, inOrder(y, y_), sum_.data() + driving);
  f_.toLaneOrder(sum_.data(), derivative_.data());
  return derivative_;
}

Taylor::Shares Taylor::weightsAt(double h) const {
  Shares weights;
  double weight = caution * power(h, order_ + 1 - lookedBack);
  for (std::size_t k = 0; k < weights.size(); ++k, weight *= h) weights[k] = shares[k] * weight;
  return weights;
}

void Taylor::findError(const Shares& weights) {
  const auto driving = f_.driving();
  vectors_.tail(weights, c_.data() + (order_ + 1 - lookedBack) * driving, sumFor(error_).data(), driving);
  putInLaneOrder(error_);
}

/// Finds the increments of angles and rates.
void Taylor::findTurn(double h) {
  vectors_.polynomial(h, c_.data(), order_, sumFor(increment_).data(), f_.driving());
  putInLaneOrder(increment_);
}

void Taylor::findIncrement(double t, double h, const Vector& y) {
  const auto driving = static_cast<Eigen::Index>(f_.driving());
  findTurn(h);
  if (integrandRates_.size() == 0 || !f_.hasIntegrands()) return;
  const double* start = inOrder(y, y_);
  for (Eigen::Index k = 0; k < rule_.rows(); ++k) {
    vectors_.polynomial(rule_(k, 0) * h, c_.data(), order_, sum_.data(), driving);
    for (Eigen::Index i = 0; i < driving; ++i) sum_[i] += start[i];
    f_.integrands(t + rule_(k, 0) * h, sum_.data(), integrandRates_.data());
    increment_.tail(integrandRates_.size()) += h * rule_(k, 1) * integrandRates_;
  }
}

}  // namespace planar_chain::ode
