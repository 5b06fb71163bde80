#pragma once

/// The recursion of general.h body by body, with any numbers. Simulations run lanes/general_chain.h.

#include <cstddef>
#include <vector>

#include "planar_chain/chain.h"
#include "recursion/general.h"
#include "recursion/tip_constraint.h"

namespace planar_chain {

/// The bodies of a chain at a state: n values each.
template <class Real>
struct BodyMotion {
  const Rotation<Real>* e;              ///< exp(i θ_j) of the bodies' angles, ground
  const Real* omega;                    ///< their rates, rad/s, against the ground
  const Displacement<Real>* displaced;  ///< of prismatic joints; not read for others
};

/// The loads on a chain, n values each.
template <class Real>
struct GeneralLoads {
  const Real* N;        ///< moments, N m, and forces of prismatic joints, N (general.h)
  const Vec2<Real>* F;  ///< forces without gravity, N, at the bodies' own points; nullptr: none
  const JointLaw<Real>* joints;
  Vec2<Real> base;     ///< acceleration of the base's pin less gravity, m/s²
  Real baseTurning{};  ///< angular acceleration of the base, rad/s²
};

/// The wrench of the base on a chain, and the force that holds its tip.
template <class Real>
struct EndForces {
  Vec2<Real> baseForce;  ///< N
  Real baseMoment{};     ///< about the ground pin, without the N of the first joints, N m
  TipReaction<Real> tip;
};

/// The wrench of the base on a chain that shows this.
template <class Real>
void setWrench(const ArticulatedTerms<Real>& articulated, const Moved<Real>& base, EndForces<Real>& to) {
  to.baseForce = articulated.A * base.a + base.alpha * articulated.H + articulated.b;
  to.baseMoment = dot(articulated.H, base.a) + articulated.Q * base.alpha + articulated.c;
}

template <class Real>
void holdTip(const TipTerms<Real>& ofTip, const Moved<Real>& base, const Tip<Real>& tip,
             EndForces<Real>& to) {
  to.tip = holdTip(tip, ofTip.C, ofTip.transposed(base.a) + base.alpha * ofTip.eta + ofTip.c);
  to.baseForce -= ofTip.times(to.tip.force);
  to.baseMoment -= dot(ofTip.eta, to.tip.force);
}

template <class Real = double>
class GeneralRecursion {
 public:
  explicit GeneralRecursion(const Chain& chain) : bodies_(index(chain.size())) {
    for (std::size_t j = 0; j < bodies_.size(); ++j) {
      const Link& link = chain.links()[j];
      bodies_[j].isPrismatic = chain.joints()[j].isPrismatic;
      bodies_[j].of = {Real(link.mass),
                       Real(link.inertia),
                       {Real(link.com.x), Real(link.com.y)},
                       {Real(link.pin.x), Real(link.pin.y)}};
    }
  }

  /// Writes the accelerations of the coordinates, rad/s² against the ground or m/s², and μ of the joints. n
  /// values each. Allocates nothing.
  EndForces<Real> accelerations(const BodyMotion<Real>& at, const GeneralLoads<Real>& acting,
                                const Tip<Real>& tip, Real* xdd, Real* moments) {
    ArticulatedTerms<Real> articulated;
    TipTerms<Real> ofTip;
    for (std::size_t j = bodies_.size(); j-- > 0;) inwards(j, at, acting, tip.rows > 0, articulated, ofTip);
    Moved<Real> moved{acting.base, acting.baseTurning};
    EndForces<Real> ends;
    setWrench(articulated, moved, ends);
    if (tip.rows > 0) holdTip(ofTip, moved, tip, ends);
    for (std::size_t j = 0; j < bodies_.size(); ++j) {
      Swept& body = bodies_[j];
      if (tip.rows > 0) body.terms.epsilon += dot(body.y, ends.tip.force);
      if (body.isPrismatic) {
        moments[j] = outwardsPrismatic(body.terms, body.law, at.displaced[j], moved, xdd[j]);
      } else {
        moments[j] = outwardsRevolute(body.terms, body.law, moved);
        xdd[j] = moved.alpha;
      }
      toOuterPin(body.at.P, body.at.ww, moved);
    }
    return ends;
  }

 private:
  struct Swept {
    bool isPrismatic;
    Body<Real> of;
    BodyPose<Real> at;
    JointNumbers<Real> law;
    JointTerms<Real> terms;
    Vec2<Real> y;
  };

  void inwards(std::size_t j, const BodyMotion<Real>& at, const GeneralLoads<Real>& acting, bool holdsTip,
               ArticulatedTerms<Real>& articulated, TipTerms<Real>& ofTip) {
    Swept& body = bodies_[j];
    body.at = bodyPose(body.of, at.e[j], at.omega[j]);
    body.law = numbersOf(acting.joints[j]);
    addBody(body.at, articulated);
    if (acting.F) articulated.b -= acting.F[j];
    if (holdsTip) ofTip.addBody(body.at.P, body.at.ww);
    if (body.isPrismatic) {
      const Displacement<Real>& by = at.displaced[j];
      body.terms = passPrismatic(acting.N[j], body.law, by.d, articulated);
      stepInwards(by, articulated);
      if (!holdsTip) return;
      body.y = ofTip.passPrismatic(body.terms, body.law, by.d);
      ofTip.stepInwards(by);
    } else {
      body.terms = passRevolute(acting.N[j], body.law, articulated);
      if (holdsTip) body.y = ofTip.passRevolute(body.terms, body.law);
    }
    if (!holdsTip) return;
    // Along a long crooked chain G shrinks exponentially. Denormal numbers, below 1e-308, would be slow.
    constexpr double small = 1e-280;
    for (Vec2<Real>* column : {&ofTip.Gx, &ofTip.Gy}) {
      if (dot(*column, *column) < Real(small)) *column = {};
    }
  }

  std::vector<Swept> bodies_;
};

}  // namespace planar_chain
