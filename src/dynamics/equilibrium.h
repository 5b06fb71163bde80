#pragma once

/// Static equilibrium: the minimum of the potential energy that lies downhill of given angles.
///
/// In absolute angles the energy of weights and constant forces is a sum over bodies, and springs and stops
/// couple neighbours only. With w_j the force on body j (weight included), W_j all forces further out, N_j
/// the moments of the effects about the inner pin, and X·F as in linearized.h,
///
///     Γ_j = −∂V/∂θ_j = N_j + iR_j·m_j g + iP_j·W_j
///     κ_j = R_j·m_j g + P_j·W_j + X·F                ∂²V/∂θ² = diag(κ) + springs: tridiagonal
///
/// Newton's step is one sweep of Thomas' algorithm. Where the matrix is not positive definite, negative κ_j
/// move towards |κ_j| until it is. So the step goes downhill, and a line search on V ends where V is
/// stationary. If V falls from there along the softest direction, that is no minimum, and the search goes on.
/// Driven joints keep their angles.
///
/// Forces that depend on the position of their body, of springs to the ground, add Jᵀ K J: J, how the body
/// moves with all angles, K as in force_tangent.h. The matrix is full then.
///
/// A displacement s along d of a body that turns is one more angle, s over the chain's reach. With W all
/// forces on its link and further out, its force is N + d·W, κ of the body is more by S·W, and −id·W couples
/// both. A carriage's force does not depend on where it is. Without a held tip and such springs, carriages
/// come first, one by one:
///
///     k_s δs = N_s + d·Σ (m_j g + F_j)
///
/// A carriage that nothing pushes along an axis without spring stays.

#include <functional>
#include <stdexcept>
#include <vector>

#include "planar_chain/scene.h"

namespace planar_chain {

/// The search ended before it could tell whether there is an equilibrium.
struct SearchGaveUp : std::domain_error {
  using std::domain_error::domain_error;
};

/// The default limit of a search.
inline constexpr int mostSearchSteps = 5000;

/// Returns the relative angles, and the positions, of the equilibrium at time t, rad and m. Friction is
/// ignored; the base stands still where it is at t. q: where the search starts. keepGoing, if given, is
/// called before each step.
/// @throws std::domain_error, with the reason, when the energy has no minimum downhill of q
/// @throws SearchGaveUp when none was found in mostSteps steps, or when keepGoing() returns false
std::vector<double> equilibriumOf(const Scene& scene, double t, const std::vector<double>& q,
                                  int mostSteps = mostSearchSteps,
                                  const std::function<bool()>& keepGoing = nullptr);

}  // namespace planar_chain
