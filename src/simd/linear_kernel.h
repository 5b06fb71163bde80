#pragma once

/// The exact solve of linearized.h in segments, for `laneCount` lanes. See linearized_segments.h for the
/// equations.

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
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
  }
  friend ComplexLanes operator*(Real a, ComplexLanes b) { return {a * b.re, a * b.im}; }
  friend ComplexLanes operator*(ComplexLanes b, Real a) { return a * b; }
  friend ComplexLanes operator/(Real a, ComplexLanes b) {
    const Real scale = a / (b.re * b.re + b.im * b.im);
    return {scale * b.re, -(scale * b.im)};
  }
  ComplexLanes& operator+=(ComplexLanes b) { return *this = *this + b; }
  ComplexLanes& operator-=(ComplexLanes b) { return *this = *this - b; }
};

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

/// Writes or reads one quantity after the other.
template <class Number>
struct Writer {
  double* to;
  void operator()(Number a) {
    store(a, to);
    to += parts<Number> * laneCount;
  }
  void operator()(Vec2<Number> a) { (*this)(a.x), (*this)(a.y); }
};

template <class Number>
struct Reader {
  const double* from;
  Number number() {
    const Number a = loaded<Number>(from);
    from += parts<Number> * laneCount;
    return a;
  }
  Vec2<Number> vector() {
    const Number x = number();
    return {x, number()};
  }
};

/// Into rows of `most`.
template <class Number>
struct RowWriter {
  Rows to;
  void operator()(Number a) {
    for (int k = 0; k < parts<Number>; ++k) part(a, k).store(*to++);
  }
  void operator()(Vec2<Number> a) { (*this)(a.x), (*this)(a.y); }
};

template <class Number>
[[gnu::always_inline]] inline Number fromRows(ConstRows& from) {
  Number a;
  for (int k = 0; k < parts<Number>; ++k) part(a, k) = Real::load(*from++);
  return a;
}

// ---- Arrays of the caller --------------------------------------------------------------------

/// Bodies i + s·steps + shift of an array of numbers, 0 where there is none.
template <class Number>
[[gnu::always_inline]] inline Number gathered(const LinearArrays& arrays, const double* values, int i,
                                              int shift = 0) {
  constexpr int width = parts<Number>;
  Number a;
  const std::ptrdiff_t stride = arrays.steps;
  const std::ptrdiff_t first = i + shift;
  const bool inside = first >= 0 && first + stride * (laneCount - 1) < arrays.bodies;
  for (int k = 0; k < width; ++k) {
    if (inside) {
      part(a, k) = Real::gather(values + first * width + k, stride * width);
      continue;
    }
    for (int s = 0; s < laneCount; ++s) {
      const std::ptrdiff_t j = first + s * stride;
      if (j >= 0 && j < arrays.bodies) part(a, k).v[s] = values[j * width + k];
    }
  }
  return a;
}

template <class Number>
[[gnu::always_inline]] inline void scattered(const LinearArrays& arrays, Number a, int i, double* values) {
  constexpr int width = parts<Number>;
  const std::ptrdiff_t stride = arrays.steps;
  for (int k = 0; k < width; ++k) {
    for (int s = 0; s < laneCount; ++s) {
      const std::ptrdiff_t j = i + s * stride;
      if (j < arrays.bodies) values[j * width + k] = part(a, k).v[s];
    }
  }
}

Vector gatheredVector(const LinearArrays& arrays, const double* pairs, int i) {
  const ComplexLanes pair = gathered<ComplexLanes>(arrays, pairs, i);
  return {pair.re, pair.im};
}

// ---- The state -------------------------------------------------------------------------------

double* stateAt(const LinearArrays& arrays, int i) {
  return arrays.state + static_cast<std::ptrdiff_t>(i) * LinearArrays::stateQuantities * laneCount;
}

