#pragma once

/// The kernel for `laneCount` lanes, as the including file's compiler options make it. See segments.h for the
/// equations.

#include <cmath>
#include <cstddef>

#include "kernel.h"
#include "lanes.h"
#include "planar_chain/articulated.h"

namespace planar_chain::simd {
namespace {

using Real = Lanes;
using Vector = Vec2<Real>;
using Integers = long long __attribute__((vector_size(8 * laneCount)));

// ---- Sines and cosines -----------------------------------------------------------------------

/// exp(i θ) by the machine's library.
void rotate(const double* theta, double* e, int n) {
  for (int j = 0; j < n; ++j) {
    e[2 * j] = std::cos(theta[j]);
    e[2 * j + 1] = std::sin(theta[j]);
  }
}

#ifdef __FMA__

Real fused(Real a, Real b, Real c) {
#if defined(__AVX512F__)
  return Real(_mm512_fmadd_pd(a.v, b.v, c.v));
#else
  return Real(_mm256_fmadd_pd(a.v, b.v, c.v));
#endif
}

/// θ = k π/2 + r, |r| ≤ π/4, with π/2 in three parts (W. Cody, W. Waite, Software Manual for the Elementary
/// Functions, 1980): with fused multiplication the first difference is exact and the third part is below what
/// r can hold. Then sin r and cos r by the polynomials of Sun's fdlibm (k_sin.c, k_cos.c).
void rotationsOf(Real theta, double* e) {
  // Adding 1.5·2⁵² rounds to an integer, whose last bits are then k's.
  const Real shift(6755399441055744.0);
  const Real shifted = fused(theta, Real(6.36619772367581382433e-01), shift);
  const Real k = shifted - shift;
  Real r = fused(k, Real(-1.57079632679489655800e+00), theta);
  r = fused(k, Real(-6.12323399573676603587e-17), r);
  r = fused(k, Real(1.49738490485916983294e-33), r);

  const Real z = r * r;
  Real p = fused(z, Real(1.58969099521155010221e-10), Real(-2.50507602534068634195e-08));
  p = fused(z, p, Real(2.75573137070700676789e-06));
  p = fused(z, p, Real(-1.98412698298579493134e-04));
  p = fused(z, p, Real(8.33333333332248946124e-03));
  p = fused(z, p, Real(-1.66666666666666324348e-01));
  const Real sine = fused(z * r, p, r);

  Real q = fused(z, Real(-1.13596475577881948265e-11), Real(2.08757232129817482790e-09));
  q = fused(z, q, Real(-2.75573143513906633035e-07));
  q = fused(z, q, Real(2.48015872894767294178e-05));
  q = fused(z, q, Real(-1.38888888888741095749e-03));
  q = fused(z, q, Real(4.16666666666666019037e-02));
  const Real half = Real(0.5) * z;
  const Real w = Real(1) - half;
  const Real cosine = w + fused(z * z, q, (Real(1) - w) - half);

  // Quadrant k mod 4: odd ones exchange sine and cosine; the signs follow.
  Integers bits;
  std::memcpy(&bits, &shifted.v, sizeof bits);
  const Integers odd = (bits & 1) != 0;
  const Integers sineSign = (bits & 2) << 62;
  const Integers cosineSign = ((bits + 1) & 2) << 62;
  Integers sines, cosines;
  const auto s = odd ? cosine.v : sine.v;
  const auto c = odd ? sine.v : cosine.v;
  std::memcpy(&sines, &s, sizeof s);
  std::memcpy(&cosines, &c, sizeof c);
  sines ^= sineSign;
  cosines ^= cosineSign;
  double pairs[2][laneCount];
  std::memcpy(pairs[0], &cosines, sizeof cosines);
  std::memcpy(pairs[1], &sines, sizeof sines);
  for (int l = 0; l < laneCount; ++l) {
    e[2 * l] = pairs[0][l];
    e[2 * l + 1] = pairs[1][l];
  }
}

/// Up to here k π/2 is exact enough; beyond, and for what is not finite, the library is asked.
bool isReducible(Real theta) {
  constexpr double largest = 1e9;
  const Integers inside = (theta.v < Real(largest).v) & (theta.v > Real(-largest).v);
  bool all = true;
  for (int l = 0; l < laneCount; ++l) all = all && inside[l];
  return all;
}

void rotations(const double* theta, double* e, int n) {
  if (n < laneCount) return rotate(theta, e, n);
  const auto block = [=](int j) {
    const Real angles = Real::load(theta + j);
    if (isReducible(angles)) {
      rotationsOf(angles, e + 2 * j);
    } else {
      rotate(theta + j, e + 2 * j, laneCount);
    }
  };
  for (int j = 0; j + laneCount <= n; j += laneCount) block(j);
  if (n % laneCount != 0) block(n - laneCount);  // some of them for a second time
}

#else

void rotations(const double* theta, double* e, int n) {
  rotate(theta, e, n);
}

#endif

// ---- Segments --------------------------------------------------------------------------------

/// Lane s of quantity q at step i.
const double* at(const double* array, int quantities, int i, int q) {
  return array + (static_cast<std::ptrdiff_t>(i) * quantities + q) * laneCount;
}

constexpr int linkQuantities = 6;
constexpr int handleQuantities = 9;

/// Quantities of the bodies of one step, lane by lane; those beyond the chain's end read as `beyond`.
[[gnu::always_inline]] inline Real read(const SegmentArrays& arrays, const double* values, int width,
                                        int offset, int i, double beyond) {
  const std::ptrdiff_t stride = static_cast<std::ptrdiff_t>(arrays.steps);
  if (i + stride * (laneCount - 1) < arrays.bodies) {
    return Real::gather(values + i * width + offset, stride * width);
  }
  Real a(beyond);
  for (int s = 0; s < laneCount; ++s) {
    const std::ptrdiff_t j = i + s * stride;
    if (j < arrays.bodies) a.v[s] = values[j * width + offset];
  }
  return a;
}

/// Numbers this small are zero: G shrinks exponentially along a segment, and denormal numbers are slow.
/// Looked at every few steps, so smaller ones than that do occur, but not as small as denormal ones.
constexpr int stepsPerFlush = 8;
Real flushed(Real a) {
  const Integers large = (a.v > Real(1e-140).v) | (a.v < Real(-1e-140).v);
  Integers bits;
  std::memcpy(&bits, &a.v, sizeof bits);
  bits &= large;
  std::memcpy(&a.v, &bits, sizeof bits);
  return a;
}

/// P/|P|; where P = 0, the first axis.
Vector unit(Vector P) {
  Vector d{Real(1), Real(0)};
  for (int s = 0; s < laneCount; ++s) {
    const double length = std::sqrt(P.x.v[s] * P.x.v[s] + P.y.v[s] * P.y.v[s]);
    if (length > 0) d.x.v[s] = P.x.v[s] / length, d.y.v[s] = P.y.v[s] / length;
  }
  return d;
}

/// The directions of the outermost links.
Vector outerFrames(const SegmentArrays& arrays, const double* e) {
  const int i = arrays.steps - 1;
  const double* link = at(arrays.links, linkQuantities, i, 0);
  const Rotation<Real> turn{read(arrays, e, 2, 0, i, 1), read(arrays, e, 2, 1, i, 0)};
  return unit(turn * Vector{Real::load(link + 4 * laneCount), Real::load(link + 5 * laneCount)});
}

template <bool hasForces>
void runInwards(const SegmentArrays& arrays, const double* e, const double* omega, const double* N,
                const double* F, SegmentHandles& handles) {
  Sym2<Real> A, C;
  Vector b, c;
  const Vector d = outerFrames(arrays, e);
  Vector Gx{d.x, -d.y}, Gy{d.y, d.x};  // rows of G
  for (int i = arrays.steps - 1; i >= 0; --i) {
    const double* link = at(arrays.links, linkQuantities, i, 0);
    const auto own = [link](int q) { return Real::load(link + q * laneCount); };
    const Body<Real> body{own(0), own(1), {own(2), own(3)}, {own(4), own(5)}};
    const Rotation<Real> turn{read(arrays, e, 2, 0, i, 1), read(arrays, e, 2, 1, i, 0)};
    const Real rate = read(arrays, omega, 1, 0, i, 0);
    const Real ww = rate * rate;
    const Vector R = turn * body.r;
    const Vector P = turn * body.p;

    const Handle<Real> handle = inwards(body, R, P, ww, read(arrays, N, 1, 0, i, 0), A, b);
    if constexpr (hasForces) b -= Vector{read(arrays, F, 2, 0, i, 0), read(arrays, F, 2, 1, i, 0)};

    const Vector g = P.x * Gy - P.y * Gx;   // Gᵀ iP
    const Vector GP = P.x * Gx + P.y * Gy;  // Gᵀ P
    const Vector gD = handle.inverseD * g;
    C = {C.xx + g.x * gD.x, C.xy + g.x * gD.y, C.yy + g.y * gD.y};
    c += handle.u * gD - ww * GP;
    Gx -= handle.U.x * gD;
    Gy -= handle.U.y * gD;
    if (i % stepsPerFlush == 0) {
      Gx = {flushed(Gx.x), flushed(Gx.y)};
      Gy = {flushed(Gy.x), flushed(Gy.y)};
    }

    double* to = arrays.handles + static_cast<std::ptrdiff_t>(i) * handleQuantities * laneCount;
    int q = 0;
    for (const Real value : {handle.U.x, handle.U.y, handle.u, handle.inverseD, g.x, g.y, P.x, P.y, ww}) {
      value.store(to + laneCount * q++);
    }
  }
  d.x.store(handles.d[0]), d.y.store(handles.d[1]);
  A.xx.store(handles.A[0]), A.xy.store(handles.A[1]), A.yy.store(handles.A[2]);
  C.xx.store(handles.C[0]), C.xy.store(handles.C[1]), C.yy.store(handles.C[2]);
  b.x.store(handles.b[0]), b.y.store(handles.b[1]);
  c.x.store(handles.c[0]), c.y.store(handles.c[1]);
  Gx.x.store(handles.G[0]), Gx.y.store(handles.G[1]), Gy.x.store(handles.G[2]), Gy.y.store(handles.G[3]);
}

void inwardsAll(const SegmentArrays& arrays, const double* e, const double* omega, const double* N,
                const double* F, SegmentHandles& handles) {
  if (F) {
    runInwards<true>(arrays, e, omega, N, F, handles);
  } else {
    runInwards<false>(arrays, e, omega, N, F, handles);
  }
}

void outwardsAll(const SegmentArrays& arrays, const double (*from)[SegmentHandles::most],
                 const double (*f)[SegmentHandles::most], double* alpha) {
  Vector a{Real::load(from[0]), Real::load(from[1])};
  const Vector force{Real::load(f[0]), Real::load(f[1])};
  const std::ptrdiff_t stride = arrays.steps;
  for (int i = 0; i < arrays.steps; ++i) {
    const double* handle = at(arrays.handles, handleQuantities, i, 0);
    const auto own = [handle](int q) { return Real::load(handle + q * laneCount); };
    const Vector U{own(0), own(1)}, g{own(4), own(5)}, P{own(6), own(7)};
    const Real result = (own(2) - dot(g, force) - dot(U, a)) * own(3);
    a += result * perp(P) - own(8) * P;
    if (i + stride * (laneCount - 1) < arrays.bodies) {
      result.scatter(alpha + i, stride);
    } else {
      for (int s = 0; s < laneCount; ++s) {
        if (i + s * stride < arrays.bodies) alpha[i + s * stride] = result.v[s];
      }
    }
  }
}

}  // namespace
}  // namespace planar_chain::simd
