#pragma once

/// The exact solve of linearized.h in segments, for `laneCount` lanes. See linearized_segments.h for the
/// equations.

#include <algorithm>

#include "lanes/linear_join.h"

namespace planar_chain::simd {
namespace {

// ---- The state -------------------------------------------------------------------------------

/// The address of the quantities of step i.
template <class Number, int quantities>
double* at(const Steps<quantities>& steps, int i) {
  return steps.first + static_cast<std::ptrdiff_t>(i) * quantities * doubles<Number>;
}

template <class Number>
inline BodyAt<PartOf<Number>> bodyAt(const LinearArrays& arrays, int i) {
  using Part = PartOf<Number>;
  BodyAt<Part> body;
  Reader{at<Part>(arrays.state, i)}(body.k, body.d, body.omega, body.alpha, body.P);
  Reader{at<Part>(arrays.masses, i)}(body.R, body.m, body.J, body.kappa);
  return body;
}

/// κ. First outwards, with inner pins of the segments that do not accelerate: `handles` gets the
/// accelerations of the pins until the next factorization. Then inwards from the tip of each segment.
template <class Part>
void linearizeAll(const LinearArrays& arrays, LinearState given, Vec2d ground) {
  constexpr int lanes = doubles<Part>;
  Vec2<Part> a, force;
  Part mass;
  for (int i = 0; i < arrays.steps; ++i) {
    const Body<Part> link = linkAt<Part>(arrays.links, i);
    const Rotation<Part> turn = readRotation<Part>(given.e, i);
    BodyAt<Part> body;
    body.m = link.m;
    body.R = turn * link.r;
    body.P = turn * link.p;
    body.J = mulAdd(body.m, dot(body.R, body.R), link.I);
    body.omega = read<Part>(given.omega, i);
    body.alpha = read<Part>(given.alpha, i);
    double* state = at<Part>(arrays.state, i) + LinearArrays::jointQuantities * lanes;
    Writer{state}(body.omega, body.alpha, body.P);
    Writer{at<Part>(arrays.masses, i)}(body.R, body.m, body.J);
    Writer{at<Part>(arrays.handles, i)}(a);

    mass += body.m;
    force += body.m * accelerationAt(body, a, body.R);
    if (given.F) force -= readVector<Part>(given.F, i);
    a = accelerationAt(body, a, body.P);
  }

  // The accelerations of the inner pins less gravity, and the forces of all outside, from segment to segment.
  double sums[5 * lanes], starts[4 * lanes];
  Writer{sums}(a, force, mass);
  const auto pairOf = [](const double* of, int s) { return Vec2<Number>{of[s], of[lanes + s]}; };
  const auto setPair = [](double* of, int s, Vec2<Number> to) {
    of[s] = to.x.v;
    of[lanes + s] = to.y.v;
  };
  Vec2<Number> pin = vectorOf(ground), outside;
  for (int s = 0; s < lanes; ++s) {
    setPair(starts, s, pin);
    pin += pairOf(sums, s);
  }
  for (int s = lanes - 1; s >= 0; --s) {
    setPair(starts + 2 * lanes, s, outside);
    outside += pairOf(sums + 2 * lanes, s) + Number(sums[4 * lanes + s]) * pairOf(starts, s);
  }
  Vec2<Part> start, outer;
  Reader{starts}(start, outer);

  for (int i = arrays.steps - 1; i >= 0; --i) {
    const auto body = bodyAt<Part>(arrays, i);
    Reader{at<Part>(arrays.handles, i)}(a);
    a += start;
    Part kappa = mulAdd(-body.m, dot(body.R, a), -dot(body.P, outer));
    if (given.XF) kappa += read<Part>(given.XF, i);
    kappa.store(at<Part>(arrays.masses, i + 1) - lanes);
    outer += body.m * accelerationAt(body, a, body.R);
    if (given.F) outer -= readVector<Part>(given.F, i);
  }
}

// ---- The solve -------------------------------------------------------------------------------

/// The axes of the segments' outer pins.
Axes outerAxes(const LinearArrays& arrays) {
  return {unit(bodyAt<Real>(arrays, arrays.steps - 1).P)};
}

/// The handle that the ways out read: U_L/D and k̂/D.
template <class Number>
inline LinearHandle<Number> outwardHandle(const LinearArrays& arrays, int i) {
  LinearHandle<Number> handle;
  Reader{at<Number>(arrays.handles, i)}(handle.ULD, handle.kD);
  return handle;
}

/// The handle that the way in reads, or computes again from `shown`, which belongs to the bodies beyond.
template <class Number, bool keepsAll>
inline LinearHandle<Number> inwardHandle(const LinearArrays& arrays, int i,
                                         const BodyAt<PartOf<Number>>& body, Number s, Shown<Number>& shown) {
  if constexpr (!keepsAll) return eliminate(body, s, shown);
  LinearHandle<Number> handle;
  Reader{at<Number>(arrays.inward, i)}(handle.inverseD, handle.UR, handle.Mv, handle.Mq, handle.Ev,
                                       handle.Eq);
  return handle;
}

/// A factorization on its way in. It takes a few steps at a time: first `shown`, then G, then H and C. All of
/// them together would not fit into a CPU's registers.
template <class Number, bool keepsAll>
class Factorization {
 public:
  explicit Factorization(const LinearArrays& arrays, Number s) : arrays_(arrays), s_(s) {
    if constexpr (!isOneLane<Number>) {
      axes_ = outerAxes(arrays);
      const Number zero{}, one = Real(1);
      G_ = axes_.taking(Matrix3<Number>{{one, zero, zero}, {zero, one, zero}, {zero, zero, one}});
      H_ = G_;
    }
  }

