#pragma once

/// The ends of a chain at a state: what slides, and under which forces; what holds the tip.
///
///     f_i = N_i + d_i·Σ F_j,  j = i … of the slides          N_i: of springs, friction, motors along the
///     rail

#include "planar_chain/chain.h"
#include "recursion/coupled.h"
#include "recursion/ended.h"

namespace planar_chain {

/// Sets f_i. N, F: of all n joints and links; F may be nullptr.
template <class Real>
void setForces(const Real* N, const Vec2<Real>* F, InnerEnd<Real>& end) {
  Vec2<Real> sum;
  for (int i = end.slides; i-- > 0;) {
    Slide<Real>& slide = end.slide[index(i)];
    if (F) sum += F[i];
    slide.force = N[i] + dot(slide.d, sum);
  }
}

/// The inner end with these of all n joints, without forces.
template <class Real>
InnerEnd<Real> innerEndOf(const Chain& chain, const Coupling<Real>* joints) {
  InnerEnd<Real> end;
  end.slides = chain.slides();
  for (std::size_t i = 0; i < index(end.slides); ++i) {
    const Vec2d axis = chain.joints()[i].axis;
    end.slide[i] = {{Real(axis.x), Real(axis.y)},
                    Real(chain.links()[i].mass),
                    {},
                    joints[i].isHeld,
                    joints[i].acceleration};
  }
  return end;
}

/// Writes the moments μ of held slides: the forces that hold them, without those that act, N.
template <class Real>
void writeHolding(const InnerEnd<Real>& end, const EndsMotion<Real>& motion, Real* moments) {
  for (std::size_t i = 0; i < index(end.slides); ++i) {
    moments[i] = end.slide[i].isHeld ? motion.force[i] - end.slide[i].force : Real(0);
  }
}

/// The force of the base on the chain. base: its acceleration less gravity. F: as of setForces().
template <class Real>
Vec2<Real> forceOfBase(const InnerEnd<Real>& end, const EndsMotion<Real>& motion, Vec2<Real> base,
                       const Vec2<Real>* F) {
  Vec2<Real> force = motion.pinForce, a = base;
  for (std::size_t i = 0; i < index(end.slides); ++i) {
    a += motion.acceleration[i] * end.slide[i].d;
    force += end.slide[i].mass * a;
    if (F) force -= F[i];
  }
  return force;
}

}  // namespace planar_chain
