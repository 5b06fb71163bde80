#pragma once

/// The plane: vectors, rotations and symmetric tensors of two dimensions.
///
/// A vector of the plane is a complex number z = x + i y. i·z turns it by +90°. a·b is the dot product and
/// a×b = (i a)·b the component of the cross product along k̂. Everything is a plain value, allocates nothing
/// and throws nothing. Real is double in the program. Any field with +, −, × works; tests use long double.

#include <cmath>

namespace planar_chain {

constexpr double pi = 3.14159265358979323846;

/// a b + c. Number types with a fused multiply-add, which rounds once, overload it.
template <class A, class B, class C>
constexpr C mulAdd(A a, B b, C c) {
  return a * b + c;
}

template <class Real>
struct Vec2 {
  Real x{};
  Real y{};

  constexpr Vec2& operator+=(Vec2 b) { return *this = *this + b; }
  constexpr Vec2& operator-=(Vec2 b) { return *this = *this - b; }
  friend constexpr Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
  friend constexpr Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
  friend constexpr Vec2 operator*(Real k, Vec2 a) { return {k * a.x, k * a.y}; }
  friend constexpr bool operator==(Vec2 a, Vec2 b) { return a.x == b.x && a.y == b.y; }
  /// a·b
  friend constexpr Real dot(Vec2 a, Vec2 b) { return mulAdd(a.x, b.x, a.y * b.y); }
  /// a×b, along k̂
  friend constexpr Real cross(Vec2 a, Vec2 b) { return mulAdd(a.x, b.y, -a.y * b.x); }
  /// i·a = k̂ × a
  friend constexpr Vec2 perp(Vec2 a) { return {-a.y, a.x}; }
  friend bool isFinite(Vec2 a) { return std::isfinite(a.x) && std::isfinite(a.y); }
};

using Vec2d = Vec2<double>;

/// k a + b
template <class Factor, class A, class B>
constexpr Vec2<B> mulAdd(Factor k, Vec2<A> a, Vec2<B> b) {
  return {mulAdd(k, a.x, b.x), mulAdd(k, a.y, b.y)};
}

inline double length(Vec2<double> a) {
  return std::hypot(a.x, a.y);
}

/// e = exp(i θ). It turns body components into ground components.
template <class Real>
struct Rotation {
  Real c{1};
  Real s{0};

  static Rotation of(Real theta) {
    using std::cos;
    using std::sin;
    return {cos(theta), sin(theta)};
  }
  friend constexpr Vec2<Real> operator*(Rotation e, Vec2<Real> a) {
    return {mulAdd(e.c, a.x, -e.s * a.y), mulAdd(e.s, a.x, e.c * a.y)};
  }
  friend constexpr Rotation operator*(Rotation e, Rotation turn) {
    return {e.c * turn.c - e.s * turn.s, e.s * turn.c + e.c * turn.s};
  }
};

/// A symmetric 2×2 tensor, such as the articulated mass.
template <class Real>
struct Sym2 {
  Real xx{};
  Real xy{};
  Real yy{};

  friend constexpr Vec2<Real> operator*(Sym2 A, Vec2<Real> a) {
    return {mulAdd(A.xx, a.x, A.xy * a.y), mulAdd(A.xy, a.x, A.yy * a.y)};
  }
};

}  // namespace planar_chain
