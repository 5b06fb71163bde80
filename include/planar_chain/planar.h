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

  constexpr Vec2& operator+=(Vec2 b) {
    x += b.x;
    y += b.y;
    return *this;
  }
  constexpr Vec2& operator-=(Vec2 b) {
    x -= b.x;
    y -= b.y;
    return *this;
  }
};

using Vec2d = Vec2<double>;

template <class Real>
constexpr Vec2<Real> operator+(Vec2<Real> a, Vec2<Real> b) {
  return {a.x + b.x, a.y + b.y};
}

template <class Real>
constexpr Vec2<Real> operator-(Vec2<Real> a, Vec2<Real> b) {
  return {a.x - b.x, a.y - b.y};
}

template <class Real>
constexpr Vec2<Real> operator*(Real k, Vec2<Real> a) {
  return {k * a.x, k * a.y};
}

template <class Real>
constexpr bool operator==(Vec2<Real> a, Vec2<Real> b) {
  return a.x == b.x && a.y == b.y;
}

/// a·b
template <class Real>
constexpr Real dot(Vec2<Real> a, Vec2<Real> b) {
  return mulAdd(a.x, b.x, a.y * b.y);
}

/// k a + b
template <class Factor, class A, class B>
constexpr Vec2<B> mulAdd(Factor k, Vec2<A> a, Vec2<B> b) {
  return {mulAdd(k, a.x, b.x), mulAdd(k, a.y, b.y)};
}

/// a×b, along k̂
template <class Real>
constexpr Real cross(Vec2<Real> a, Vec2<Real> b) {
  return mulAdd(a.x, b.y, -a.y * b.x);
}

/// i·a = k̂ × a
template <class Real>
constexpr Vec2<Real> perp(Vec2<Real> a) {
  return {-a.y, a.x};
}

template <class Real>
bool isFinite(Vec2<Real> a) {
  return std::isfinite(a.x) && std::isfinite(a.y);
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
};

template <class Real>
constexpr Vec2<Real> operator*(Rotation<Real> e, Vec2<Real> a) {
  return {mulAdd(e.c, a.x, -e.s * a.y), mulAdd(e.s, a.x, e.c * a.y)};
}

/// A symmetric 2×2 tensor, such as the articulated mass.
template <class Real>
struct Sym2 {
  Real xx{};
  Real xy{};
  Real yy{};
};

template <class Real>
constexpr Vec2<Real> operator*(Sym2<Real> A, Vec2<Real> a) {
  return {mulAdd(A.xx, a.x, A.xy * a.y), mulAdd(A.xy, a.x, A.yy * a.y)};
}

}  // namespace planar_chain