[[gnu::always_inline]] inline BodyAt<Real> bodyAt(const LinearArrays& arrays, int i) {
  Reader<Real> read{stateAt(arrays, i)};
  BodyAt<Real> body;
  for (Real* quantity : {&body.m, &body.J, &body.omega, &body.alpha, &body.kappa, &body.k, &body.d}) {
    *quantity = read.number();
  }
  body.R = read.vector();
  body.P = read.vector();
  return body;
}

constexpr int kappaPlace = 4;

/// m (a + iα R − ω² R)
Vector inertialForce(const BodyAt<Real>& body, Vector a) {
  return body.m * (a + body.alpha * perp(body.R) - (body.omega * body.omega) * body.R);
}

void linearizeOutwardsAll(const LinearArrays& arrays, const LinearState& at, Rows sums) {
  Vector a, force, P;
  Real mass;
  for (int i = 0; i < arrays.steps; ++i) {
    Reader<Real> link{simd::at(arrays.links, linkQuantities, i, 0)};
    BodyAt<Real> body;
    body.m = link.number();
    const Real inertia = link.number();
    const Vector turned = gatheredVector(arrays, at.e, i);
    const Rotation<Real> turn{turned.x, turned.y};
    body.R = turn * link.vector();
    body.P = turn * link.vector();
    body.J = inertia + body.m * dot(body.R, body.R);
    body.omega = gathered<Real>(arrays, at.omega, i);
    body.alpha = gathered<Real>(arrays, at.alpha, i);

    Writer<Real> write{stateAt(arrays, i)};
    for (const Real quantity : {body.m, body.J, body.omega, body.alpha, Real(),
                                gathered<Real>(arrays, at.k, i), gathered<Real>(arrays, at.d, i)}) {
      write(quantity);
    }
    write(body.R);
    write(body.P);

    mass += body.m;
    force += inertialForce(body, a);
    if (at.F) force -= gatheredVector(arrays, at.F, i);
    a += body.alpha * perp(body.P) - (body.omega * body.omega) * body.P;
    P = body.P;
  }
  RowWriter<Real> write{sums};
  write(a), write(force), write(mass), write(unit(P));
}

/// κ, from the tip of each segment; a is what it was on the way out, taken back link by link.
void linearizeInwardsAll(const LinearArrays& arrays, const LinearState& at, ConstRows starts) {
  Vector a{Real::load(starts[0]), Real::load(starts[1])};
  Vector outer{Real::load(starts[2]), Real::load(starts[3])};
  // Outwards: a of each inner pin, kept where κ will be and in the sweeps.
  for (int i = 0; i < arrays.steps; ++i) {
    const BodyAt<Real> body = bodyAt(arrays, i);
    Writer<Real> write{arrays.sweeps +
                       static_cast<std::ptrdiff_t>(i) * LinearArrays::sweepQuantities * laneCount};
    write(a);
    a += body.alpha * perp(body.P) - (body.omega * body.omega) * body.P;
  }
  for (int i = arrays.steps - 1; i >= 0; --i) {
    const BodyAt<Real> body = bodyAt(arrays, i);
    const Vector inner = Reader<Real>{arrays.sweeps + static_cast<std::ptrdiff_t>(i) *
                                                          LinearArrays::sweepQuantities * laneCount}
                             .vector();
    Real kappa = -(body.m * dot(body.R, inner)) - dot(body.P, outer);
    if (at.XF) kappa += gathered<Real>(arrays, at.XF, i);
    kappa.store(stateAt(arrays, i) + kappaPlace * laneCount);
    outer += inertialForce(body, inner);
    if (at.F) outer -= gatheredVector(arrays, at.F, i);
  }
}

// ---- The solve -------------------------------------------------------------------------------

/// Rows of 3.
template <class Number>
struct Triple {
  Number x, y, z;
  friend Triple operator*(Number k, const Triple& a) { return {k * a.x, k * a.y, k * a.z}; }
  Triple& operator+=(const Triple& a) {
    x += a.x, y += a.y, z += a.z;
    return *this;
  }
  Triple& operator-=(const Triple& a) {
    x -= a.x, y -= a.y, z -= a.z;
    return *this;
  }
};

