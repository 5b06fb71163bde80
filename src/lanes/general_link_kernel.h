#pragma once

/// The recursion of general.h link by link; see general_chain.h. The compiler options of the including file
/// choose the CPU.

#include "lanes/lane_kernel.h"
#include "recursion/general.h"

namespace planar_chain::simd {
namespace {

template <class Real>
[[gnu::always_inline]] inline JointNumbers<Real> jointAt(const double* joints, std::ptrdiff_t i) {
  JointNumbers<Real> joint;
  Reader{joints + i * doubles<JointNumbers<Real>>}(joint.armature, joint.prescribed, joint.acceleration);
  return joint;
}

[[gnu::always_inline]] inline ArticulatedTerms<double> numbersOf(const ArticulatedTerms<Lane>& of) {
  return {{of.A.xx.v, of.A.xy.v, of.A.yy.v}, {of.b.x.v, of.b.y.v}, {of.H.x.v, of.H.y.v}, of.Q.v, of.c.v};
}
[[gnu::always_inline]] inline TipTerms<double> numbersOf(const TipTerms<Lane>& of) {
  return {{of.Gx.x.v, of.Gx.y.v},
          {of.Gy.x.v, of.Gy.y.v},
          {of.eta.x.v, of.eta.y.v},
          {of.c.x.v, of.c.y.v},
          {of.C.xx.v, of.C.xy.v, of.C.yy.v}};
}

/// Rows of numbers, one of each body: the bodies, turned, and their joints.
class GeneralRows {
 public:
  /// The first row of m, J, R; of P, ω²; of joint terms or a body's outward terms; of y of the tip.
  static constexpr int bodies = 0, pins = 4, rates = 6, terms = 7, tips = 13;
  static_assert(tips + 2 == GeneralArrays::rows);

  explicit GeneralRows(double* first) : first_(first) {}

  [[gnu::always_inline]] Lane number(int row, std::ptrdiff_t j) const {
    return Lane(first_[row * GeneralArrays::width + j]);
  }
  [[gnu::always_inline]] Vec2<Lane> pair(int row, std::ptrdiff_t j) const {
    return {number(row, j), number(row + 1, j)};
  }
  [[gnu::always_inline]] BodyPose<Lane> body(std::ptrdiff_t j) const {
    return {number(bodies, j), number(bodies + 1, j), pair(bodies + 2, j), P(j), ww(j)};
  }
  [[gnu::always_inline]] Vec2<Lane> P(std::ptrdiff_t j) const { return pair(pins, j); }
  [[gnu::always_inline]] Lane ww(std::ptrdiff_t j) const { return number(rates, j); }
  [[gnu::always_inline]] JointTerms<Lane> joint(std::ptrdiff_t j) const {
    return {pair(terms, j), number(terms + 2, j), number(terms + 3, j), number(terms + 4, j),
            number(terms + 5, j)};
  }
  [[gnu::always_inline]] void putJoint(std::ptrdiff_t j, const JointTerms<Lane>& joint) const {
    put(terms, j, joint.u.x, joint.u.y, joint.v, joint.epsilon, joint.inverseD, joint.D0);
  }
  /// The terms of a bare joint.
  [[gnu::always_inline]] OutwardTerms<Lane> outwardTerms(std::ptrdiff_t j) const {
    return {pair(terms, j), P(j), number(terms + 2, j), ww(j)};
  }
  template <class... Numbers>
  [[gnu::always_inline]] void put(int row, std::ptrdiff_t j, Numbers... numbers) const {
    (numbers.store(first_ + row++ * GeneralArrays::width + j), ...);
  }

