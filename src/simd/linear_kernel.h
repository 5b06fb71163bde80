#pragma once

/// The exact solve of linearized.h in segments, for `laneCount` lanes. See linearized_segments.h for the
/// equations.

#include "lane_streams.h"

namespace planar_chain::simd {
namespace {

// ---- The state -------------------------------------------------------------------------------

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

double* stateAt(const LinearArrays& arrays, int i) {
  return arrays.state + static_cast<std::ptrdiff_t>(i) * LinearArrays::stateQuantities * laneCount;
}

[[gnu::always_inline]] inline BodyAt<Real> bodyAt(const LinearArrays& arrays, int i) {
  Reader<Real> read(stateAt(arrays, i));
  BodyAt<Real> body;
  read(body.m, body.J, body.omega, body.alpha, body.kappa, body.k, body.d, body.R, body.P);
  return body;
}

constexpr int kappaPlace = 4;

/// a + iα X − ω² X
Vector accelerationAt(const BodyAt<Real>& body, Vector a, Vector X) {
  return mulAdd(body.alpha, perp(X), mulAdd(-(body.omega * body.omega), X, a));
}

Vector inertialForce(const BodyAt<Real>& body, Vector a) {
  return body.m * accelerationAt(body, a, body.R);
}

Vector beyond(const BodyAt<Real>& body, Vector a) {
  return accelerationAt(body, a, body.P);
}

void linearizeOutwardsAll(const LinearArrays& arrays, const LinearState& at, Rows sums) {
  Vector a, force, P;
  Real mass;
  for (int i = 0; i < arrays.steps; ++i) {
    Reader<Real> link(simd::at(arrays.links, linkQuantities, i, 0));
    BodyAt<Real> body;
    Real inertia;
    Vector r, p;
    link(body.m, inertia, r, p);
    const Vector turned = gatheredVector(arrays, at.e, i);
    const Rotation<Real> turn{turned.x, turned.y};
    body.R = turn * r;
    body.P = turn * p;
    body.J = mulAdd(body.m, dot(body.R, body.R), inertia);
    body.omega = gathered<Real>(arrays, at.omega, i);
    body.alpha = gathered<Real>(arrays, at.alpha, i);

    body.k = gathered<Real>(arrays, at.k, i);
    body.d = gathered<Real>(arrays, at.d, i);
    Writer<Real> write(stateAt(arrays, i));
    write(body.m, body.J, body.omega, body.alpha, Real(), body.k, body.d, body.R, body.P);

    mass += body.m;
    force += inertialForce(body, a);
    if (at.F) force -= gatheredVector(arrays, at.F, i);
    a = beyond(body, a);
    P = body.P;
  }
  RowWriter<Real> write(sums);
  write(a, force, mass, unit(P));
}

/// κ, from the tip of each segment; a is what it was on the way out, taken back link by link.
void linearizeInwardsAll(const LinearArrays& arrays, const LinearState& at, ConstRows starts) {
  Vector a{Real::load(starts[0]), Real::load(starts[1])};
  Vector outer{Real::load(starts[2]), Real::load(starts[3])};
  // Outwards: a of each inner pin, kept where κ will be and in the sweeps.
  for (int i = 0; i < arrays.steps; ++i) {
    const BodyAt<Real> body = bodyAt(arrays, i);
    Writer<Real> write(sweepAt<Real>(arrays, i));
    write(a);
    a = beyond(body, a);
  }
  for (int i = arrays.steps - 1; i >= 0; --i) {
    const BodyAt<Real> body = bodyAt(arrays, i);
    Vector inner;
    Reader<Real> read(sweepAt<Real>(arrays, i));
    read(inner);
    Real kappa = mulAdd(-body.m, dot(body.R, inner), -dot(body.P, outer));
    if (at.XF) kappa += gathered<Real>(arrays, at.XF, i);
    kappa.store(stateAt(arrays, i) + kappaPlace * laneCount);
    outer += inertialForce(body, inner);
    if (at.F) outer -= gatheredVector(arrays, at.F, i);
  }
}

// ---- The solve -------------------------------------------------------------------------------

template <class Number>
void flush(Triple<Number>& a) {
  const auto flushOne = [](Number& number) {
    for (int k = 0; k < parts<Number>; ++k) part(number, k) = flushed(part(number, k));
  };
  flushOne(a.x), flushOne(a.y), flushOne(a.z);
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

    const Triple<Number> t =
        mulAdd(Number(body.P.y), Gx, mulAdd(Number(-body.P.x), Gy, Triple<Number>{-Gz.x, -Gz.y, -Gz.z}));
    const Triple<Number> eta = mulAdd(handle.zP.x, Hx, mulAdd(handle.zP.y, Hy, Hz));

    Writer<Number> write(handleAt<Number>(arrays, i));
    write(handle.B, handle.p, handle.zP, handle.UR, handle.UL, handle.inverseD, handle.k, Hx, Hy, eta, t);

    const Triple<Number> tD = handle.inverseD * t;
    Cx = mulAdd(-eta.x, tD, Cx);
    Cy = mulAdd(-eta.y, tD, Cy);
    Cz = mulAdd(-eta.z, tD, Cz);
    Gx = mulAdd(handle.UR.x, tD, Gx);
    Gy = mulAdd(handle.UR.y, tD, Gy);
    Gz = -handle.k * tD;
    const Triple<Number> etaD = handle.inverseD * eta;
    Hx = mulAdd(-handle.UL.x, etaD, Hx);
    Hy = mulAdd(-handle.UL.y, etaD, Hy);
    Hz = handle.k * etaD;
    if (i % stepsPerFlush == 0) flush(Gx), flush(Gy), flush(Gz), flush(Hx), flush(Hy), flush(Hz);
  }
  RowWriter<Number> write(to);
  write(shown.B.xx, shown.B.xy, shown.h.x, shown.B.yx, shown.B.yy, shown.h.y, shown.p, shown.q);
  write(Hx.x, Hy.x, Hz.x, Hx.y, Hy.y, Hz.y, Hx.z, Hy.z, Hz.z);
  write(Gx, Gy, Gz, Cx, Cy, Cz);
}

template <class Number>
[[gnu::always_inline]] inline LinearHandle<Number> handleFrom(Reader<Number>& read) {
  LinearHandle<Number> handle;
  read(handle.B, handle.p, handle.zP, handle.UR, handle.UL, handle.inverseD, handle.k);
  return handle;
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
    Reader<Number> read(handleAt<Number>(arrays, i));
    const LinearHandle<Number> handle = handleFrom(read);
    Triple<Number> Hx, Hy, eta;
    read(Hx, Hy, eta);
    const Sweep<Number> sweep = carry(bodyAt(arrays, i), handle, inverseS * rho, inverseS * (rho - rhoInner),
                                      gathered<Number>(arrays, rhoV, i), b, r);
    c = mulAdd(sweep.wP.x, Hx, mulAdd(sweep.wP.y, Hy, c));
    c = mulAdd(sweep.epsilon * handle.inverseD, eta, c);

    Writer<Number> write(sweepAt<Number>(arrays, i));
    write(sweep.wP, sweep.epsilon);
    rho = rhoInner;
  }
  RowWriter<Number> write(to);
  write(b, r, c);
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
  Y.x = fromRows<Number>(ends);
  Y.y = fromRows<Number>(ends);
  Y.z = fromRows<Number>(ends);
  for (int i = 0; i < arrays.steps; ++i) {
    Reader<Number> read(handleAt<Number>(arrays, i));
    const LinearHandle<Number> handle = handleFrom(read);
    read.from += 9 * parts<Number> * laneCount;
    Triple<Number> t;
    read(t);
    Reader<Number> sweep(sweepAt<Number>(arrays, i));
    Vec2<Number> wP;
    Number epsilon;
    sweep(wP, epsilon);
    const Number outside = mulAdd(t.x, Y.x, mulAdd(t.y, Y.y, mulAdd(t.z, Y.z, epsilon)));
    const Number pulled = mulAdd(-handle.UL.x, da.x, mulAdd(-handle.UL.y, da.y, outside));
    parent = mulAdd(handle.k, parent, pulled) * handle.inverseD;
    da = mulAdd(parent, handle.zP, da + wP);
    const Number sigma = inverseS * gathered<Number>(arrays, rhoQ, i);
    scattered(arrays, sigma + parent, i, u);
    scattered(arrays, s * parent, i, v);
  }
}

template <class Number>
constexpr LinearKernel linearKernel{factorAll<Number>, solveInwardsAll<Number>, solveOutwardsAll<Number>};

}  // namespace
}  // namespace planar_chain::simd
