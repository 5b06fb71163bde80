#pragma once

/// The exact solve of linearized.h in segments, for `laneCount` lanes. See linearized_segments.h for the
/// equations.

#include <algorithm>

#include "lanes/linear_join.h"

namespace planar_chain::simd {
namespace {

// ---- The state -------------------------------------------------------------------------------

/// The address of the quantities of step i.
template <class Scalar, int quantities>
double* at(const Steps<quantities>& steps, int i) {
  return steps.first + static_cast<std::ptrdiff_t>(i) * quantities * doubles<Scalar>;
}

template <class Scalar>
inline BodyAt<PartOf<Scalar>> bodyAt(const LinearArrays& arrays, int i) {
  using Real = PartOf<Scalar>;
  BodyAt<Real> body;
  Reader{at<Real>(arrays.state, i)}(body.k, body.d, body.omega, body.alpha, body.P);
  Reader{at<Real>(arrays.masses, i)}(body.R, body.m, body.J, body.kappa);
  return body;
}

/// κ. First outwards, with inner pins of the segments that do not accelerate: `factors` gets the
/// accelerations of the pins until the next factorization. Then inwards from the tip of each segment.
template <class Real>
void linearizeAll(const LinearArrays& arrays, LinearState given, Vec2d ground) {
  constexpr int lanes = doubles<Real>;
  Vec2<Real> a, force;
  Real mass;
  for (int i = 0; i < arrays.steps; ++i) {
    const Body<Real> link = linkAt<Real>(arrays.links, i);
    const Rotation<Real> turn = readRotation<Real>(given.e, i);
    BodyAt<Real> body;
    body.m = link.m;
    body.R = turn * link.r;
    body.P = turn * link.p;
    body.J = mulAdd(body.m, dot(body.R, body.R), link.I);
    body.omega = read<Real>(given.omega, i);
    body.alpha = read<Real>(given.alpha, i);
    double* state = at<Real>(arrays.state, i) + LinearArrays::jointQuantities * lanes;
    Writer{state}(body.omega, body.alpha, body.P);
    Writer{at<Real>(arrays.masses, i)}(body.R, body.m, body.J);
    Writer{at<Real>(arrays.factors, i)}(a);

    mass += body.m;
    force += body.m * accelerationAt(body, a, body.R);
    if (given.F) force -= readVector<Real>(given.F, i);
    a = accelerationAt(body, a, body.P);
  }

  // The accelerations of the inner pins less gravity, and the forces of all outside, from segment to segment.
  const Vec2<Real> start = sumOfOthers(a, ground, true);
  Vec2<Real> outer = sumOfOthers(force + mass * start, {}, false);

  for (int i = arrays.steps - 1; i >= 0; --i) {
    const auto body = bodyAt<Real>(arrays, i);
    Reader{at<Real>(arrays.factors, i)}(a);
    a += start;
    Real kappa = mulAdd(-body.m, dot(body.R, a), -dot(body.P, outer));
    if (given.XF) kappa += read<Real>(given.XF, i);
    kappa.store(at<Real>(arrays.masses, i + 1) - lanes);
    outer += body.m * accelerationAt(body, a, body.R);
    if (given.F) outer -= readVector<Real>(given.F, i);
  }
}

// ---- The solve -------------------------------------------------------------------------------

/// The axes of the segments' outer pins.
Axes outerAxes(const LinearArrays& arrays) {
  return {unit(bodyAt<Pack>(arrays, arrays.steps - 1).P)};
}

/// The factors that the ways out read: U_L/D and k̂/D.
template <class Scalar>
inline LinearFactors<Scalar> outwardFactors(const LinearArrays& arrays, int i) {
  LinearFactors<Scalar> factors;
  Reader{at<Scalar>(arrays.factors, i)}(factors.ULD, factors.kD);
  return factors;
}

/// The factors that the way in reads, or computes again from `articulated`, which belongs to the bodies
/// beyond.
template <class Scalar, bool keepsAll>
inline LinearFactors<Scalar> inwardFactors(const LinearArrays& arrays, int i,
                                           const BodyAt<PartOf<Scalar>>& body, Scalar s,
                                           LinearArticulatedTerms<Scalar>& articulated) {
  if constexpr (!keepsAll) return eliminate(body, s, articulated);
  LinearFactors<Scalar> factors;
  Reader{at<Scalar>(arrays.inward, i)}(factors.inverseD, factors.UR, factors.Mv, factors.Mq, factors.Ev,
                                       factors.Eq);
  return factors;
}

/// A factorization on its way in. It takes a few steps at a time: first `articulated`, then G, then H and C.
/// All of them together would not fit into a CPU's registers.
template <class Scalar, bool keepsAll>
class Factorization {
 public:
  explicit Factorization(const LinearArrays& arrays, Scalar s) : arrays_(arrays), s_(s) {
    if constexpr (!isOneLane<Scalar>) {
      axes_ = outerAxes(arrays);
      const Scalar zero{}, one = Pack(1);
      G_ = axes_.taking(Matrix3<Scalar>{{one, zero, zero}, {zero, one, zero}, {zero, zero, one}});
      H_ = G_;
    }
  }

