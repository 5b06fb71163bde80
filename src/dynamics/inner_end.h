#pragma once

/// The ends of a chain at a state: what slides, and under which forces; what holds the tip.
///
///     f_i = N_i + d_i·Σ F_j,  j = i … of the slides          N_i: of springs, friction, motors along the
///     rail

#include "effects/coupler.h"
#include "planar_chain/chain.h"
#include "recursion/coupled.h"
#include "recursion/ended.h"

namespace planar_chain {

/// joints, N, F: of all n joints and links; F may be nullptr.
template <class Real>
InnerEnd<Real> innerEndOf(const Chain& chain, const Coupling<Real>* joints, const Real* N,
                          const Vec2<Real>* F) {
  InnerEnd<Real> end;
  end.slides = chain.slides();
  Vec2<Real> sum;
  for (int i = end.slides; i-- > 0;) {
    const Vec2d axis = chain.joints()[index(i)].axis;
    const Vec2<Real> d{Real(axis.x), Real(axis.y)};
    if (F) sum += F[i];
    end.slide[index(i)] = {d, Real(chain.links()[index(i)].mass), N[i] + dot(d, sum), joints[i].isHeld,
                           joints[i].acceleration};
  }
  return end;
}

/// What holds the tip at these couplings, the acceleration less gravity.
inline Tip<double> tipOf(const Chain& chain, const Couplings& couplings) {
  Tip<double> tip = couplings.tip;
  tip.acceleration -= chain.gravity();
  return tip;
}

/// Writes the moments μ of held slides: the forces that hold them, without those that act, N.
template <class Real>
void writeHolding(const InnerEnd<Real>& end, const EndsMotion<Real>& motion, Real* moments) {
  for (std::size_t i = 0; i < index(end.slides); ++i) {
    moments[i] = end.slide[i].isHeld ? motion.force[i] - end.slide[i].force : Real(0);
  }
}

}  // namespace planar_chain
