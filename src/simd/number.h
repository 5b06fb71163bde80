#pragma once

/// A double whose functions are compiled for the CPU of the including file alone; see lanes.h.

#include "planar_chain/planar.h"

namespace planar_chain::simd {
namespace {

struct Number {
  double v = 0;

  Number() = default;
  explicit Number(double x) : v(x) {}

  friend Number operator+(Number a, Number b) { return Number(a.v + b.v); }
  friend Number operator-(Number a, Number b) { return Number(a.v - b.v); }
  friend Number operator*(Number a, Number b) { return Number(a.v * b.v); }
  friend Number operator/(Number a, Number b) { return Number(a.v / b.v); }
  friend Number operator-(Number a) { return Number(-a.v); }
  Number& operator+=(Number b) { return *this = *this + b; }
  Number& operator-=(Number b) { return *this = *this - b; }
};

using planar_chain::mulAdd;
#ifdef __FMA__
Number mulAdd(Number a, Number b, Number c) {
  return Number(__builtin_fma(a.v, b.v, c.v));
}
#endif

Vec2<Number> vectorOf(const Vec2d& a) {
  return {Number(a.x), Number(a.y)};
}

}  // namespace
}  // namespace planar_chain::simd