  /// Steps last − 1 … first.
  void go(int first, int last) {
    articulated_ = eliminateBodies(first, last, articulated_);
    if constexpr (!isOneLane<Scalar>) {
      G_ = carryG(first, last, G_);
      carryH(first, last);
      G_ = mapped(G_, flush);
      H_ = mapped(H_, flush);
    }
  }

  SegmentTerms<Scalar> segmentTerms() const {
    const Matrix2<Scalar>& B = articulated_.B;
    return {axes_.d,
            {{B.xx, B.xy, articulated_.h.x},
             {B.yx, B.yy, articulated_.h.y},
             {articulated_.p.x, articulated_.p.y, articulated_.q}},
            {{H_.x.x, H_.y.x, H_.z.x}, {H_.x.y, H_.y.y, H_.z.y}, {H_.x.z, H_.y.z, H_.z.z}},
            G_,
            C_};
  }

 private:
  // By value, so that they stay in registers.
  LinearArticulatedTerms<Scalar> eliminateBodies(int first, int last,
                                                 LinearArticulatedTerms<Scalar> articulated) {
    for (int i = last - 1; i >= first; --i) {
      const LinearFactors<Scalar> factors = eliminate(bodyAt<Scalar>(arrays_, i), s_, articulated);
      Writer{at<Scalar>(arrays_.factors, i)}(factors.ULD, factors.kD);
      if constexpr (keepsAll) {
        Writer{at<Scalar>(arrays_.inward, i)}(factors.inverseD, factors.UR, factors.Mv, factors.Mq,
                                              factors.Ev, factors.Eq);
      } else {
        inverseD_[i - first] = factors.inverseD;
        UR_[i - first] = factors.UR;
      }
    }
    return articulated;
  }

  /// t = −Gᵀ(iP, 1), G ← G + (U_R, −k̂ …) tᵀ/D
  Matrix3<Scalar> carryG(int first, int last, Matrix3<Scalar> G) const {
    for (int i = last - 1; i >= first; --i) {
      const auto body = bodyAt<Scalar>(arrays_, i);
      Scalar inverseD = inverseD_[keepsAll ? 0 : i - first];
      Vec2<Scalar> UR = UR_[keepsAll ? 0 : i - first];
      if constexpr (keepsAll) Reader{at<Scalar>(arrays_.inward, i)}(inverseD, UR);
      const Triple<Scalar> tD = inverseD * mulAdd(body.P.y, G.x, mulAdd(-body.P.x, G.y, -G.z));
      Writer{at<Scalar>(arrays_.outward, i)}(tD);
      G = {mulAdd(UR.x, tD, G.x), mulAdd(UR.y, tD, G.y), -stiffness(body, s_) * tD};
    }
    return G;
  }

  /// η = H (zP, 1), H ← H − η (U_L, −k̂ …)ᵀ/D, C ← C − η tᵀ/D
  void carryH(int first, int last) {
    Matrix3<Scalar> H = H_, C = C_;
    for (int i = last - 1; i >= first; --i) {
      const auto body = bodyAt<Scalar>(arrays_, i);
      const LinearFactors<Scalar> factors = outwardFactors<Scalar>(arrays_, i);
      const Vec2<Scalar> zP = turnScale(turnOf(body, s_), body.P);
      const Triple<Scalar> eta = mulAdd(zP.x, H.x, mulAdd(zP.y, H.y, H.z));
      H = {mulAdd(-factors.ULD.x, eta, H.x), mulAdd(-factors.ULD.y, eta, H.y), factors.kD * eta};
      Triple<Scalar> tD;
      Reader{at<Scalar>(arrays_.outward, i)}(tD);
      C = {mulAdd(-eta.x, tD, C.x), mulAdd(-eta.y, tD, C.y), mulAdd(-eta.z, tD, C.z)};
    }
    H_ = H;
    C_ = C;
  }

