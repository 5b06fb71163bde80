#pragma once

/// The ends of a chain at a state: what slides, and under which forces; what holds the tip.
///
///     f_i = N_i + d_i·Σ F_j,  j = i … of the slides     N_i: of springs, friction, motors along the rail
///
/// Where the base turns the rails (rails.h), D of the first pin is a part of the acceleration of the base. A
/// slide of mass m_j has another D: F_j is less by m_j (D_j − D).

#include "dynamics/rails.h"
#include "planar_chain/chain.h"
#include "recursion/coupled.h"
#include "recursion/ended.h"

namespace planar_chain {

/// Sets f_i. N, F: of all n joints and links; F may be nullptr. rails: of a base that turns.
template <class Real>
void setForces(const Real* N, const Vec2<Real>* F, InnerEnd<Real>& end, const Rails<Real>* rails = nullptr) {
  Vec2<Real> sum;
  for (int i = end.slides; i-- > 0;) {
    Slide<Real>& slide = end.slide[index(i)];
    if (F) sum += F[i];
    if (rails) {
      slide.d = rails->d[index(i)];
      sum -= slide.mass * (rails->com[index(i)].drift - rails->first.drift);
    }
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

/// What the base gives a chain with slides.
template <class Real>
struct OfBase {
  Vec2<Real> force;           ///< N
  Real moment{};              ///< about the ground pin, beside that in the first joint that turns, N m
  PerEnd<Vec2<Real>> slides;  ///< the forces that move the slides alone, N
};

/// base: its acceleration less gravity. F: as of setForces().
template <class Real>
OfBase<Real> ofBase(const InnerEnd<Real>& end, const EndsMotion<Real>& motion, Vec2<Real> base,
                    const Vec2<Real>* F, const Rails<Real>& rails) {
  OfBase<Real> to{motion.pinForce, cross(rails.first.place, motion.pinForce), {}};
  for (std::size_t i = 0; i < index(end.slides); ++i) {
    base += motion.acceleration[i] * end.slide[i].d;
    const RailPoint<Real>&own = rails.own[i], &com = rails.com[i];
    const Vec2<Real> inertia = end.slide[i].mass * (base + com.drift);
    to.slides[i] = inertia;
    if (F) to.slides[i] -= F[i];
    to.force += to.slides[i];
    to.moment += cross(own.place, to.slides[i]) + cross(com.place - own.place, inertia);
  }
  return to;
}

}  // namespace planar_chain