  /// Steps last − 1 … first.
  void go(int first, int last) {
    shown_ = eliminateBodies(first, last, shown_);
    if constexpr (!isOneLane<Number>) {
      G_ = carryG(first, last, G_);
      carryH(first, last);
      G_ = mapped(G_, flush);
      H_ = mapped(H_, flush);
    }
  }

  Shows<Number> shows() const {
    const Matrix2<Number>& B = shown_.B;
    return {axes_.d,
            {{B.xx, B.xy, shown_.h.x}, {B.yx, B.yy, shown_.h.y}, {shown_.p.x, shown_.p.y, shown_.q}},
            {{H_.x.x, H_.y.x, H_.z.x}, {H_.x.y, H_.y.y, H_.z.y}, {H_.x.z, H_.y.z, H_.z.z}},
            G_,
            C_};
  }

 private:
  // By value, so that they stay in registers.
  Shown<Number> eliminateBodies(int first, int last, Shown<Number> shown) {
    for (int i = last - 1; i >= first; --i) {
      const LinearHandle<Number> handle = eliminate(bodyAt<Number>(arrays_, i), s_, shown);
      Writer{at<Number>(arrays_.handles, i)}(handle.ULD, handle.kD);
      if constexpr (keepsAll) {
        Writer{at<Number>(arrays_.inward, i)}(handle.inverseD, handle.UR, handle.Mv, handle.Mq, handle.Ev,
                                              handle.Eq);
      } else {
        inverseD_[i - first] = handle.inverseD;
        UR_[i - first] = handle.UR;
      }
    }
    return shown;
  }

  /// t = −Gᵀ(iP, 1), G ← G + (U_R, −k̂ …) tᵀ/D
  Matrix3<Number> carryG(int first, int last, Matrix3<Number> G) const {
    for (int i = last - 1; i >= first; --i) {
      const auto body = bodyAt<Number>(arrays_, i);
      Number inverseD = inverseD_[keepsAll ? 0 : i - first];
      Vec2<Number> UR = UR_[keepsAll ? 0 : i - first];
      if constexpr (keepsAll) Reader{at<Number>(arrays_.inward, i)}(inverseD, UR);
      const Triple<Number> tD = inverseD * mulAdd(body.P.y, G.x, mulAdd(-body.P.x, G.y, -G.z));
      Writer{at<Number>(arrays_.outward, i)}(tD);
      G = {mulAdd(UR.x, tD, G.x), mulAdd(UR.y, tD, G.y), -stiffness(body, s_) * tD};
    }
    return G;
  }

  /// η = H (zP, 1), H ← H − η (U_L, −k̂ …)ᵀ/D, C ← C − η tᵀ/D
  void carryH(int first, int last) {
    Matrix3<Number> H = H_, C = C_;
    for (int i = last - 1; i >= first; --i) {
      const auto body = bodyAt<Number>(arrays_, i);
      const LinearHandle<Number> handle = outwardHandle<Number>(arrays_, i);
      const Vec2<Number> zP = turnScale(turnOf(body, s_), body.P);
      const Triple<Number> eta = mulAdd(zP.x, H.x, mulAdd(zP.y, H.y, H.z));
      H = {mulAdd(-handle.ULD.x, eta, H.x), mulAdd(-handle.ULD.y, eta, H.y), handle.kD * eta};
      Triple<Number> tD;
      Reader{at<Number>(arrays_.outward, i)}(tD);
      C = {mulAdd(-eta.x, tD, C.x), mulAdd(-eta.y, tD, C.y), mulAdd(-eta.z, tD, C.z)};
    }
    H_ = H;
    C_ = C;
  }

