#include "lanes/motion_series.h"

#include <algorithm>
#include <cmath>

#include "lanes/lane_order.h"

namespace planar_chain {

namespace {

using simd::SeriesArrays;

/// The products of a chain. One chain takes them chunk by chunk, in lanes.
int widthOf(int n, int lanes, bool holdsTip) {
  if (n == 2 && !holdsTip) return SeriesArrays::chunk;
  if (lanes > 1) return n == 1 ? 2 : SeriesArrays::columns * n;
  const int chunks = (SeriesArrays::columns * n + SeriesArrays::chunk - 1) / SeriesArrays::chunk;
  return chunks * SeriesArrays::chunk;
}

}  // namespace

SeriesStorage::SeriesStorage(int n, int order, int lanes, bool holdsTip)
    : n_(n), width_(widthOf(n, lanes, holdsTip)), lanes_(index(lanes)) {
  constexpr int linkNumbers = sizeof(simd::SeriesLink<double>) / sizeof(double);
  const auto make = [this](CacheLines& array, int numbers) { array.resize(index(numbers) * lanes_); };
  make(rows_, 2 * width_ * (order + 2));
  make(known_, (lanes > 1 ? SeriesArrays::knownOrders : 1) * width_);
  make(bodies_, SeriesArrays::bodyNumbers * n);
  make(tip_, holdsTip ? SeriesArrays::tipNumbers * n : 0);
  make(links_, linkNumbers * n);
  e_.resize(index(n * (order + 2)) * lanes_);
  if (n > 2 || lanes > 1) return;
  make(inverses_, 4 * (order + 2));
  for (int k = 1; k < order + 2; ++k) {
    const double whole = 1.0 / k, rest = std::fma(-k, whole, 1) * whole;
    std::fill_n(inverses_.data() + 4 * k, 2, whole);
    std::fill_n(inverses_.data() + 4 * k + 2, 2, rest);
  }
}

void SeriesStorage::put(int j, std::size_t lane, const Link& link) {
  const double J = link.inertia + link.mass * dot(link.com, link.com);
  const Vec2d mr = link.mass * link.com;
  putInLane(links_.data(), index(j) * lanes_ + lane, lanes_,
            {link.mass, link.inertia, J, mr.x, mr.y, link.pin.x, link.pin.y});
}

void SeriesStorage::putCart(const Chain& chain) {
  const Link &cart = chain.links()[0], &pole = chain.links()[1];
  const Vec2d axis = chain.joints()[0].axis;
  const double mass = cart.mass + pole.mass, r = length(pole.com);
  const Vec2d com = r > 0 ? 1 / r * pole.com : axis;
  new (links_.data()) simd::SeriesCart{mass,
                                       1 / mass,
                                       pole.mass * r,
                                       mass * pole.inertia + cart.mass * pole.mass * r * r,
                                       {dot(axis, com), cross(axis, com)},
                                       axis};
}

MotionSeries::MotionSeries(const Chain& chain, int order, const simd::Kernel& kernel, bool holdsTip)
    : n_(chain.size()),
      leading_(chain.coordinates().leading()),
      orders_(order),
      holdsTip_(holdsTip),
      kernel_(kernel),
      run_(kernel_.series[leading_ > 0 ? 4
                          : holdsTip   ? 3
                                       : std::min(n_, 3) - 1]),
      storage_(n_, order, 1, holdsTip) {
  if (leading_ > 0) storage_.putCart(chain);
  for (int j = 0; j < n_ && leading_ == 0; ++j) storage_.put(j, 0, chain.links()[index(j)]);
}

const simd::Kernel& MotionSeries::kernelFor(const Chain& chain, simd::KernelChoice choice) {
  // The registers of AVX-512 hold all numbers of a cart and its pole: 1.5 % less time.
  if (chain.coordinates().leading() > 0) return *simd::kernels(choice).front();
  return simd::kernelFor(chain.size(), choice);
}

bool MotionSeries::areFor(const Chain& chain) {
  const Coordinates& coordinates = chain.coordinates();
  return !coordinates.anyIsPrismatic() || (chain.size() == 2 && coordinates.leading() == 1);
}

void MotionSeries::find(int order, const Loads& external, SeriesLoads* loads, double* c,
                        const double* carry) {
  kernel_.rotations(c + leading_, &storage_.e()[leading_].c, n_ - leading_);
  for (int j = leading_; carry && j < n_; ++j) {
    Rotation<double>& e = storage_.e()[j];
    e = {e.c - carry[j] * e.s, e.s + carry[j] * e.c};
  }
  run_(storage_.arrays(), order, external, loads, c);
}

bool MotionSeries::areWorthwhile(int n) {
  return n <= 200;  // coefficients of more leave the caches
}

double MotionSeries::cost(int order) const {
  // By clock, for a cart and its pole, one link, two, and others, whose evaluations are faster the longer the
  // chain.
  const double perOrder = leading_ > 0 ? 0.12
                          : n_ == 1    ? 0.42
                          : n_ == 2    ? 0.6
                          : n_ <= 16   ? 1.4
                          : n_ <= 50   ? 2
                                       : 3.6;
  return (holdsTip_ ? 0.5 : 1) * perOrder * order;
}

}  // namespace planar_chain
