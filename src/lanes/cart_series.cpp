#include "lanes/cart_series.h"

#include <algorithm>
#include <cmath>

namespace planar_chain {

namespace {

/// Σ_{0<j<k} a_j b_{k+1−j}, from the middle on: the last orders have hardly been stored.
inline Eigen::Array4d innerSum(const Eigen::Array4d* a, const Eigen::Array4d* b, int k) {
  Eigen::Array4d sums[2] = {Eigen::Array4d::Zero(), Eigen::Array4d::Zero()};
  int low = k / 2, high = k - low;
  if (low == high) {
    if (low > 0) sums[0] = a[low] * b[low + 1];
    --low;
    ++high;
  }
  for (; low > 0; --low, ++high) {
    sums[0] += a[low] * b[high + 1];
    sums[1] += a[high] * b[low + 1];
  }
  return sums[0] + sums[1];
}

}  // namespace

CartSeries::CartSeries(const Chain& chain, int orders)
    : rail_(chain.joints()[0].axis),
      mr_(chain.links()[1].mass * chain.links()[1].com),
      cart_(chain.links()[0].mass),
      whole_(cart_ + chain.links()[1].mass),
      inertia_(chain.links()[1].inertia),
      J_(inertia_ + dot(chain.links()[1].com, mr_)),
      orders_(orders),
      first_(index(orders)),
      second_(index(orders + 2)),
      e_(2 * index(orders + 2)) {
  for (int k = 0; k < orders + 2; ++k) {
    const double whole = 1.0 / std::max(k, 1);
    inverses_.push_back({whole, std::fma(-k, whole, 1) * whole});
  }
}

void CartSeries::find(int order, Rotation<double> e, Vec2d ground, const double* N, const Vec2d* F,
                      SeriesLoads* loads, double* c) {
  found_ += order;
  const auto over = [this](int k, double a) {
    const auto& [whole, rest] = inverses_[index(k)];
    return a * whole + a * rest;
  };
  // h and S×g₋ of a rotation
  const double hc = cross(mr_, rail_), hs = cross(perp(mr_), rail_);
  const double gc = cross(mr_, ground), gs = cross(perp(mr_), ground);
  const auto h = [&](Rotation<double> of) { return hc * of.c + hs * of.s; };

  // The solution of both equations; M J − h_0² without cancellation.
  const double h0 = h(e), along0 = dot(e * mr_, rail_);
  const double inverse = 1 / (whole_ * inertia_ + cart_ * (J_ - inertia_) + along0 * along0);
  const double ofX = J_ * inverse, ofBoth = -h0 * inverse, ofAlpha = whole_ * inverse;

  const Rotation<double> ie0{-e.s, e.c};
  const double omega0 = c[3];
  double omega = omega0, x0 = 0, known = -whole_ * dot(ground, rail_);
  const Rotation<double> e1{omega * ie0.c, omega * ie0.s};
  Rotation<double> present = e, next = e1;  // e_k and e_{k+1}
  e_[1] = e;
  e_[3] = e1;
  for (int k = 0; k < order; ++k) {
    double* row = c + std::ptrdiff_t{4} * k;
    if (loads && k > 0) loads->findOrder(k, row, row + 2);
    const Eigen::Array4d sum = innerSum(first_.data(), second_.data(), k);
    Rotation<double> z{sum[0] + omega * e1.c, sum[1] + omega * e1.s};
    if (k > 0) z = {z.c + omega0 * next.c, z.s + omega0 * next.s};
    double along = known, turning = -sum[2] - (gc * present.c + gs * present.s);
    if (k > 0) turning -= x0 * h(present);
    if (N) {
      along += N[0];
      turning += N[1];
    }
    if (F) along += dot(rail_, F[0] + F[1]);
    known = 0;  // of order 0 alone

    along -= (k + 1) * h(z);
    const double x = ofX * along + ofBoth * turning, alpha = ofBoth * along + ofAlpha * turning;
    if (k == 0) x0 = x;
    first_[index(k)] = {omega, omega, x, 0};
    second_[index(k) + 1] = {next.c, next.s, h(present), 0};

    row[4] = over(k + 1, row[2]);
    row[5] = over(k + 1, omega);
    row[6] = over(k + 1, x);
    row[7] = omega = over(k + 1, alpha);
    present = next;
    next = {over(k + 2, omega * ie0.c - z.s), over(k + 2, omega * ie0.s + z.c)};
    e_[2 * index(k) + 5] = next;
  }
}

}  // namespace planar_chain
