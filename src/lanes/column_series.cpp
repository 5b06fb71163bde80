#include "lanes/column_series.h"

#include <algorithm>

namespace planar_chain {

namespace simd {

const std::vector<const ColumnKernel*>& columnKernels(KernelChoice choice) {
#ifdef PLANAR_CHAIN_X86
  const ColumnKernel* avx2 = &columnsAvx2;
#else
  const ColumnKernel* avx2 = nullptr;
#endif
#ifdef PLANAR_CHAIN_AVX512
  const ColumnKernel* avx512 = &columnsAvx512;
#else
  const ColumnKernel* avx512 = nullptr;
#endif
  return runnable<ColumnKernel>(avx512, avx2, columnsBaseline, choice);
}

}  // namespace simd

using simd::ColumnArrays;

bool ColumnSeries::areFor(const Chain& chain) {
  return chain.size() <= ColumnArrays::most && !chain.coordinates().anyIsInside();
}

Eigen::VectorXd ColumnSeries::termsOf(const Chain& chain) {
  const int n = chain.size(), leading = chain.coordinates().leading();
  Eigen::VectorXd terms = Eigen::VectorXd::Zero(Terms::count(n));
  const auto conjugateTimes = [](Vec2d a, Vec2d b) { return Vec2d{dot(a, b), cross(a, b)}; };
  const auto arm = [&](int i) {
    return i < leading ? chain.joints()[index(i)].axis : chain.links()[index(i)].pin;
  };
  double behind = 0;  // kg
  for (int j = n - 1; j >= 0; --j) {
    const Link& link = chain.links()[index(j)];
    const double mass = behind + link.mass;
    const Vec2d S = j < leading ? mass * arm(j) : link.mass * link.com + behind * link.pin;
    terms[Terms::inertia(j)] =
        j < leading ? mass
                    : link.inertia + link.mass * dot(link.com, link.com) + behind * dot(link.pin, link.pin);
    const Vec2d weight = conjugateTimes(S, chain.gravity());
    terms.segment<2>(Terms::weight(j, n)) << weight.x, weight.y;
    for (int i = 0; i < j; ++i) {
      const Vec2d c = conjugateTimes(arm(i), S);
      terms.segment<2>(Terms::coupling(i, j, n)) << c.x, c.y;
    }
    behind = mass;
  }
  return terms;
}

ColumnSeries::ColumnSeries(const Chain& chain, int order, int columns, int numbers,
                           const simd::ColumnKernel& kernel)
    : kernel_(kernel), e_(index(chain.size())) {
  constexpr int line = 8;
  const auto rounded = [](int count) { return (count + line - 1) / line * line; };
  const int n = chain.size(), lanes = kernel_.lanes, width = (columns + lanes - 1) / lanes * lanes;
  const int apart = ColumnArrays::before + rounded(order + 2) + line;
  own_.resize(index(Terms::count(n)));
  Eigen::Map<Eigen::VectorXd>(own_.data(), Terms::count(n)) = termsOf(chain);
  changes_.resize(index(numbers * Terms::count(n)));
  free_.assign(index(n), 1);
  inverses_.resize(index(order + 2));
  for (int k = 1; k < order + 2; ++k) inverses_[index(k)] = 1.0 / k;
  series_.resize(index(ColumnArrays::count(n) * apart));
  inverse_.resize(index(n * n));
  columns_.resize(index((order + 2) * n * width));
  sources_.resize(index(order * n * width));
  values_.resize(index(2 * n * width));
  arrays_ = {n,
             chain.coordinates().leading(),
             order,
             apart,
             width,
             numbers,
             columns - numbers,
             own_.data(),
             changes_.data(),
             free_.data(),
             inverses_.data(),
             series_.data(),
             inverse_.data(),
             columns_.data(),
             sources_.data()};
  for (int j = 0; j < arrays_.leading; ++j) series(5 * j + 1)[0] = -1;
  double* const following = series(ColumnArrays::count(n) - 1);
  for (int k = 0; k < apart - ColumnArrays::before; ++k) following[k] = k + 1;
}

Eigen::Map<Eigen::VectorXd> ColumnSeries::change(int number) {
  const int count = Terms::count(arrays_.n);
  return {changes_.data() + number * count, count};
}

void ColumnSeries::setSource(int column, int joint, double torque) {
  sources_[place(0, joint, column)] = torque;
}

void ColumnSeries::find(const double* c) {
  const int leading = arrays_.leading, n = arrays_.n;
  kernel_.rotations(c + leading, &e_.data()->c, n - leading);
  for (int j = leading; j < n; ++j) {
    series(5 * j)[0] = e_[index(j - leading)].c;
    series(5 * j + 1)[0] = e_[index(j - leading)].s;
  }
  kernel_.find(arrays_, c);
}

double ColumnSeries::evaluate(double h) {
  // Shares of the last orders, as in ode/taylor.h.
  double weights[ColumnArrays::tail], share = 1;
  for (double& weight : weights) {
    weight = share;
    share /= 4;
  }
  double power = 1;
  for (int k = 0; k <= arrays_.order; ++k) {
    const int j = arrays_.order - k;
    if (j < ColumnArrays::tail) weights[j] *= power;
    power *= h;
  }
  return kernel_.at(arrays_, h, weights, values_.data());
}

void ColumnSeries::take() {
  std::copy(values_.begin(), values_.end(), columns_.begin());
}

}  // namespace planar_chain
