#pragma once

/// Numbers that carry a derivative: a + b ε with ε² = 0. Any rational program that runs on them computes,
/// beside its value, the derivative along one direction, exact to rounding:
///
///     (a + a' ε)(b + b' ε) = a b + (a b' + a' b) ε
///     (a + a' ε)/(b + b' ε) = q + (a' − q b')/b ε          q = a/b

#include <cmath>

#include "planar_chain/planar.h"

namespace planar_chain {

struct Dual {
  double value = 0, slope = 0;

  Dual(double a = 0, double b = 0) : value(a), slope(b) {}
  Dual& operator+=(Dual b) { return *this = {value + b.value, slope + b.slope}; }
  Dual& operator-=(Dual b) { return *this = {value - b.value, slope - b.slope}; }
};

inline Dual operator+(Dual a, Dual b) {
  return {a.value + b.value, a.slope + b.slope};
}
inline Dual operator-(Dual a, Dual b) {
  return {a.value - b.value, a.slope - b.slope};
}
inline Dual operator-(Dual a) {
  return {-a.value, -a.slope};
}
inline Dual operator*(Dual a, Dual b) {
  return {a.value * b.value, a.value * b.slope + a.slope * b.value};
}
inline Dual operator/(Dual a, Dual b) {
  const double q = a.value / b.value;
  return {q, (a.slope - q * b.slope) / b.value};
}

inline bool operator<(Dual a, Dual b) {
  return a.value < b.value;
}
inline bool operator>(Dual a, Dual b) {
  return b < a;
}
inline bool operator>=(Dual a, Dual b) {
  return !(a < b);
}
inline Dual sqrt(Dual a) {
  const double root = std::sqrt(a.value);
  return {root, a.slope / (2 * root)};
}
inline Dual hypot(Dual a, Dual b) {
  return sqrt(a * a + b * b);
}

/// e = exp(i θ), while θ changes by `turn`.
inline Rotation<Dual> turning(Rotation<double> e, double turn) {
  return {{e.c, -e.s * turn}, {e.s, e.c * turn}};
}

}  // namespace planar_chain
