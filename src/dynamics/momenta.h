#pragma once

/// What a free chain keeps as long as nothing but gravity acts on it from outside: with the centre of mass C,
/// its velocity V, and the angular momentum L about C,
///
///     C(t + h) = C + h V + h²/2 g          V(t + h) = V + h g          L(t + h) = L
///
/// A step meets this within its error. Then the chain is moved as one rigid body, which is the least motion
/// in the metric of the mass matrix: C and V by what they lack, and by δ = (L − L_is)/J about C, where J is
/// the moment of inertia about C. So the errors of steps do not add up. O(n).
///
/// Source: as closure.h.

#include <vector>

#include "dynamics/mechanism.h"
#include "effects/effects.h"
#include "planar_chain/scene.h"

namespace planar_chain {

/// True if the inner end is free: two slides without mass along x and y, a joint behind them, and nothing in
/// these three; the tip is free too.
bool isFree(const Scene& scene);

/// Only the constructor allocates.
class Momenta {
 public:
  /// Of a free chain. The arguments must outlive this object.
  Momenta(const Mechanism& mechanism, Effects& effects);

  /// Moves the state y at t1 to what follows from the state `before` at t0, unless something acts from
  /// outside. carry: the rounding errors of y. Nothing is switched between t0 and t1.
  void keep(double t0, const double* before, double t1, double* y, double* carry);

 private:
  /// C and V are measured from the first pin.
  struct Values {
    Vec2d C, V;
    double L, J;
  };
  Values of(const double* y);
  bool isActedOn(double t, const double* y);

  const Mechanism& mechanism_;
  Effects& effects_;
  int n_;
  double mass_ = 0;  ///< of the chain, kg
  std::vector<Rotation<double>> e_;
  std::vector<double> torques_;
};

}  // namespace planar_chain