template <class Number>
double* handleAt(const LinearArrays& arrays, int i) {
  return arrays.handles +
         static_cast<std::ptrdiff_t>(i) * LinearArrays::handleQuantities * parts<Number> * laneCount;
}

template <class Number>
double* sweepAt(const LinearArrays& arrays, int i) {
  return arrays.sweeps +
         static_cast<std::ptrdiff_t>(i) * LinearArrays::sweepQuantities * parts<Number> * laneCount;
}

template <class Number>
void flush(Triple<Number>& a) {
  for (Number* number : {&a.x, &a.y, &a.z}) {
    for (int k = 0; k < parts<Number>; ++k) part(*number, k) = flushed(part(*number, k));
  }
}

template <class Number>
void factorAll(const LinearArrays& arrays, const double* s_, Rows to) {
  const Number s = everywhere<Number>(s_);
  const Number one = Real(1), zero = Real();
  const Vector d = unit(bodyAt(arrays, arrays.steps - 1).P);
  Shown<Number> shown;
  // Rows of G; columns of H; rows of C.
  Triple<Number> Gx{d.x, -d.y, zero}, Gy{d.y, d.x, zero}, Gz{zero, zero, one};
  Triple<Number> Hx{d.x, -d.y, zero}, Hy{d.y, d.x, zero}, Hz{zero, zero, one};
  Triple<Number> Cx, Cy, Cz;
  for (int i = arrays.steps - 1; i >= 0; --i) {
    const BodyAt<Real> body = bodyAt(arrays, i);
    const LinearHandle<Number> handle = eliminate(body, s, shown);

    Triple<Number> t{body.P.y * Gx.x - body.P.x * Gy.x - Gz.x, body.P.y * Gx.y - body.P.x * Gy.y - Gz.y,
                     body.P.y * Gx.z - body.P.x * Gy.z - Gz.z};
    Triple<Number> eta = Hz;
    eta += handle.zP.x * Hx;
    eta += handle.zP.y * Hy;

    Writer<Number> write{handleAt<Number>(arrays, i)};
    for (const Number& value : {handle.B.xx, handle.B.xy, handle.B.yx, handle.B.yy}) write(value);
    for (const Vec2<Number>& value : {handle.p, handle.zP, handle.UR, handle.UL}) write(value);
    write(handle.inverseD), write(handle.k);
    for (const Triple<Number>& value : {Hx, Hy, eta, t}) write(value.x), write(value.y), write(value.z);

    const Triple<Number> tD = handle.inverseD * t;
    Cx -= eta.x * tD;
    Cy -= eta.y * tD;
    Cz -= eta.z * tD;
    Gx += handle.UR.x * tD;
    Gy += handle.UR.y * tD;
    Gz = -handle.k * tD;
    const Triple<Number> etaD = handle.inverseD * eta;
    Hx -= handle.UL.x * etaD;
    Hy -= handle.UL.y * etaD;
    Hz = handle.k * etaD;
    if (i % stepsPerFlush == 0) {
      for (Triple<Number>* value : {&Gx, &Gy, &Gz, &Hx, &Hy, &Hz}) flush(*value);
    }
  }
  RowWriter<Number> write{to};
  write(shown.B.xx), write(shown.B.xy), write(shown.h.x);
  write(shown.B.yx), write(shown.B.yy), write(shown.h.y);
  write(shown.p), write(shown.q);
  write(Hx.x), write(Hy.x), write(Hz.x), write(Hx.y), write(Hy.y), write(Hz.y), write(Hx.z), write(Hy.z),
      write(Hz.z);
  for (const Triple<Number>& row : {Gx, Gy, Gz, Cx, Cy, Cz}) write(row.x), write(row.y), write(row.z);
}

