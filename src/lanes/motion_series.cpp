#include "lanes/motion_series.h"

#include <algorithm>
#include <cmath>

#include "lanes/kernel.h"

namespace planar_chain {

constexpr int columns = simd::SeriesArrays::columns, chunk = simd::SeriesArrays::chunk;

MotionSeries::MotionSeries(const Chain& chain, int orders, const simd::Kernel* kernel)
    : n_(chain.size()),
      orders_(orders),
      kernel_(kernel ? *kernel : simd::kernelFor(n_)),
      run_(kernel_.series[std::min(n_, 3) - 1]),
      width_(n_ <= 2 ? chunk : (columns * n_ + chunk - 1) / chunk * chunk),
      factors_(index(2 * width_) * index(orders + 1)),
      known_(index(width_)),
      bodies_(index(n_ * simd::SeriesArrays::bodyNumbers)),
      inverses_(index(n_ == 1 ? 4 * (orders + 2) : 0)),
      e_(index(n_) * index(orders + 2)) {
  for (const Link& link : chain.links()) {
    const double J = link.inertia + link.mass * dot(link.com, link.com);
    links_.push_back({link.mass, link.inertia, J, link.mass * link.com, link.pin});
  }
  for (int k = 1; n_ == 1 && k < orders + 2; ++k) {
    const double whole = 1.0 / k, rest = std::fma(-k, whole, 1) * whole;
    std::fill_n(inverses_.data() + 4 * k, 2, whole);
    std::fill_n(inverses_.data() + 4 * k + 2, 2, rest);
  }
}

MotionSeries::~MotionSeries() = default;

void MotionSeries::find(int order, const Outside& outside, SeriesLoads* loads, double* c,
                        const double* carry) {
  kernel_.rotations(c, &e_.front().c, n_);
  for (int j = 0; carry && j < n_; ++j) {
    Rotation<double>& e = e_[index(j)];
    e = {e.c - carry[j] * e.s, e.s + carry[j] * e.c};
  }
  run_({n_, width_, factors_.data(), known_.data(), bodies_.data(), &e_.front().c, &links_.front().m,
        inverses_.data()},
       order, outside, loads, c);
}

bool MotionSeries::areWorthwhile(int n) {
  return n <= 200;  // coefficients of more leave the caches
}

double MotionSeries::cost(int order) const {
  // By clock, for one link, two, and others, whose evaluations are faster the longer the chain.
  const double perOrder = n_ == 1 ? 0.42 : n_ == 2 ? 0.6 : n_ <= 16 ? 1.4 : n_ <= 50 ? 2 : 3.6;
  return perOrder * order;
}

}  // namespace planar_chain
