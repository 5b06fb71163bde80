#pragma once

/// A number in each lane of a SIMD register. In an unnamed namespace on purpose: each file that includes this
/// is compiled for another CPU, and none may share a function with another. It must define laneCount before.

#include <cstddef>
#include <cstring>

namespace planar_chain::simd {
namespace {

struct Lanes {
  typedef double Register __attribute__((vector_size(8 * laneCount)));
  Register v;

  Lanes() : v{} {}
  Lanes(Register v_) : v(v_) {}
  explicit Lanes(double x) : v(Register{} + x) {}

  static Lanes load(const double* from) {
    Lanes a;
    std::memcpy(&a.v, from, sizeof a.v);
    return a;
  }
  void store(double* to) const { std::memcpy(to, &v, sizeof v); }
  /// Lane s from from[s·stride].
  static Lanes gather(const double* from, std::ptrdiff_t stride) {
    Lanes a;
    for (int s = 0; s < laneCount; ++s) a.v[s] = from[s * stride];
    return a;
  }
  void scatter(double* to, std::ptrdiff_t stride) const {
    for (int s = 0; s < laneCount; ++s) to[s * stride] = v[s];
  }

  friend Lanes operator+(Lanes a, Lanes b) { return a.v + b.v; }
  friend Lanes operator-(Lanes a, Lanes b) { return a.v - b.v; }
  friend Lanes operator*(Lanes a, Lanes b) { return a.v * b.v; }
  friend Lanes operator/(Lanes a, Lanes b) { return a.v / b.v; }
  friend Lanes operator-(Lanes a) { return -a.v; }
  Lanes& operator+=(Lanes b) { return *this = *this + b; }
  Lanes& operator-=(Lanes b) { return *this = *this - b; }
};

}  // namespace
}  // namespace planar_chain::simd
