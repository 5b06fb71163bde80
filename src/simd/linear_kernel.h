#pragma once

/// The exact solve of linearized.h in segments, for `laneCount` lanes. See linearized_segments.h for the
/// equations.

#include <algorithm>

#include "lane_streams.h"

namespace planar_chain::simd {
namespace {

// ---- The state -------------------------------------------------------------------------------

/// Where the quantities of step i stand.
template <class Number>
double* placeOf(double* array, int quantities, int i) {
  return array + static_cast<std::ptrdiff_t>(i) * quantities * parts<Number> * laneCount;
}

template <class Number>
double* inwardAt(const LinearArrays& arrays, int i) {
  return placeOf<Number>(arrays.inward, LinearArrays::inwardQuantities, i);
}

template <class Number>
double* outwardAt(const LinearArrays& arrays, int i) {
  return placeOf<Number>(arrays.outward, LinearArrays::outwardQuantities, i);
}

template <class Number>
double* sweepAt(const LinearArrays& arrays, int i) {
  return placeOf<Number>(arrays.sweeps, LinearArrays::sweepQuantities, i);
}

const double* jointAt(const LinearArrays& arrays, int i) {
  return arrays.joints + static_cast<std::ptrdiff_t>(i) * LinearArrays::jointQuantities * laneCount;
}

double* stateAt(const LinearArrays& arrays, int i) {
  return placeOf<Real>(arrays.state, LinearArrays::stateQuantities, i);
}

[[gnu::always_inline]] inline BodyAt<Real> bodyAt(const LinearArrays& arrays, int i) {
  BodyAt<Real> body;
  Reader<Real> joint(jointAt(arrays, i));
  joint(body.m, body.k, body.d);
  Reader<Real> state(stateAt(arrays, i));
  state(body.J, body.omega, body.alpha, body.kappa, body.R, body.P);
  return body;
}

constexpr int kappaPlace = 3;

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

/// As if the inner pin of each segment did not accelerate. The accelerations of the pins stand in the sweeps.
void linearizeOutwardsAll(const LinearArrays& arrays, const LinearState& at, Rows sums) {
  Vector a, force, P;
  Real mass;
  for (int i = 0; i < arrays.steps; ++i) {
    Reader<Real> link(simd::at(arrays.links, linkQuantities, i, 0));
    BodyAt<Real> body;
    Real inertia;
    Vector r, p;
    link(body.m, inertia, r, p);
    const Vector turned = readVector(arrays, at.e, i);
    const Rotation<Real> turn{turned.x, turned.y};
    body.R = turn * r;
    body.P = turn * p;
    body.J = mulAdd(body.m, dot(body.R, body.R), inertia);
    body.omega = gathered<Real>(arrays, at.omega, i);
    body.alpha = gathered<Real>(arrays, at.alpha, i);
    Writer<Real> write(stateAt(arrays, i));
    write(body.J, body.omega, body.alpha, Real(), body.R, body.P);
    Writer<Real> pin(sweepAt<Real>(arrays, i));
    pin(a);

    mass += body.m;
    force += inertialForce(body, a);
    if (at.F) force -= readVector(arrays, at.F, i);
    a = beyond(body, a);
    P = body.P;
  }
  RowWriter<Real> write(sums);
  write(a, force, mass, unit(P));
}

/// κ, from the tip of each segment.
void linearizeInwardsAll(const LinearArrays& arrays, const LinearState& at, ConstRows starts) {
  const Vector start{Real::load(starts[0]), Real::load(starts[1])};
  Vector outer{Real::load(starts[2]), Real::load(starts[3])};
  for (int i = arrays.steps - 1; i >= 0; --i) {
    const BodyAt<Real> body = bodyAt(arrays, i);
    Vector a;
    Reader<Real> pin(sweepAt<Real>(arrays, i));
    pin(a);
    a += start;
    Real kappa = mulAdd(-body.m, dot(body.R, a), -dot(body.P, outer));
    if (at.XF) kappa += gathered<Real>(arrays, at.XF, i);
    kappa.store(stateAt(arrays, i) + kappaPlace * laneCount);
    outer += inertialForce(body, a);
    if (at.F) outer -= readVector(arrays, at.F, i);
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

/// A factorization on its way in. A few steps at a time, and for these first what a body shows, then what it
/// does to each of the other matrices: all of them together would not fit into a CPU's registers.
template <class Number>
class Factorization {
  /// 3×3: G and C by rows, H by columns.
  struct Rows3 {
    Triple<Number> x, y, z;
  };

 public:
  explicit Factorization(const LinearArrays& arrays, Number s) : arrays_(arrays), s_(s) {
    const Vector d = unit(bodyAt(arrays, arrays.steps - 1).P);
    const Number zero = Real(), one = Real(1), x = d.x, y = d.y;
    G_ = H_ = {{x, -y, zero}, {y, x, zero}, {zero, zero, one}};
  }

  /// Steps last − 1 … first.
  void go(int first, int last) {
    shown_ = eliminateBodies(first, last, shown_);
    G_ = carryG(first, last, G_);
    H_ = carryH(first, last, H_);
    C_ = addToC(first, last, C_);
    flush(G_.x), flush(G_.y), flush(G_.z), flush(H_.x), flush(H_.y), flush(H_.z);
  }

  void writeTo(Rows to) const {
    RowWriter<Number> write(to);
    write(shown_.B.xx, shown_.B.xy, shown_.h.x, shown_.B.yx, shown_.B.yy, shown_.h.y, shown_.p, shown_.q);
    write(H_.x.x, H_.y.x, H_.z.x, H_.x.y, H_.y.y, H_.z.y, H_.x.z, H_.y.z, H_.z.z);
    write(G_.x, G_.y, G_.z, C_.x, C_.y, C_.z);
  }

 private:
  // What is found first stands first: B, p, U_R, 1/D, k̂ | H's first columns | η, and zP, U_L/D, k̂/D | t/D.
  static constexpr int size = parts<Number> * laneCount;
  double* columnsAt(int i) const { return inwardAt<Number>(arrays_, i) + 10 * size; }
  double* etaAt(int i) const { return columnsAt(i) + 6 * size; }
  double* tDAt(int i) const { return outwardAt<Number>(arrays_, i) + 5 * size; }

  // By value, so that they stay in registers.
  Shown<Number> eliminateBodies(int first, int last, Shown<Number> shown) const {
    for (int i = last - 1; i >= first; --i) {
      const LinearHandle<Number> handle = eliminate(bodyAt(arrays_, i), s_, shown);
      Writer<Number> inward(inwardAt<Number>(arrays_, i));
      inward(handle.B, handle.p, handle.UR, handle.inverseD, handle.k);
      Writer<Number> outward(outwardAt<Number>(arrays_, i));
      outward(handle.zP, handle.inverseD * handle.UL, handle.inverseD * handle.k);
    }
    return shown;
  }

  /// t = −Gᵀ(iP, 1), G ← G + (U_R, −k̂ …) tᵀ/D
  Rows3 carryG(int first, int last, Rows3 G) const {
    for (int i = last - 1; i >= first; --i) {
      Reader<Number> inward(inwardAt<Number>(arrays_, i) + 6 * size);
      Vec2<Number> UR;
      Number inverseD, k;
      inward(UR, inverseD, k);
      const Vector P = bodyAt(arrays_, i).P;
      const Triple<Number> tD = inverseD * mulAdd(P.y, G.x, mulAdd(-P.x, G.y, -G.z));
      Writer<Number> write(tDAt(i));
      write(tD);
      G = {mulAdd(UR.x, tD, G.x), mulAdd(UR.y, tD, G.y), -k * tD};
    }
    return G;
  }

  /// η = H (zP, 1), H ← H − η (U_L, −k̂ …)ᵀ/D
  Rows3 carryH(int first, int last, Rows3 H) const {
    for (int i = last - 1; i >= first; --i) {
      Reader<Number> outward(outwardAt<Number>(arrays_, i));
      Vec2<Number> zP, ULD;
      Number kD;
      outward(zP, ULD, kD);
      const Triple<Number> eta = mulAdd(zP.x, H.x, mulAdd(zP.y, H.y, H.z));
      Writer<Number> write(columnsAt(i));
      write(H.x, H.y, eta);
      H = {mulAdd(-ULD.x, eta, H.x), mulAdd(-ULD.y, eta, H.y), kD * eta};
    }
    return H;
  }

  /// C ← C − η tᵀ/D
  Rows3 addToC(int first, int last, Rows3 C) const {
    for (int i = last - 1; i >= first; --i) {
      Triple<Number> eta, tD;
      Reader<Number> inward(etaAt(i));
      inward(eta);
      Reader<Number> outward(tDAt(i));
      outward(tD);
      C = {mulAdd(-eta.x, tD, C.x), mulAdd(-eta.y, tD, C.y), mulAdd(-eta.z, tD, C.z)};
    }
    return C;
  }

  const LinearArrays& arrays_;
  Number s_;
  Shown<Number> shown_;
  Rows3 G_, H_, C_;
};

template <class Number>
void factorAll(const LinearArrays& arrays, const double* s, Rows to) {
  Factorization<Number> factorization(arrays, everywhere<Number>(s));
  for (int last = arrays.steps; last > 0; last -= stepsPerFlush) {
    factorization.go(std::max(0, last - stepsPerFlush), last);
  }
  factorization.writeTo(to);
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
    const Number rhoInner = gathered<Number, -1>(arrays, rhoQ, i);
    Reader<Number> read(inwardAt<Number>(arrays, i));
    LinearHandle<Number> handle;
    Triple<Number> Hx, Hy, eta;
    read(handle.B, handle.p, handle.UR, handle.inverseD, handle.k, Hx, Hy, eta);
    const Sweep<Number> sweep = carry(bodyAt(arrays, i), handle, inverseS * rho, inverseS * (rho - rhoInner),
                                      gathered<Number>(arrays, rhoV, i), b, r);
    c = mulAdd(sweep.wP.x, Hx, mulAdd(sweep.wP.y, Hy, c));
    const Number epsilonD = sweep.epsilon * handle.inverseD;
    c = mulAdd(epsilonD, eta, c);

    Writer<Number> write(sweepAt<Number>(arrays, i));
    write(sweep.wP, epsilonD);
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
    Reader<Number> read(outwardAt<Number>(arrays, i));
    Vec2<Number> zP, ULD, wP;
    Number kD, epsilonD;
    Triple<Number> tD;
    read(zP, ULD, kD, tD);
    Reader<Number> sweep(sweepAt<Number>(arrays, i));
    sweep(wP, epsilonD);
    const Number outside = mulAdd(tD.x, Y.x, mulAdd(tD.y, Y.y, mulAdd(tD.z, Y.z, epsilonD)));
    const Number pulled = mulAdd(-ULD.x, da.x, mulAdd(-ULD.y, da.y, outside));
    parent = mulAdd(kD, parent, pulled);
    da = mulAdd(parent, zP, da + wP);
    const Number sigma = inverseS * gathered<Number>(arrays, rhoQ, i);
    scattered(arrays, sigma + parent, i, u);
    scattered(arrays, s * parent, i, v);
  }
}

template <class Number>
constexpr LinearKernel linearKernel{factorAll<Number>, solveInwardsAll<Number>, solveOutwardsAll<Number>};

}  // namespace
}  // namespace planar_chain::simd
