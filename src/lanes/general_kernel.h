#pragma once

/// The recursion of general.h in lanes; see general_chain.h. The compiler options of the including file
/// choose the CPU.

#include "lanes/lane_kernel.h"
#include "lanes/linear_join.h"
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

// ---- Link by link ------------------------------------------------------------------------------------

/// Rows of numbers, one of each body: the bodies, turned, and their joints.
class GeneralRows {
 public:
  /// The first row of m, J, R; of P, ω²; of joint terms or a reply; of y of the tip.
  static constexpr int bodies = 0, pins = 4, rates = 6, terms = 7, tips = 13;
  static_assert(tips + 2 == GeneralArrays::rows);

  explicit GeneralRows(double* first) : first_(first) {}

  [[gnu::always_inline]] Lane number(int row, std::ptrdiff_t j) const {
    return Lane(first_[row * GeneralArrays::width + j]);
  }
  [[gnu::always_inline]] Vec2<Lane> pair(int row, std::ptrdiff_t j) const {
    return {number(row, j), number(row + 1, j)};
  }
  [[gnu::always_inline]] Turned<Lane> body(std::ptrdiff_t j) const {
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
  /// Of a bare joint.
  [[gnu::always_inline]] Reply<Lane> reply(std::ptrdiff_t j) const {
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

/// Inwards, body by body: takes what a body shows from the rows, and adds what the way out needs.
template <bool holdsTip>
[[gnu::always_inline]] inline void generalLinkInwards(const GeneralArrays& arrays, const Outside& outside,
                                                      const GeneralRows& rows, int j,
                                                      ArticulatedTerms<Lane>& shown, TipTerms<Lane>& tip) {
  const Lane N(outside.N[j]);
  const auto addForce = [&] {
    if (outside.F) shown.b -= vectorOf(outside.F[j]);
  };
  switch (arrays.kinds[j]) {
    case JointKind::bare: {
      const Turned<Lane> body = rows.body(j);
      const Handle<Lane> handle = inwards<false>(body, N, shown.A, shown.b);
      const Reply<Lane> reply = replyOf(handle, body);
      rows.put(GeneralRows::terms, j, reply.UD.x, reply.UD.y, reply.uD);
      if constexpr (holdsTip) {
        tip.addBody(body.P, body.ww);
        const Vec2<Lane> y = tip.eta;
        tip.pass(y, {handle.U, {}, {}, handle.inverseD, {}}, reply.uD);
        tip.eta = {};
        rows.put(GeneralRows::tips, j, (handle.inverseD * y).x, (handle.inverseD * y).y);
      }
      return addForce();
    }
    case JointKind::revolute: {
      const Turned<Lane> body = rows.body(j);
      const auto law = jointAt<Lane>(arrays.joints, j);
      addBody(body, shown);
      addForce();
      const JointTerms<Lane> joint = passRevolute(N, law, shown);
      rows.putJoint(j, joint);
      if constexpr (holdsTip) {
        tip.addBody(body.P, body.ww);
        const Vec2<Lane> y = tip.passRevolute(joint, law);
        rows.put(GeneralRows::tips, j, y.x, y.y);
      }
      return;
    }
    case JointKind::prismatic: {
      const Turned<Lane> body = rows.body(j);
      const auto law = jointAt<Lane>(arrays.joints, j);
      const Displacement<Lane> by = displacementAt(arrays, j);
      addBody(body, shown);
      addForce();
      const JointTerms<Lane> joint = passPrismatic(N, law, by.d, shown);
      rows.putJoint(j, joint);
      stepInwards(by, shown);
      if constexpr (holdsTip) {
        tip.addBody(body.P, body.ww);
        const Vec2<Lane> y = tip.passPrismatic(joint, law, by.d);
        tip.stepInwards(by);
        rows.put(GeneralRows::tips, j, y.x, y.y);
      }
      return;
    }
    case JointKind::carriage: {
      // Nothing inside turns, and nobody asks for the wrench of the base: A and b are enough.
      const Lane m = rows.number(GeneralRows::bodies, j);
      const auto law = jointAt<Lane>(arrays.joints, j);
      const Vec2<Lane> d = vectorOf(arrays.displaced[j].d);
      shown.A.xx += m;
      shown.A.yy += m;
      addForce();
      shown.H = {};
      const JointTerms<Lane> joint = passPrismatic(N, law, d, shown);
      rows.putJoint(j, joint);
      if constexpr (holdsTip) {
        const Vec2<Lane> y = tip.passPrismatic(joint, law, d);
        rows.put(GeneralRows::tips, j, y.x, y.y);
      }
    }
  }
}

/// Outwards, to the outer pin.
template <bool holdsTip>
[[gnu::always_inline]] inline void generalLinkOutwards(const GeneralArrays& arrays, const GeneralRows& rows,
                                                       int j, Vec2<Lane> tipForce, const GeneralResults& to,
                                                       Moved<Lane>& at) {
  const JointKind kind = arrays.kinds[j];
  if (kind == JointKind::bare) {
    Reply<Lane> reply = rows.reply(j);
    if constexpr (holdsTip) reply.uD += dot(rows.pair(GeneralRows::tips, j), tipForce);
    at.alpha = outwards(reply, at.a);
    to.xdd[j] = at.alpha.v;
    to.moments[j] = 0;
    return;
  }
  JointTerms<Lane> joint = rows.joint(j);
  if constexpr (holdsTip) joint.epsilon += dot(rows.pair(GeneralRows::tips, j), tipForce);
  const auto law = jointAt<Lane>(arrays.joints, j);
  Lane qdd;
  if (kind == JointKind::revolute) {
    to.moments[j] = outwardsRevolute(joint, law, at).v;
    qdd = at.alpha;
  } else {
    to.moments[j] = outwardsPrismatic(joint, law, displacementAt(arrays, j), at, qdd).v;
  }
  to.xdd[j] = qdd.v;
  if (kind != JointKind::carriage) toOuterPin(rows.P(j), rows.ww(j), at);
}

enum class Ends { none, wrench, tip };

template <Ends ends>
PLANAR_CHAIN_IN_ONE_PIECE void generalLinks(const GeneralArrays& given, const Outside& acting,
                                            const double* theta, const double* omega, double turning,
                                            GeneralResults to) {
  const GeneralArrays arrays = given;  // what they point to is no part of them
  const Outside outside = acting;
  const GeneralRows rows(arrays.terms);
  for (int first = 0; first < arrays.n; first += laneCount) {
    const int k = first / laneCount, count = arrays.n - first;
    double* e = &outside.e[first].c;
    const Turned<Pack> body =
        turned(linkAt(arrays.links, k), theta ? rotationsOfSome(theta + first, count, e) : loadRotations(e),
               loadSome(omega + first, count));
    rows.put(GeneralRows::bodies, first, body.m, body.J, body.R.x, body.R.y, body.P.x, body.P.y, body.ww);
  }

  ArticulatedTerms<Lane> shown;
  TipTerms<Lane> tip;
  PLANAR_CHAIN_WRITTEN_OUT
  for (int j = GeneralArrays::most - 1; j >= 0; --j) {
    if (j < arrays.n) generalLinkInwards<ends == Ends::tip>(arrays, outside, rows, j, shown, tip);
  }

  Moved<Lane> at{vectorOf(outside.ground), Lane(turning)};
  Vec2<Lane> tipForce;
  if constexpr (ends != Ends::none) {
    Moved<double> moved;
    const TipTerms<double> ofTip = ends == Ends::tip ? numbersOf(tip) : TipTerms<double>{};
    tipForce = vectorOf(meet(numbersOf(shown), ofTip, *to.ends, moved));
  }
  PLANAR_CHAIN_WRITTEN_OUT
  for (int j = 0; j < GeneralArrays::most; ++j) {
    if (j >= arrays.n) break;
    generalLinkOutwards<ends == Ends::tip>(arrays, rows, j, tipForce, to, at);
  }
}

// ---- In segments -------------------------------------------------------------------------------------

struct GeneralSegment {
  Shows<Pack> shows;
  ShowsOfSide<Pack> constant;
};

/// Joints of both kinds, side by side in the lanes. isPrismatic: 1 or 0, and zeros displace a revolute joint.
struct MixedJoint {
  Pack isPrismatic;
  Displacement<Pack> by;

  MixedJoint(const double* displaced, int i) {
    Reader{stepAt<GeneralArrays::displacementQuantities>(const_cast<double*>(displaced), i)}(
        isPrismatic, by.d, by.S, by.gamma);
  }
  [[gnu::always_inline]] Pack either(Pack ofRevolute, Pack ofPrismatic) const {
    return Pack(isPrismatic.v > 0 ? ofPrismatic.v : ofRevolute.v);
  }
  [[gnu::always_inline]] Vec2p either(Vec2p ofRevolute, Vec2p ofPrismatic) const {
    return {either(ofRevolute.x, ofPrismatic.x), either(ofRevolute.y, ofPrismatic.y)};
  }
  [[gnu::always_inline]] JointTerms<Pack> pass(Pack N, const JointNumbers<Pack>& law,
                                               ArticulatedTerms<Pack>& shown) const {
    ArticulatedTerms<Pack> slid = shown;
    const JointTerms<Pack> turns = passRevolute(N, law, shown), slides = passPrismatic(N, law, by.d, slid);
    shown = {{either(shown.A.xx, slid.A.xx), either(shown.A.xy, slid.A.xy), either(shown.A.yy, slid.A.yy)},
             either(shown.b, slid.b),
             either(shown.H, slid.H),
             either(shown.Q, slid.Q),
             either(shown.c, slid.c)};
    planar_chain::stepInwards(by, shown);
    return {either(turns.u, slides.u), either(turns.v, slides.v), either(turns.epsilon, slides.epsilon),
            either(turns.inverseD, slides.inverseD), either(turns.D0, slides.D0)};
  }
};

template <bool hasForces, bool hasPrismatic>
[[gnu::always_inline]] inline GeneralSegment generalInwards(const GeneralArrays& arrays,
                                                            const Outside& outside, const double* omega) {
  const double* e = &outside.e->c;
  const Pack zero;
  const Vec2p d = outerFrames(arrays.links, e, arrays.steps);
  ArticulatedTerms<Pack> shown;
  Triple<Pack> Gx{d.x, -d.y, zero}, Gy{d.y, d.x, zero}, Gm{zero, zero, Pack(1)};  // rows of G
  Matrix3<Pack> C{};
  Triple<Pack> c{};
  for (int i = arrays.steps - 1; i >= 0; --i) {
    const Turned<Pack> body = turned(linkAt(arrays.links, i), readRotation(e, i), read(omega, i));
    const Vec2p P = body.P;
    const JointNumbers<Pack> law = jointAt<Pack>(arrays.joints, i);
    addBody(body, shown);
    if constexpr (hasForces) shown.b -= readVector(&outside.F->x, i);
    Triple<Pack> y = mulAdd(P.x, Gy, mulAdd(-P.y, Gx, Gm));
    c = mulAdd(-body.ww * P.x, Gx, mulAdd(-body.ww * P.y, Gy, c));

    JointTerms<Pack> joint;
    [[maybe_unused]] Triple<Pack> turned{};
    if constexpr (hasPrismatic) {
      const MixedJoint mixed(arrays.displacedInLanes, i);
      joint = mixed.pass(read(outside.N, i), law, shown);
      turned = y;
      const Triple<Pack> along = mulAdd(mixed.by.d.x, Gx, mixed.by.d.y * Gy);
      y = {mixed.either(y.x, along.x), mixed.either(y.y, along.y), mixed.either(y.z, along.z)};
    } else {
      joint = passRevolute(read(outside.N, i), law, shown);
    }
    const Triple<Pack> yD = joint.inverseD * y;
    C.x = mulAdd(y.x, yD, C.x);
    C.y.y = mulAdd(y.y, yD.y, C.y.y);
    C.y.z = mulAdd(y.y, yD.z, C.y.z);
    C.z.z = mulAdd(y.z, yD.z, C.z.z);
    c = mulAdd(mulAdd(joint.inverseD, joint.epsilon, law.acceleration), y, c);
    Gx = mulAdd(-joint.u.x, yD, Gx);
    Gy = mulAdd(-joint.u.y, yD, Gy);
    if constexpr (hasPrismatic) {
      const MixedJoint mixed(arrays.displacedInLanes, i);
      const Triple<Pack> ofRevolute = joint.v * y, ofPrismatic = mulAdd(-joint.v, yD, turned);
      Gm = {mixed.either(ofRevolute.x, ofPrismatic.x), mixed.either(ofRevolute.y, ofPrismatic.y),
            mixed.either(ofRevolute.z, ofPrismatic.z)};
      const auto& [axis, S, gamma] = mixed.by;
      c = mulAdd(gamma.x, Gx, mulAdd(gamma.y, Gy, c));
      Gm = mulAdd(S.x, Gy, mulAdd(-S.y, Gx, Gm));
    } else {
      Gm = joint.v * y;
    }
    if (i % stepsPerFlush == 0) {
      Gx = mapped(Gx, flush);
      Gy = mapped(Gy, flush);
      Gm = mapped(Gm, flush);
    }
    Writer{stepAt<GeneralArrays::termQuantities>(arrays.terms, i)}(joint.u, joint.v, joint.epsilon,
                                                                   joint.inverseD, joint.D0, P, body.ww, y);
  }
  C.y.x = C.x.y;
  C.z.x = C.x.z;
  C.z.y = C.y.z;
  const auto& [A, b, H, Q, moment] = shown;
  const Matrix3<Pack> K{{A.xx, A.xy, H.x}, {A.xy, A.yy, H.y}, {H.x, H.y, Q}};
  const Matrix3<Pack> Gt{{Gx.x, Gy.x, Gm.x}, {Gx.y, Gy.y, Gm.y}, {Gx.z, Gy.z, Gm.z}};
  return {{d, K, Gt, {Gx, Gy, Gm}, C}, {{b.x, b.y, moment}, c}};
}

/// What all segments together show, in ground axes. sides: b, c and c_y.
[[gnu::always_inline]] inline ArticulatedTerms<double> shownBy(const Shows<Pack>& all,
                                                               const ShowsOfSide<Pack>& sides) {
  const auto first = [](const Pack& a) { return a.v[0]; };
  const Matrix3<Pack>& K = all.K;
  return {{first(K.x.x), first(K.x.y), first(K.y.y)},
          {first(sides.y.x), first(sides.y.y)},
          {first(K.x.z), first(K.y.z)},
          first(K.z.z),
          first(sides.y.z)};
}
[[gnu::always_inline]] inline TipTerms<double> tipOf(const Shows<Pack>& all, const ShowsOfSide<Pack>& sides) {
  const auto first = [](const Pack& a) { return a.v[0]; };
  const auto vector = [&](const Vec2p& a) { return Vec2d{first(a.x), first(a.y)}; };
  const Axes axes{all.d};
  // What takes a force in the tip's own axes takes one in ground axes.
  const Matrix3<Pack>& G = all.G;
  const Triple<Pack> Gx = axes.toGround(G.x), Gy = axes.toGround(G.y), eta = axes.toGround(G.z);
  const Triple<Pack> tip = axes.toGround(sides.c);
  const Triple<Pack> Cx = axes.toGround(all.C.x), Cy = axes.toGround(all.C.y);
  const Vec2p x = axes.d, y = perp(axes.d);
  const Vec2p C_x = mulAdd(x.x, Vec2p{Cx.x, Cx.y}, y.x * Vec2p{Cy.x, Cy.y});
  const Vec2p C_y = mulAdd(x.y, Vec2p{Cx.x, Cx.y}, y.y * Vec2p{Cy.x, Cy.y});
  return {vector({Gx.x, Gy.x}),
          vector({Gx.y, Gy.y}),
          vector({eta.x, eta.y}),
          vector({tip.x, tip.y}),
          {first(C_x.x), first(C_x.y), first(C_y.y)}};
}

template <Ends ends, bool hasForces, bool hasPrismatic>
PLANAR_CHAIN_IN_ONE_PIECE void runGeneralSegments(const GeneralArrays& arrays, const Outside& outside,
                                                  const double* omega, double turning, GeneralResults to) {
  const GeneralSegment segment = generalInwards<hasForces, hasPrismatic>(arrays, outside, omega);
  Triple<Pack> X{Pack(outside.ground.x), Pack(outside.ground.y), Pack(turning)}, Y{};
  const Shows<Pack> all = LinearPairs<Pack, 1>::factor(segment.shows, arrays.pairs);
  LinearPairs<Pack, 1>::solve(segment.constant, arrays.pairs, X, Y, [&](const ShowsOfSide<Pack>& sides) {
    if constexpr (ends != Ends::none) {
      Moved<double> moved;
      const TipTerms<double> ofTip = ends == Ends::tip ? tipOf(all, sides) : TipTerms<double>{};
      const Vec2d tipForce = meet(shownBy(all, sides), ofTip, *to.ends, moved);
      X = {Pack(moved.a.x), Pack(moved.a.y), Pack(moved.alpha)};
      Y = Axes{all.d}.fromGround(Triple<Pack>{Pack(-tipForce.x), Pack(-tipForce.y), Pack()});
    }
  });

  Moved<Pack> at{{X.x, X.y}, X.z};
  for (int i = 0; i < arrays.steps; ++i) {
    JointTerms<Pack> joint;
    Vec2p P;
    Pack ww;
    Triple<Pack> y;
    Reader{stepAt<GeneralArrays::termQuantities>(arrays.terms, i)}(joint.u, joint.v, joint.epsilon,
                                                                   joint.inverseD, joint.D0, P, ww, y);
    joint.epsilon -= dot(y, Y);
    const JointNumbers<Pack> law = jointAt<Pack>(arrays.joints, i);
    Pack moment, qdd;
    if constexpr (hasPrismatic) {
      const MixedJoint mixed(arrays.displacedInLanes, i);
      Moved<Pack> slid = at;
      Pack slidQdd;
      const Pack force = outwardsPrismatic(joint, law, mixed.by, slid, slidQdd);
      moment = mixed.either(outwardsRevolute(joint, law, at), force);
      qdd = mixed.either(at.alpha, slidQdd);
      at = {mixed.either(at.a, slid.a), mixed.either(at.alpha, slid.alpha)};
    } else {
      moment = outwardsRevolute(joint, law, at);
      qdd = at.alpha;
    }
    toOuterPin(P, ww, at);
    qdd.store(stepAt<1>(to.xdd, i));
    moment.store(stepAt<1>(to.moments, i));
  }
}

template <Ends ends>
void generalSegments(const GeneralArrays& arrays, const Outside& outside, const double* /*theta*/,
                     const double* omega, double turning, GeneralResults to) {
  const auto run =
      arrays.displacedInLanes
          ? (outside.F ? runGeneralSegments<ends, true, true> : runGeneralSegments<ends, false, true>)
          : (outside.F ? runGeneralSegments<ends, true, false> : runGeneralSegments<ends, false, false>);
  run(arrays, outside, omega, turning, to);
}

}  // namespace
}  // namespace planar_chain::simd