  const LinearArrays& arrays_;
  Scalar s_;
  Axes axes_;
  LinearArticulatedTerms<Scalar> articulated_;
  Scalar inverseD_[keepsAll ? 1 : stepsPerFlush];  ///< of the steps in hand, where they are not kept
  Vec2<Scalar> UR_[keepsAll ? 1 : stepsPerFlush];
  Matrix3<Scalar> G_, C_;
  Matrix3<Scalar> H_;  ///< by columns
};

template <class Scalar, bool keepsAll>
PLANAR_CHAIN_IN_ONE_PIECE void factorAll(const LinearArrays& arrays, const double* s) {
  Factorization<Scalar, keepsAll> factorization(arrays, everywhere<Scalar>(s));
  for (int last = arrays.steps; last > 0; last -= stepsPerFlush) {
    factorization.go(std::max(0, last - stepsPerFlush), last);
  }
  if constexpr (!isOneLane<Scalar>)
    LinearPairs<Scalar, 1>::factor(factorization.segmentTerms(), arrays.pairs);
}

/// [ρ_q; ρ_v].
struct Side {
  const double *rhoQ, *rhoV;
};

/// b and r at the segments' inner joints. Stores ε/D.
template <class Scalar, bool keepsAll>
inline Triple<Scalar> carryInwards(const LinearArrays& arrays, Scalar s, Side side) {
  const Scalar inverseS = PartOf<Scalar>(1) / s;
  Vec2<Scalar> b;
  Scalar r{};
  LinearArticulatedTerms<Scalar> articulated;
  const int last = arrays.steps - 1;
  Scalar rho = numberAt<Scalar>(side.rhoQ, last);
  const Scalar rhoBefore = ofSegmentBefore(rho);
  for (int i = last; i >= 0; --i) {
    const Scalar rhoInner = i > 0 ? numberAt<Scalar>(side.rhoQ, i - 1) : rhoBefore;
    const auto body = bodyAt<Scalar>(arrays, i);
    const LinearFactors<Scalar> factors = inwardFactors<Scalar, keepsAll>(arrays, i, body, s, articulated);
    Writer{at<Scalar>(arrays.sweeps, i)}(carry(body, factors, s, inverseS * rho, inverseS * (rho - rhoInner),
                                               numberAt<Scalar>(side.rhoV, i), b, r));
    rho = rhoInner;
  }
  return {b.x, b.y, r};
}

/// Step i of the way out; `external` is added to ε/D.
template <class Scalar>
inline Scalar pass(const LinearArrays& arrays, int i, Scalar s, Scalar inverseS, Side side, Scalar external,
                   Moving<Scalar>& X) {
  const Scalar sigma = inverseS * numberAt<Scalar>(side.rhoQ, i);
  Scalar epsilonD;
  Reader{at<Scalar>(arrays.sweeps, i)}(epsilonD);
  X.pass(bodyAt<Scalar>(arrays, i), outwardFactors<Scalar>(arrays, i), s, sigma,
         numberAt<Scalar>(side.rhoV, i), external + epsilonD);
  return sigma;
}

/// X' of each segment for Y' = 0.
template <class Scalar>
inline Triple<Scalar> ownMotion(const LinearArrays& arrays, Scalar s, Side side) {
  const Scalar inverseS = PartOf<Scalar>(1) / s;
  Moving<Scalar> X;
  for (int i = 0; i < arrays.steps; ++i) {
    pass(arrays, i, s, inverseS, side, Scalar(), X);
  }
  return {X.da.x, X.da.y, X.parent};
}

template <class Scalar>
inline void carryOutwards(const LinearArrays& arrays, Scalar s, Side side, const Triple<Scalar>& start,
                          const Triple<Scalar>& Y, double* u, double* v) {
  const Scalar inverseS = PartOf<Scalar>(1) / s;
  Moving<Scalar> X{{start.x, start.y}, start.z};
  for (int i = 0; i < arrays.steps; ++i) {
    Scalar external{};
    if constexpr (!isOneLane<Scalar>) {
      Triple<Scalar> tD;
      Reader{at<Scalar>(arrays.outward, i)}(tD);
      external = dot(tD, Y);
    }
    const Scalar sigma = pass(arrays, i, s, inverseS, side, external, X);
    write(u, i, sigma + X.parent);
    write(v, i, s * X.parent);
  }
}

template <class Scalar, bool keepsAll>
PLANAR_CHAIN_IN_ONE_PIECE void solveAll(const LinearArrays& arrays, const double* s_, const double* rhoQ,
                                        const double* rhoV, double* u, double* v) {
  const Scalar s = everywhere<Scalar>(s_);
  const Side side{rhoQ, rhoV};
  [[maybe_unused]] const Triple<Scalar> y = carryInwards<Scalar, keepsAll>(arrays, s, side);
  Triple<Scalar> X{}, Y{};
  if constexpr (!isOneLane<Scalar>) {
    const Triple<Scalar> c = outerAxes(arrays).fromGround(ownMotion(arrays, s, side));
    LinearPairs<Scalar, 1>::solve({y, c}, arrays.pairs, X, Y);
  }
  carryOutwards(arrays, s, side, X, Y, u, v);
}

template <class Scalar, bool keepsAll>
constexpr LinearKernel linearKernel{factorAll<Scalar, keepsAll>, solveAll<Scalar, keepsAll>};

template <class Real>
constexpr LinearKernels linearKernels{linearizeAll<Real>, linearKernel<Real, true>,
                                      linearKernel<ComplexOf<Real>, true>, linearKernel<Real, false>,
                                      linearKernel<ComplexOf<Real>, false>};

}  // namespace
}  // namespace planar_chain::simd
