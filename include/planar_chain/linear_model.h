#pragma once

/// The chain near one state, as control theory writes it. With x = (δq, δq̇) off that state, in relative
/// angles, and δτ more torque in the joints,
///
///     ẋ = A x + B δτ        A = [     0        1   ]        B = [   0   ]
///                               [ ∂q̈/∂q   ∂q̈/∂q̇ ]            [ M_q⁻¹ ]
///
/// where q̈ = M_q⁻¹ f(q, q̇, t). Everything that acts is in it: gravity and offsets, Coriolis terms, springs
/// and dampers, stops that push there (stops.h), loads as they are at time t. A force keeps its direction
/// when its link turns, so its moment changes.
///
/// Found by automatic differentiation: the recursion of articulated.h in dual numbers (dual.h), once for each
/// of the 3 n columns, O(n²) in all. Exact to rounding.

#include <Eigen/Core>

#include "planar_chain/scene.h"

namespace planar_chain {

struct LinearModel {
  Eigen::MatrixXd A;  ///< 2n×2n: rows and columns δq (rad), then δq̇ (rad/s)
  Eigen::MatrixXd B;  ///< 2n×n: columns δτ_i, N m, + on body i and − on body i−1
};

/// t: s; q, qd: relative angles (rad) and rates (rad/s), n each.
/// @throws std::invalid_argument when q or qd is not of size n, or a load names a link or joint that
///   the chain does not have
LinearModel linearModel(const Scene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qd);

}  // namespace planar_chain
