#pragma once

/// The data of the exact solve in lanes: complex numbers, rows of three, quantities one after the other,
/// right-hand sides and solutions.

#include "lanes/lane_kernel.h"
#include "recursion/linearized.h"

namespace planar_chain::simd {
namespace {

// ---- Complex numbers in lanes ----------------------------------------------------------------

struct ComplexLanes {
  Real re, im;

  ComplexLanes() = default;
  ComplexLanes(Real re_, Real im_ = Real()) : re(re_), im(im_) {}

  friend ComplexLanes operator+(ComplexLanes a, ComplexLanes b) { return {a.re + b.re, a.im + b.im}; }
  friend ComplexLanes operator-(ComplexLanes a, ComplexLanes b) { return {a.re - b.re, a.im - b.im}; }
  friend ComplexLanes operator-(ComplexLanes a) { return {-a.re, -a.im}; }
  friend ComplexLanes operator*(ComplexLanes a, ComplexLanes b) {
    return {mulAdd(a.re, b.re, -a.im * b.im), mulAdd(a.re, b.im, a.im * b.re)};
  }
  friend ComplexLanes operator*(Real a, ComplexLanes b) { return {a * b.re, a * b.im}; }
  friend ComplexLanes operator/(Real a, ComplexLanes b) {
    const Real scale = a / mulAdd(b.re, b.re, b.im * b.im);
    return {scale * b.re, -(scale * b.im)};
  }
  ComplexLanes& operator+=(ComplexLanes b) { return *this = *this + b; }
  ComplexLanes& operator-=(ComplexLanes b) { return *this = *this - b; }
};

ComplexLanes mulAdd(ComplexLanes a, ComplexLanes b, ComplexLanes c) {
  return {mulAdd(a.re, b.re, mulAdd(-a.im, b.im, c.re)), mulAdd(a.re, b.im, mulAdd(a.im, b.re, c.im))};
}
ComplexLanes mulAdd(Real a, Real b, ComplexLanes c) {
  return {mulAdd(a, b, c.re), c.im};
}
ComplexLanes mulAdd(Real a, ComplexLanes b, ComplexLanes c) {
  return {mulAdd(a, b.re, c.re), mulAdd(a, b.im, c.im)};
}

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
template <class F>
inline ComplexLanes mapped(ComplexLanes a, F f) {
  return {f(a.re), f(a.im)};
}
template <class Number, class F>
inline Triple<Number> mapped(const Triple<Number>& a, F f) {
  return {mapped(a.x, f), mapped(a.y, f), mapped(a.z, f)};
}

/// The number of doubles of a number in each lane.
template <class Number>
constexpr int parts = sizeof(Number) / sizeof(Real);

/// The same number in all lanes.
template <class Number>
Number everywhere(const double* from) {
  return mapped(Number(), [&from](Real) { return Real(*from++); });
}

// ---- Right-hand sides and solutions ------------------------------------------------------------

/// A number of each body of step i. The parts of a complex number lie side by side.
[[gnu::always_inline]] inline void read(const double* values, int i, Real& a) {
  a = read(values, i);
}
[[gnu::always_inline]] inline void read(const double* values, int i, ComplexLanes& a) {
  const Vector both = readVector(values, i);
  a = {both.x, both.y};
}
template <class Number>
[[gnu::always_inline]] inline Number numberAt(const double* values, int i) {
  Number a;
  read(values, i, a);
  return a;
}

[[gnu::always_inline]] inline void write(double* values, int i, Real a) {
  a.store(values + static_cast<std::ptrdiff_t>(i) * laneCount);
}
[[gnu::always_inline]] inline void write(double* values, int i, ComplexLanes a) {
  storePairs(values + 2 * static_cast<std::ptrdiff_t>(i) * laneCount, {a.re, a.im});
}

/// The number of the segment before; 0 for the first segment.
template <class Number>
inline Number ofSegmentBefore(Number all) {
  return mapped(all, [](Real a) { return shuffled(Real(), a, [](int s) { return laneCount + s - 1; }); });
}

}  // namespace
}  // namespace planar_chain::simd
