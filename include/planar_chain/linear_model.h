#pragma once

/// The chain near one state, linearized as in control theory. x = (δq, δq̇) is the deviation from that state,
/// in relative angles, and δτ is additional torque in the joints:
///
///     ẋ = A x + B δτ        A = [     0        1   ]        B = [   0   ]
///                               [ ∂q̈/∂q   ∂q̈/∂q̇ ]            [ M_q⁻¹ ]
///
/// with q̈ = M_q⁻¹ f(q, q̇, t). A and B include everything that acts: gravity, offsets, Coriolis terms,
/// springs, dampers, stops that push in that state, and the loads at time t. A force keeps its direction when
/// its link turns, so its moment changes.
///
/// If the tip is held, ∂q̈/∂τ takes the place of M_q⁻¹: q̈ = M_q⁻¹ (f + J_cᵀ φ), and the rank is that of the
/// motions that are left. Small changes that the tip does not allow are not of this model.
///
/// Method: dual numbers. The recursion (recursion/ended.h) runs in them once for each of the 3 n columns,
/// O(n²) in all. The result is exact to rounding.

#include <Eigen/Core>

#include "planar_chain/scene.h"

namespace planar_chain {

struct LinearModel {
  Eigen::MatrixXd A;  ///< 2n×2n: rows and columns δq (rad), then δq̇ (rad/s)
  Eigen::MatrixXd B;  ///< 2n×n: columns δτ_i, N m, + on body i and − on body i−1
};

/// Returns A and B at time t (s). q, qd: relative angles (rad) and rates (rad/s), n each.
/// @throws std::invalid_argument when q or qd is not of size n, or a load names a link or joint that
///   the chain does not have
LinearModel linearModel(const Scene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qd);

}  // namespace planar_chain