  const LinearArrays& arrays_;
  Number s_;
  Axes axes_;
  Shown<Number> shown_;
  Number inverseD_[keepsAll ? 1 : stepsPerFlush];  ///< of the steps in hand, where they are not kept
  Vec2<Number> UR_[keepsAll ? 1 : stepsPerFlush];
  Matrix3<Number> G_, C_;
  Matrix3<Number> H_;  ///< by columns
};

template <class Number, bool keepsAll>
PLANAR_CHAIN_IN_ONE_PIECE void factorAll(const LinearArrays& arrays, const double* s) {
  Factorization<Number, keepsAll> factorization(arrays, everywhere<Number>(s));
  for (int last = arrays.steps; last > 0; last -= stepsPerFlush) {
    factorization.go(std::max(0, last - stepsPerFlush), last);
  }
  if constexpr (!isOneLane<Number>) LinearPairs<Number, 1>::factor(factorization.shows(), arrays.pairs);
}

/// [ρ_q; ρ_v].
struct Side {
  const double *rhoQ, *rhoV;
};

/// b and r at the segments' inner joints. Stores ε/D.
template <class Number, bool keepsAll>
inline Triple<Number> carryInwards(const LinearArrays& arrays, Number s, Side side) {
  const Number inverseS = PartOf<Number>(1) / s;
  Vec2<Number> b;
  Number r{};
  Shown<Number> shown;
  const int last = arrays.steps - 1;
  Number rho = numberAt<Number>(side.rhoQ, last);
  const Number rhoBefore = ofSegmentBefore(rho);
  for (int i = last; i >= 0; --i) {
    const Number rhoInner = i > 0 ? numberAt<Number>(side.rhoQ, i - 1) : rhoBefore;
    const auto body = bodyAt<Number>(arrays, i);
    const LinearHandle<Number> handle = inwardHandle<Number, keepsAll>(arrays, i, body, s, shown);
    Writer{at<Number>(arrays.sweeps, i)}(carry(body, handle, s, inverseS * rho, inverseS * (rho - rhoInner),
                                               numberAt<Number>(side.rhoV, i), b, r));
    rho = rhoInner;
  }
  return {b.x, b.y, r};
}

/// Step i of the way out; `outside` is added to ε/D.
template <class Number>
inline Number pass(const LinearArrays& arrays, int i, Number s, Number inverseS, Side side, Number outside,
                   Moving<Number>& X) {
  const Number sigma = inverseS * numberAt<Number>(side.rhoQ, i);
  Number epsilonD;
  Reader{at<Number>(arrays.sweeps, i)}(epsilonD);
  X.pass(bodyAt<Number>(arrays, i), outwardHandle<Number>(arrays, i), s, sigma,
         numberAt<Number>(side.rhoV, i), outside + epsilonD);
  return sigma;
}

/// X' of each segment for Y' = 0.
template <class Number>
inline Triple<Number> ownMotion(const LinearArrays& arrays, Number s, Side side) {
  const Number inverseS = PartOf<Number>(1) / s;
  Moving<Number> X;
  for (int i = 0; i < arrays.steps; ++i) {
    pass(arrays, i, s, inverseS, side, Number(), X);
  }
  return {X.da.x, X.da.y, X.parent};
}

template <class Number>
inline void carryOutwards(const LinearArrays& arrays, Number s, Side side, const Triple<Number>& start,
                          const Triple<Number>& Y, double* u, double* v) {
  const Number inverseS = PartOf<Number>(1) / s;
  Moving<Number> X{{start.x, start.y}, start.z};
  for (int i = 0; i < arrays.steps; ++i) {
    Number outside{};
    if constexpr (!isOneLane<Number>) {
      Triple<Number> tD;
      Reader{at<Number>(arrays.outward, i)}(tD);
      outside = dot(tD, Y);
    }
    const Number sigma = pass(arrays, i, s, inverseS, side, outside, X);
    write(u, i, sigma + X.parent);
    write(v, i, s * X.parent);
  }
}

template <class Number, bool keepsAll>
PLANAR_CHAIN_IN_ONE_PIECE void solveAll(const LinearArrays& arrays, const double* s_, const double* rhoQ,
                                        const double* rhoV, double* u, double* v) {
  const Number s = everywhere<Number>(s_);
  const Side side{rhoQ, rhoV};
  [[maybe_unused]] const Triple<Number> y = carryInwards<Number, keepsAll>(arrays, s, side);
  Triple<Number> X{}, Y{};
  if constexpr (!isOneLane<Number>) {
    const Triple<Number> c = outerAxes(arrays).fromGround(ownMotion(arrays, s, side));
    LinearPairs<Number, 1>::solve({y, c}, arrays.pairs, X, Y);
  }
  carryOutwards(arrays, s, side, X, Y, u, v);
}

template <class Number, bool keepsAll>
constexpr LinearKernel linearKernel{factorAll<Number, keepsAll>, solveAll<Number, keepsAll>};

template <class Part>
constexpr LinearKernels linearKernels{linearizeAll<Part>, linearKernel<Part, true>,
                                      linearKernel<ComplexOf<Part>, true>, linearKernel<Part, false>,
                                      linearKernel<ComplexOf<Part>, false>};

}  // namespace
}  // namespace planar_chain::simd