 private:
  double* first_;
};

[[gnu::always_inline]] inline Displacement<Lane> displacementAt(const GeneralArrays& arrays, int j) {
  const Displacement<double>& by = arrays.displaced[j];
  return {vectorOf(by.d), vectorOf(by.S), vectorOf(by.gamma)};
}

/// A bare joint and its body inwards: A and b are all that is shown.
template <bool holdsTip>
[[gnu::always_inline]] inline void bareInwards(Lane N, const GeneralRows& rows, int j,
                                               ArticulatedTerms<Lane>& articulated, TipTerms<Lane>& tip) {
  const BodyPose<Lane> body = rows.body(j);
  const Factors<Lane> factors = inwards<false>(body, N, articulated.A, articulated.b);
  const OutwardTerms<Lane> outwardTerms = outwardTermsOf(factors, body);
  rows.put(GeneralRows::terms, j, outwardTerms.UD.x, outwardTerms.UD.y, outwardTerms.uD);
  if constexpr (holdsTip) {
    tip.addBody(body.P, body.ww);
    const Vec2<Lane> y = tip.eta, yD = factors.inverseD * y;
    tip.pass(y, {factors.U, {}, {}, factors.inverseD, {}}, outwardTerms.uD);
    tip.eta = {};
    rows.put(GeneralRows::tips, j, yD.x, yD.y);
  }
}

/// Inwards, body by body: takes what a body shows from the rows, and adds what the way out needs.
template <bool holdsTip, bool mayHaveForces, bool hasPrismatic>
[[gnu::always_inline]] inline void generalLinkInwards(const GeneralArrays& arrays, const Loads& external,
                                                      const GeneralRows& rows, int j,
                                                      ArticulatedTerms<Lane>& articulated,
                                                      TipTerms<Lane>& tip) {
  const Lane N(external.N[j]);
  const JointKind kind = arrays.kinds[j];
  if (kind == JointKind::bare) {
    bareInwards<holdsTip>(N, rows, j, articulated, tip);
    if (mayHaveForces && external.F) articulated.b -= vectorOf(external.F[j]);
    return;
  }
  if (hasPrismatic && kind == JointKind::carriage) {
    // Nothing inside turns, and nobody asks for the wrench of the base: A and b are enough.
    const Lane m = rows.number(GeneralRows::bodies, j);
    articulated.A.xx += m;
    articulated.A.yy += m;
    articulated.H = {};
  } else {
    const BodyPose<Lane> body = rows.body(j);
    addBody(body, articulated);
    if constexpr (holdsTip) tip.addBody(body.P, body.ww);
  }
  if (mayHaveForces && external.F) articulated.b -= vectorOf(external.F[j]);

  const auto law = jointAt<Lane>(arrays.joints, j);
  Vec2<Lane> y;
  if (!hasPrismatic || kind == JointKind::revolute) {
    const JointTerms<Lane> joint = passRevolute(N, law, articulated);
    rows.putJoint(j, joint);
    if constexpr (holdsTip) y = tip.passRevolute(joint, law);
  } else {
    const Displacement<Lane> by = displacementAt(arrays, j);
    const JointTerms<Lane> joint = passPrismatic(N, law, by.d, articulated);
    rows.putJoint(j, joint);
    if constexpr (holdsTip) y = tip.passPrismatic(joint, law, by.d);
    if (kind == JointKind::prismatic) {
      stepInwards(by, articulated);
      if constexpr (holdsTip) tip.stepInwards(by);
    }
  }
  if constexpr (holdsTip) rows.put(GeneralRows::tips, j, y.x, y.y);
}

/// Outwards, to the outer pin.
template <bool holdsTip, bool hasPrismatic>
[[gnu::always_inline]] inline void generalLinkOutwards(const GeneralArrays& arrays, const GeneralRows& rows,
                                                       int j, Vec2<Lane> tipForce, const GeneralResults& to,
                                                       Moved<Lane>& at) {
  const JointKind kind = arrays.kinds[j];
  if (kind == JointKind::bare) {
    OutwardTerms<Lane> outwardTerms = rows.outwardTerms(j);
    if constexpr (holdsTip) outwardTerms.uD += dot(rows.pair(GeneralRows::tips, j), tipForce);
    at.alpha = outwards(outwardTerms, at.a);
    to.xdd[j] = at.alpha.v;
    to.moments[j] = 0;
    return;
  }
  JointTerms<Lane> joint = rows.joint(j);
  if constexpr (holdsTip) joint.epsilon += dot(rows.pair(GeneralRows::tips, j), tipForce);
  const auto law = jointAt<Lane>(arrays.joints, j);
  Lane qdd;
  if (!hasPrismatic || kind == JointKind::revolute) {
    to.moments[j] = outwardsRevolute(joint, law, at).v;
    qdd = at.alpha;
  } else {
    to.moments[j] = outwardsPrismatic(joint, law, displacementAt(arrays, j), at, qdd).v;
  }
  to.xdd[j] = qdd.v;
  if (!hasPrismatic || kind != JointKind::carriage) toOuterPin(rows.P(j), rows.ww(j), at);
}

enum class Ends { none, wrench, tip };

template <Ends ends, bool mayHaveForces, bool hasPrismatic>
PLANAR_CHAIN_IN_ONE_PIECE void runGeneralLinks(const GeneralArrays& given, const Loads& acting,
                                               const double* theta, const double* omega, double turning,
                                               GeneralResults to) {
  const GeneralArrays arrays = given;  // what they point to is no part of them
  const Loads external = acting;
  const GeneralRows rows(arrays.terms);
  for (int first = 0; first < arrays.n; first += laneCount) {
    const int k = first / laneCount, count = arrays.n - first;
    double* e = &external.e[first].c;
    const BodyPose<Pack> body =
        bodyPose(linkAt(arrays.links, k), theta ? rotationsOfSome(theta + first, count, e) : loadRotations(e),
                 loadSome(omega + first, count));
    rows.put(GeneralRows::bodies, first, body.m, body.J, body.R.x, body.R.y, body.P.x, body.P.y, body.ww);
  }

  ArticulatedTerms<Lane> articulated;
  TipTerms<Lane> tip;
  PLANAR_CHAIN_WRITTEN_OUT
  for (int j = GeneralArrays::most - 1; j >= 0; --j) {
    if (j < arrays.n)
      generalLinkInwards<ends == Ends::tip, mayHaveForces, hasPrismatic>(arrays, external, rows, j,
                                                                         articulated, tip);
  }

  Moved<Lane> at{vectorOf(external.ground), Lane(turning)};
  Vec2<Lane> tipForce;
  if constexpr (ends != Ends::none) {
    Moved<double> moved;
    const TipTerms<double> ofTip = ends == Ends::tip ? numbersOf(tip) : TipTerms<double>{};
    tipForce = vectorOf(meet(numbersOf(articulated), ofTip, *to.ends, moved));
  }
  PLANAR_CHAIN_WRITTEN_OUT
  for (int j = 0; j < GeneralArrays::most; ++j) {
    if (j >= arrays.n) break;
    generalLinkOutwards<ends == Ends::tip, hasPrismatic>(arrays, rows, j, tipForce, to, at);
  }
}

/// Joints of both kinds only if arrays.displaced is given.
template <Ends ends>
void generalLinks(const GeneralArrays& arrays, const Loads& external, const double* theta,
                  const double* omega, double turning, GeneralResults to) {
  const bool isPlain = ends == Ends::none && !external.F;
  const auto run = arrays.displaced ? runGeneralLinks<ends, true, true>
                   : isPlain        ? runGeneralLinks<ends, false, false>
                                    : runGeneralLinks<ends, true, false>;
  run(arrays, external, theta, omega, turning, to);
}

}  // namespace
}  // namespace planar_chain::simd
