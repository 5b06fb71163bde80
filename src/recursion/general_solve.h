#pragma once

#include "planar_chain/planar.h"

namespace planar_chain {

/// The solve, as the stiff methods see it. Only constructors allocate.
template <class Scalar>
class GeneralSolve {
 public:
  virtual ~GeneralSolve() = default;
  /// Factors s·1 − J.
  virtual void factor(Scalar s) = 0;
  /// [u; v] = (s·1 − J)⁻¹ [ρ_q; ρ_v]; n values each, and the results may stand in the same place.
  virtual void solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v) = 0;

  // The changes along the last solution: of the moment or force in prescribed joint i, of the force of the
  // base and its moment about the ground pin, and of the force on the tip.
  virtual Scalar moment(int i) const = 0;
  virtual Vec2<Scalar> baseForce() const = 0;
  virtual Scalar baseMoment() const = 0;
  virtual Vec2<Scalar> tipForce() const = 0;
};

}  // namespace planar_chain
