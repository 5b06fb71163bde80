#pragma once

/// The data of the exact solve in lanes: complex numbers, rows of three, quantities one after the other,
/// right-hand sides and solutions.

#include <type_traits>

#include "lanes/lane_kernel.h"
#include "recursion/linearized.h"

namespace planar_chain::simd {
namespace {

// ---- Complex numbers in lanes ----------------------------------------------------------------

template <class Real>
struct ComplexOf {
  Real re, im;

  ComplexOf() = default;
  ComplexOf(Real re_, Real im_ = Real()) : re(re_), im(im_) {}

  friend ComplexOf operator+(ComplexOf a, ComplexOf b) { return {a.re + b.re, a.im + b.im}; }
  friend ComplexOf operator-(ComplexOf a, ComplexOf b) { return {a.re - b.re, a.im - b.im}; }
  friend ComplexOf operator-(ComplexOf a) { return {-a.re, -a.im}; }
  friend ComplexOf operator*(ComplexOf a, ComplexOf b) {
    return {mulAdd(a.re, b.re, -a.im * b.im), mulAdd(a.re, b.im, a.im * b.re)};
  }
  friend ComplexOf operator*(Real a, ComplexOf b) { return {a * b.re, a * b.im}; }
  friend ComplexOf operator/(Real a, ComplexOf b) {
    const Real scale = a / mulAdd(b.re, b.re, b.im * b.im);
    return {scale * b.re, -(scale * b.im)};
  }
  ComplexOf& operator+=(ComplexOf b) { return *this = *this + b; }
  ComplexOf& operator-=(ComplexOf b) { return *this = *this - b; }
};

template <class Real>
ComplexOf<Real> mulAdd(ComplexOf<Real> a, ComplexOf<Real> b, ComplexOf<Real> c) {
  return {mulAdd(a.re, b.re, mulAdd(-a.im, b.im, c.re)), mulAdd(a.re, b.im, mulAdd(a.im, b.re, c.im))};
}
template <class Real>
ComplexOf<Real> mulAdd(Real a, Real b, ComplexOf<Real> c) {
  return {mulAdd(a, b, c.re), c.im};
}
template <class Real>
ComplexOf<Real> mulAdd(Real a, ComplexOf<Real> b, ComplexOf<Real> c) {
  return {mulAdd(a, b.re, c.re), mulAdd(a, b.im, c.im)};
}

/// The real numbers that a number is made of.
template <class Scalar>
struct PartsOf {
  using type = Scalar;
};
template <class Real>
struct PartsOf<ComplexOf<Real>> {
  using type = Real;
};
template <class Scalar>
using PartOf = typename PartsOf<Scalar>::type;
template <class Scalar>
constexpr bool isOneLane = doubles<PartOf<Scalar>> == 1;

/// Rows of 3.
template <class Scalar>
struct Triple {
  Scalar x, y, z;
  friend Triple operator*(Scalar k, const Triple& a) { return {k * a.x, k * a.y, k * a.z}; }
  friend Triple operator-(const Triple& a) { return {-a.x, -a.y, -a.z}; }
};

/// k a + b
template <class Factor, class Scalar>
Triple<Scalar> mulAdd(Factor k, const Triple<Scalar>& a, const Triple<Scalar>& b) {
  return {mulAdd(k, a.x, b.x), mulAdd(k, a.y, b.y), mulAdd(k, a.z, b.z)};
}

// ---- Quantities number by number ------------------------------------------------------------------

/// f of each real number, in order.
template <class Real, class F>
inline ComplexOf<Real> mapped(ComplexOf<Real> a, F f) {
  return {f(a.re), f(a.im)};
}
template <class Scalar, class F>
inline Triple<Scalar> mapped(const Triple<Scalar>& a, F f) {
  return {mapped(a.x, f), mapped(a.y, f), mapped(a.z, f)};
}

/// One number in all lanes.
template <class Scalar>
Scalar everywhere(const double* from) {
  return mapped(Scalar(), [&from](auto a) { return decltype(a)(*from++); });
}

// ---- Right-hand sides and solutions ------------------------------------------------------------

/// A number of each body of step i. The parts of a complex number follow each other.
template <class Scalar>
[[gnu::always_inline]] inline Scalar numberAt(const double* values, int i) {
  using Real = PartOf<Scalar>;
  if constexpr (std::is_same_v<Scalar, Real>)
    return read<Real>(values, i);
  else {
    const Vec2<Real> both = readVector<Real>(values, i);
    return {both.x, both.y};
  }
}

template <int count>
[[gnu::always_inline]] inline void write(double* values, int i, PackOf<count> a) {
  a.store(values + static_cast<std::ptrdiff_t>(i) * count);
}
[[gnu::always_inline]] inline void write(double* values, int i, ComplexOf<Pack> a) {
  storePairs(values + 2 * static_cast<std::ptrdiff_t>(i) * laneCount, {a.re, a.im});
}
[[gnu::always_inline]] inline void write(double* values, int i, ComplexOf<Lane> a) {
  Writer{values + 2 * static_cast<std::ptrdiff_t>(i)}(a);
}

/// The number of the segment before; 0 for the first segment.
template <class Scalar>
inline Scalar ofSegmentBefore(Scalar all) {
  if constexpr (isOneLane<Scalar>)
    return Scalar();
  else
    return mapped(all, [](Pack a) { return shuffled(Pack(), a, [](int s) { return laneCount + s - 1; }); });
}

}  // namespace
}  // namespace planar_chain::simd
