#pragma once

/// The data of the exact solve in lanes: complex numbers, rows of three, quantities one after the other,
/// right-hand sides and solutions.

#include <type_traits>

#include "lanes/lane_kernel.h"
#include "recursion/linearized.h"

namespace planar_chain::simd {
namespace {

// ---- Complex numbers in lanes ----------------------------------------------------------------

template <class Part>
struct ComplexOf {
  Part re, im;

  ComplexOf() = default;
  ComplexOf(Part re_, Part im_ = Part()) : re(re_), im(im_) {}

  friend ComplexOf operator+(ComplexOf a, ComplexOf b) { return {a.re + b.re, a.im + b.im}; }
  friend ComplexOf operator-(ComplexOf a, ComplexOf b) { return {a.re - b.re, a.im - b.im}; }
  friend ComplexOf operator-(ComplexOf a) { return {-a.re, -a.im}; }
  friend ComplexOf operator*(ComplexOf a, ComplexOf b) {
    return {mulAdd(a.re, b.re, -a.im * b.im), mulAdd(a.re, b.im, a.im * b.re)};
  }
  friend ComplexOf operator*(Part a, ComplexOf b) { return {a * b.re, a * b.im}; }
  friend ComplexOf operator/(Part a, ComplexOf b) {
    const Part scale = a / mulAdd(b.re, b.re, b.im * b.im);
    return {scale * b.re, -(scale * b.im)};
  }
  ComplexOf& operator+=(ComplexOf b) { return *this = *this + b; }
  ComplexOf& operator-=(ComplexOf b) { return *this = *this - b; }
};

template <class Part>
ComplexOf<Part> mulAdd(ComplexOf<Part> a, ComplexOf<Part> b, ComplexOf<Part> c) {
  return {mulAdd(a.re, b.re, mulAdd(-a.im, b.im, c.re)), mulAdd(a.re, b.im, mulAdd(a.im, b.re, c.im))};
}
template <class Part>
ComplexOf<Part> mulAdd(Part a, Part b, ComplexOf<Part> c) {
  return {mulAdd(a, b, c.re), c.im};
}
template <class Part>
ComplexOf<Part> mulAdd(Part a, ComplexOf<Part> b, ComplexOf<Part> c) {
  return {mulAdd(a, b.re, c.re), mulAdd(a, b.im, c.im)};
}

/// The real numbers that a number is made of.
template <class Number>
struct PartsOf {
  using type = Number;
};
template <class Part>
struct PartsOf<ComplexOf<Part>> {
  using type = Part;
};
template <class Number>
using PartOf = typename PartsOf<Number>::type;
template <class Number>
constexpr bool isOneLane = doubles<PartOf<Number>> == 1;

/// Rows of 3.
template <class Number>
struct Triple {
  Number x, y, z;
  friend Triple operator*(Number k, const Triple& a) { return {k * a.x, k * a.y, k * a.z}; }
  friend Triple operator-(const Triple& a) { return {-a.x, -a.y, -a.z}; }
};

/// k a + b
template <class Factor, class Number>
Triple<Number> mulAdd(Factor k, const Triple<Number>& a, const Triple<Number>& b) {
  return {mulAdd(k, a.x, b.x), mulAdd(k, a.y, b.y), mulAdd(k, a.z, b.z)};
}

// ---- Quantities number by number ------------------------------------------------------------------

/// f of each real number, in order.
template <class Part, class F>
inline ComplexOf<Part> mapped(ComplexOf<Part> a, F f) {
  return {f(a.re), f(a.im)};
}
template <class Number, class F>
inline Triple<Number> mapped(const Triple<Number>& a, F f) {
  return {mapped(a.x, f), mapped(a.y, f), mapped(a.z, f)};
}

/// The same number in all lanes.
template <class Number>
Number everywhere(const double* from) {
  return mapped(Number(), [&from](auto a) { return decltype(a)(*from++); });
}

// ---- Right-hand sides and solutions ------------------------------------------------------------

/// A number of each body of step i. The parts of a complex number lie side by side.
template <class Number>
[[gnu::always_inline]] inline Number numberAt(const double* values, int i) {
  using Part = PartOf<Number>;
  if constexpr (std::is_same_v<Number, Part>)
    return read<Part>(values, i);
  else {
    const Vec2<Part> both = readVector<Part>(values, i);
    return {both.x, both.y};
  }
}

template <int count>
[[gnu::always_inline]] inline void write(double* values, int i, LanesOf<count> a) {
  a.store(values + static_cast<std::ptrdiff_t>(i) * count);
}
[[gnu::always_inline]] inline void write(double* values, int i, ComplexOf<Real> a) {
  storePairs(values + 2 * static_cast<std::ptrdiff_t>(i) * laneCount, {a.re, a.im});
}
[[gnu::always_inline]] inline void write(double* values, int i, ComplexOf<Number> a) {
  Writer{values + 2 * static_cast<std::ptrdiff_t>(i)}(a);
}

/// The number of the segment before; 0 for the first segment.
template <class Number>
inline Number ofSegmentBefore(Number all) {
  if constexpr (isOneLane<Number>)
    return Number();
  else
    return mapped(all, [](Real a) { return shuffled(Real(), a, [](int s) { return laneCount + s - 1; }); });
}

}  // namespace
}  // namespace planar_chain::simd