template <class Number>
[[gnu::always_inline]] inline LinearHandle<Number> handleFrom(Reader<Number>& read) {
  LinearHandle<Number> handle;
  for (Number* value : {&handle.B.xx, &handle.B.xy, &handle.B.yx, &handle.B.yy}) *value = read.number();
  for (Vec2<Number>* value : {&handle.p, &handle.zP, &handle.UR, &handle.UL}) *value = read.vector();
  handle.inverseD = read.number();
  handle.k = read.number();
  return handle;
}

template <class Number>
[[gnu::always_inline]] inline Triple<Number> tripleFrom(Reader<Number>& read) {
  Triple<Number> a;
  for (Number* value : {&a.x, &a.y, &a.z}) *value = read.number();
  return a;
}

template <class Number>
void solveInwardsAll(const LinearArrays& arrays, const double* s, const double* rhoQ, const double* rhoV,
                     Rows to) {
  const Number inverseS = Real(1) / everywhere<Number>(s);
  Vec2<Number> b;
  Number r = Real();
  Triple<Number> c;
  Number rho = gathered<Number>(arrays, rhoQ, arrays.steps - 1);
  for (int i = arrays.steps - 1; i >= 0; --i) {
    const Number rhoInner = gathered<Number>(arrays, rhoQ, i, -1);
    Reader<Number> read{handleAt<Number>(arrays, i)};
    const LinearHandle<Number> handle = handleFrom(read);
    const Triple<Number> Hx = tripleFrom(read), Hy = tripleFrom(read), eta = tripleFrom(read);
    const Sweep<Number> sweep = carry(bodyAt(arrays, i), handle, inverseS * rho, inverseS * (rho - rhoInner),
                                      gathered<Number>(arrays, rhoV, i), b, r);
    c += sweep.wP.x * Hx;
    c += sweep.wP.y * Hy;
    c += (sweep.epsilon * handle.inverseD) * eta;

    Writer<Number> write{sweepAt<Number>(arrays, i)};
    write(sweep.wP), write(sweep.epsilon);
    rho = rhoInner;
  }
  RowWriter<Number> write{to};
  write(b), write(r), write(c.x), write(c.y), write(c.z);
}

template <class Number>
void solveOutwardsAll(const LinearArrays& arrays, const double* s_, const double* rhoQ, ConstRows ends,
                      double* u, double* v) {
  const Number s = everywhere<Number>(s_);
  const Number inverseS = Real(1) / s;
  Vec2<Number> da;
  da.x = fromRows<Number>(ends);
  da.y = fromRows<Number>(ends);
  Number parent = fromRows<Number>(ends);
  Triple<Number> Y;
  for (Number* value : {&Y.x, &Y.y, &Y.z}) *value = fromRows<Number>(ends);
  for (int i = 0; i < arrays.steps; ++i) {
    Reader<Number> read{handleAt<Number>(arrays, i)};
    const LinearHandle<Number> handle = handleFrom(read);
    read.from += 9 * parts<Number> * laneCount;
    const Triple<Number> t = tripleFrom(read);
    Reader<Number> sweep{sweepAt<Number>(arrays, i)};
    const Vec2<Number> wP = sweep.vector();
    const Number epsilon = sweep.number() + t.x * Y.x + t.y * Y.y + t.z * Y.z;
    parent = (handle.k * parent + epsilon - dot(handle.UL, da)) * handle.inverseD;
    da += parent * handle.zP + wP;
    const Number sigma = inverseS * gathered<Number>(arrays, rhoQ, i);
    scattered(arrays, sigma + parent, i, u);
    scattered(arrays, s * parent, i, v);
  }
}

template <class Number>
constexpr LinearKernel linearKernel{factorAll<Number>, solveInwardsAll<Number>, solveOutwardsAll<Number>};

}  // namespace
}  // namespace planar_chain::simd
