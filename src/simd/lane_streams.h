#pragma once

/// What the exact solve in lanes reads and writes: complex numbers, rows of three, quantities one after the
/// other, and the arrays of the caller, whose bodies stand in their order along the chain.

#include <algorithm>

#include "lane_kernel.h"
#include "planar_chain/linearized.h"

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
  friend ComplexLanes operator*(ComplexLanes b, Real a) { return a * b; }
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

/// How many doubles a number takes in each lane, and where they stand.
template <class Number>
constexpr int parts = sizeof(Number) / sizeof(Real);

Real& part(Real& a, int) {
  return a;
}
Real& part(ComplexLanes& a, int which) {
  return which == 0 ? a.re : a.im;
}

template <class Number>
Number loaded(const double* from) {
  Number a;
  for (int k = 0; k < parts<Number>; ++k) part(a, k) = Real::load(from + k * laneCount);
  return a;
}

template <class Number>
void store(Number a, double* to) {
  for (int k = 0; k < parts<Number>; ++k) part(a, k).store(to + k * laneCount);
}

/// The same number in all lanes.
template <class Number>
Number everywhere(const double* from) {
  Number a;
  for (int k = 0; k < parts<Number>; ++k) part(a, k) = Real(from[k]);
  return a;
}

/// What can be written is numbers and what consists of them.
template <class To, class Number>
struct WriterOf {
  template <class... Quantities>
  [[gnu::always_inline]] void operator()(const Quantities&... quantities) {
    (write(quantities), ...);
  }

 private:
  void write(const Number& a) { static_cast<To*>(this)->number(a); }
  void write(const Vec2<Number>& a) { (*this)(a.x, a.y); }
  void write(const Triple<Number>& a) { (*this)(a.x, a.y, a.z); }
};

/// One number after the other.
template <class Number>
struct Writer : WriterOf<Writer<Number>, Number> {
  double* to;
  explicit Writer(double* to_) : to(to_) {}
  void number(const Number& a) {
    store(a, to);
    to += parts<Number> * laneCount;
  }
};

/// Into rows of `mostLanes`.
template <class Number>
struct RowWriter : WriterOf<RowWriter<Number>, Number> {
  Rows to;
  explicit RowWriter(Rows to_) : to(to_) {}
  void number(Number a) {
    for (int k = 0; k < parts<Number>; ++k) part(a, k).store(*to++);
  }
};

template <class Number>
struct Reader {
  const double* from;
  explicit Reader(const double* from_) : from(from_) {}

  template <class... Quantities>
  [[gnu::always_inline]] void operator()(Quantities&... quantities) {
    (read(quantities), ...);
  }

 private:
  void read(Number& a) {
    a = loaded<Number>(from);
    from += parts<Number> * laneCount;
  }
  void read(Vec2<Number>& a) { (*this)(a.x, a.y); }
  void read(Triple<Number>& a) { (*this)(a.x, a.y, a.z); }
};

// ---- Arrays of the caller --------------------------------------------------------------------

/// A number of each body of step i + shift; 0 where there is none.
template <class Number, int shift = 0>
[[gnu::always_inline]] inline Number gathered(const LinearArrays& arrays, const double* values, int i) {
  Number a;
  for (int k = 0; k < parts<Number>; ++k) {
    part(a, k) = read<parts<Number>, shift>(arrays, values + k, i);
  }
  return a;
}

/// Rows become columns: groups of `size` lanes change places in pairs of rows, and so do all larger ones.
template <int size = 1>
[[gnu::always_inline]] inline void transpose(Real* rows) {
  if constexpr (size < laneCount) {
    for (int i = 0; i < laneCount; ++i) {
      if (i & size) continue;
      const Real inner = rows[i], outer = rows[i | size];
      rows[i] = either<size>(inner, ofInner<size>(outer));
      rows[i | size] = either<size>(ofOuter<size>(inner), outer);
    }
    transpose<2 * size>(rows);
  }
}

/// Steps that are moved at a time: their numbers fill a register of each lane.
template <class Number>
constexpr int stepsPerBlock = laneCount / parts<Number>;

/// True where all bodies of the block's steps are there.
template <class Number>
[[gnu::always_inline]] inline bool isWhole(const LinearArrays& arrays, int first) {
  const int last = first + stepsPerBlock<Number> - 1;
  return last < arrays.steps && isFull(arrays, last);
}

/// A number of each body of the block's steps: that of step `first` to `to`, the others `stride` apart.
template <class Number>
[[gnu::always_inline]] inline void gatherBlock(const LinearArrays& arrays, const double* values, int first,
                                               double* to, int stride) {
  constexpr int width = parts<Number>;
  if (isWhole<Number>(arrays, first)) {
    Real rows[laneCount];
    for (int s = 0; s < laneCount; ++s) {
      rows[s] = Real::load(values + (first + s * static_cast<std::ptrdiff_t>(arrays.steps)) * width);
    }
    transpose(rows);
    for (int i = 0; i < laneCount; ++i) rows[i].store(to + i / width * stride + i % width * laneCount);
    return;
  }
  const int end = std::min(first + stepsPerBlock<Number>, arrays.steps);
  for (int i = first; i < end; ++i) store(gathered<Number>(arrays, values, i), to + (i - first) * stride);
}

/// The other way, from numbers one after the other, to the bodies that there are.
template <class Number>
[[gnu::always_inline]] inline void scatterBlock(const LinearArrays& arrays, const double* from, int first,
                                                double* values) {
  constexpr int width = parts<Number>;
  if (isWhole<Number>(arrays, first)) {
    Real rows[laneCount];
    for (int i = 0; i < laneCount; ++i) rows[i] = Real::load(from + i * laneCount);
    transpose(rows);
    for (int s = 0; s < laneCount; ++s) {
      rows[s].store(values + (first + s * static_cast<std::ptrdiff_t>(arrays.steps)) * width);
    }
    return;
  }
  const int end = std::min(first + stepsPerBlock<Number>, arrays.steps);
  for (int i = first; i < end; ++i) {
    Number a = loaded<Number>(from + (i - first) * width * laneCount);
    for (int k = 0; k < width; ++k) write<width>(arrays, part(a, k), values + k, i);
  }
}

}  // namespace
}  // namespace planar_chain::simd
