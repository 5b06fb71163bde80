#pragma once

/// The recursion of general.h for segments side by side; see general_chain.h. The compiler options of the
/// including file choose the CPU.

#include "lanes/general_link_kernel.h"
#include "lanes/linear_join.h"

namespace planar_chain::simd {
namespace {

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
  [[gnu::always_inline]] Triple<Pack> either(const Triple<Pack>& ofRevolute,
                                             const Triple<Pack>& ofPrismatic) const {
    return {either(ofRevolute.x, ofPrismatic.x), either(ofRevolute.y, ofPrismatic.y),
            either(ofRevolute.z, ofPrismatic.z)};
  }
  [[gnu::always_inline]] JointTerms<Pack> pass(Pack N, const JointNumbers<Pack>& law,
                                               ArticulatedTerms<Pack>& articulated) const {
    ArticulatedTerms<Pack> ifPrismatic = articulated;
    const JointTerms<Pack> revolute = passRevolute(N, law, articulated),
                           prismatic = passPrismatic(N, law, by.d, ifPrismatic);
    articulated = {{either(articulated.A.xx, ifPrismatic.A.xx), either(articulated.A.xy, ifPrismatic.A.xy),
                    either(articulated.A.yy, ifPrismatic.A.yy)},
                   either(articulated.b, ifPrismatic.b),
                   either(articulated.H, ifPrismatic.H),
                   either(articulated.Q, ifPrismatic.Q),
                   either(articulated.c, ifPrismatic.c)};
    planar_chain::stepInwards(by, articulated);
    return {either(revolute.u, prismatic.u), either(revolute.v, prismatic.v),
            either(revolute.epsilon, prismatic.epsilon), either(revolute.inverseD, prismatic.inverseD),
            either(revolute.D0, prismatic.D0)};
  }
};

/// The effect of a force and a moment in the outer end of a segment: TipTerms with three columns.
struct OuterTerms {
  Triple<Pack> Gx, Gy, Gm;  ///< rows of G
  Matrix3<Pack> C{};
  Triple<Pack> c{};

  /// d: of the outer end.
  explicit OuterTerms(Vec2p d) : Gx{d.x, -d.y, Pack()}, Gy{d.y, d.x, Pack()}, Gm{Pack(), Pack(), Pack(1)} {}

  [[gnu::always_inline]] void addBody(Vec2p P, Pack ww) {
    Gm = mulAdd(P.x, Gy, mulAdd(-P.y, Gx, Gm));
    c = mulAdd(-ww * P.x, Gx, mulAdd(-ww * P.y, Gy, c));
  }
  /// Through a joint with this y. Returns y/D.
  [[gnu::always_inline]] Triple<Pack> pass(const Triple<Pack>& y, const JointTerms<Pack>& joint,
                                           const JointNumbers<Pack>& law) {
    const Triple<Pack> yD = joint.inverseD * y;
    C.x = mulAdd(y.x, yD, C.x);
    C.y.y = mulAdd(y.y, yD.y, C.y.y);
    C.y.z = mulAdd(y.y, yD.z, C.y.z);
    C.z.z = mulAdd(y.z, yD.z, C.z.z);
    c = mulAdd(mulAdd(joint.inverseD, joint.epsilon, law.acceleration), y, c);
    Gx = mulAdd(-joint.u.x, yD, Gx);
    Gy = mulAdd(-joint.u.y, yD, Gy);
    return yD;
  }
  [[gnu::always_inline]] void pass(const MixedJoint& mixed, const Triple<Pack>& y,
                                   const JointTerms<Pack>& joint, const JointNumbers<Pack>& law) {
    const Triple<Pack> yD = pass(y, joint, law);
    Gm = mixed.either(joint.v * y, mulAdd(-joint.v, yD, Gm));
    const auto& [axis, S, gamma] = mixed.by;
    c = mulAdd(gamma.x, Gx, mulAdd(gamma.y, Gy, c));
    Gm = mulAdd(S.x, Gy, mulAdd(-S.y, Gx, Gm));
  }
  /// Along a long crooked chain G shrinks exponentially.
  [[gnu::always_inline]] void flushSmall() {
    for (Triple<Pack>* row : {&Gx, &Gy, &Gm}) *row = mapped(*row, flush);
  }
};

struct GeneralSegment {
  SegmentTerms<Pack> segmentTerms;
  SegmentSides<Pack> constant;

  GeneralSegment(Vec2p d, const ArticulatedTerms<Pack>& articulated, const OuterTerms& outer)
      : segmentTerms{d, {}, {}, {outer.Gx, outer.Gy, outer.Gm}, outer.C},
        constant{{articulated.b.x, articulated.b.y, articulated.c}, outer.c} {
    const auto& [A, b, H, Q, c] = articulated;
    const auto& [Gx, Gy, Gm] = segmentTerms.G;
    segmentTerms.K = {{A.xx, A.xy, H.x}, {A.xy, A.yy, H.y}, {H.x, H.y, Q}};
    segmentTerms.H = {{Gx.x, Gy.x, Gm.x}, {Gx.y, Gy.y, Gm.y}, {Gx.z, Gy.z, Gm.z}};
    segmentTerms.C.y.x = outer.C.x.y;
    segmentTerms.C.z.x = outer.C.x.z;
    segmentTerms.C.z.y = outer.C.y.z;
  }

  /// Returns the moment that each segment would get from the next one if nothing but the pin between turned,
  /// Q' c_α/(1 + Q' C_αα), and takes it into b, c and c_y: the rest of the moment is unknown. Without it, a
  /// light last body turns fast in c_y, and if the next segment is heavy and begins with a prismatic joint,
  /// nearly all of that cancels in the join. Behind a bare revolute joint Q' is 0.
  [[gnu::always_inline]] Pack expectMoments() {
    const Pack Q = shuffled(segmentTerms.K.z.z, Pack(), [](int s) { return s + 1; });
    const Pack moment = Q * constant.c.z / mulAdd(Q, segmentTerms.C.z.z, Pack(1));
    constant.c = mulAdd(-moment, segmentTerms.C.z, constant.c);
    constant.y = mulAdd(moment, segmentTerms.H.z, constant.y);
    constant.y.z -= shuffled(Pack(), moment, [](int s) { return laneCount - 1 + s; });
    return moment;
  }
};

template <bool hasForces, bool hasPrismatic>
[[gnu::always_inline]] inline GeneralSegment generalInwards(const GeneralArrays& arrays,
                                                            const Loads& external, const double* omega) {
  const double* e = &external.e->c;
  const Vec2p d = outerFrames(arrays.links, e, arrays.steps);
  ArticulatedTerms<Pack> articulated;
  OuterTerms outer(d);
  for (int i = arrays.steps - 1; i >= 0; --i) {
    const BodyPose<Pack> body = bodyPose(linkAt(arrays.links, i), readRotation(e, i), read(omega, i));
    const JointNumbers<Pack> law = jointAt<Pack>(arrays.joints, i);
    const Pack N = read(external.N, i);
    addBody(body, articulated);
    if constexpr (hasForces) articulated.b -= readVector(&external.F->x, i);

    JointTerms<Pack> joint;
    Triple<Pack> y;
    if constexpr (hasPrismatic) {
      const MixedJoint mixed(arrays.displacedInLanes, i);
      joint = mixed.pass(N, law, articulated);
      outer.addBody(body.P, body.ww);
      y = mixed.either(outer.Gm, mulAdd(mixed.by.d.x, outer.Gx, mixed.by.d.y * outer.Gy));
      outer.pass(mixed, y, joint, law);
    } else {
      joint = passRevolute(N, law, articulated);
      outer.addBody(body.P, body.ww);  // after the joint: more of the numbers stay in registers
      y = outer.Gm;
      outer.pass(y, joint, law);
      outer.Gm = joint.v * y;
    }
    if (i % stepsPerFlush == 0) outer.flushSmall();
    Writer{stepAt<GeneralArrays::termQuantities>(arrays.terms, i)}(
        joint.u, joint.v, joint.epsilon, joint.inverseD, joint.D0, body.P, body.ww, y);
  }
  return {d, articulated, outer};
}

/// The articulated terms of all segments together, in ground axes. sides: b, c and c_y.
[[gnu::always_inline]] inline ArticulatedTerms<double> articulatedTermsOf(const SegmentTerms<Pack>& all,
                                                                          const SegmentSides<Pack>& sides) {
  const auto first = [](const Pack& a) { return a.v[0]; };
  const Matrix3<Pack>& K = all.K;
  return {{first(K.x.x), first(K.x.y), first(K.y.y)},
          {first(sides.y.x), first(sides.y.y)},
          {first(K.x.z), first(K.y.z)},
          first(K.z.z),
          first(sides.y.z)};
}
[[gnu::always_inline]] inline TipTerms<double> tipOf(const SegmentTerms<Pack>& all,
                                                     const SegmentSides<Pack>& sides) {
  const auto first = [](const Pack& a) { return a.v[0]; };
  const auto vector = [&](const Vec2p& a) { return Vec2d{first(a.x), first(a.y)}; };
  const Axes axes{all.d};
  // Turn the terms of the tip's force from its own axes to ground axes.
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
PLANAR_CHAIN_IN_ONE_PIECE void runGeneralSegments(const GeneralArrays& arrays, const Loads& external,
                                                  const double* omega, double turning, GeneralResults to) {
  GeneralSegment segment = generalInwards<hasForces, hasPrismatic>(arrays, external, omega);
  Pack expected;
  if constexpr (hasPrismatic) expected = segment.expectMoments();
  Triple<Pack> X{Pack(external.ground.x), Pack(external.ground.y), Pack(turning)}, Y{};
  const SegmentTerms<Pack> all = LinearPairs<Pack, 1>::factor(segment.segmentTerms, arrays.pairs);
  LinearPairs<Pack, 1>::solve(segment.constant, arrays.pairs, X, Y, [&](const SegmentSides<Pack>& sides) {
    if constexpr (ends != Ends::none) {
      Moved<double> moved;
      const TipTerms<double> ofTip = ends == Ends::tip ? tipOf(all, sides) : TipTerms<double>{};
      const Vec2d tipForce = meet(articulatedTermsOf(all, sides), ofTip, *to.ends, moved);
      X = {Pack(moved.a.x), Pack(moved.a.y), Pack(moved.alpha)};
      Y = Axes{all.d}.fromGround(Triple<Pack>{Pack(-tipForce.x), Pack(-tipForce.y), Pack()});
    }
  });
  if constexpr (hasPrismatic) Y.z += expected;

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
      Moved<Pack> moved = at;
      Pack prismaticQdd;
      const Pack force = outwardsPrismatic(joint, law, mixed.by, moved, prismaticQdd);
      moment = mixed.either(outwardsRevolute(joint, law, at), force);
      qdd = mixed.either(at.alpha, prismaticQdd);
      at = {mixed.either(at.a, moved.a), mixed.either(at.alpha, moved.alpha)};
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
void generalSegments(const GeneralArrays& arrays, const Loads& external, const double* /*theta*/,
                     const double* omega, double turning, GeneralResults to) {
  const auto run =
      arrays.displacedInLanes
          ? (external.F ? runGeneralSegments<ends, true, true> : runGeneralSegments<ends, false, true>)
          : (external.F ? runGeneralSegments<ends, true, false> : runGeneralSegments<ends, false, false>);
  run(arrays, external, omega, turning, to);
}

}  // namespace
}  // namespace planar_chain::simd
