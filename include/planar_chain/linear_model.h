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
/// A and B depend on the torques at that state: M_q⁻¹ τ changes with q. So a controller of a pose that
/// torques hold needs those torques here.
///
/// Method: dual numbers. The recursion (recursion/general.h) runs in them once for each of the 3 n columns,
/// O(n²) in all. The result is exact to rounding.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "planar_chain/linear_motor.h"
#include "planar_chain/scene.h"

namespace planar_chain {

/// What the chain is linearized about, beside its state.
struct OperatingPoint {
  /// Torques in the joints beside all that acts, N m, n numbers; 0 in driven joints. Nothing: 0.
  std::optional<Eigen::VectorXd> tau{};
  /// Takes the torques that make q̈ = 0 in place of tau.
  bool isHeld = false;
  /// A joint at rest counts as one that slips, without friction. Otherwise it may stick, and its column of B
  /// is 0.
  bool slips = false;
  /// Nothing: δτ are torques that act. Otherwise they are commanded torques, and those of these joints go
  /// through motors. The torques that lag, N m, are states behind (δq, δq̇), in this order.
  std::optional<std::vector<LinearMotor>> motors{};
  /// Takes in place of `motors` those of the scene, to which these torques have been commanded for long.
  bool hasSteadyMotors = false;
};

struct LinearModel {
  Eigen::MatrixXd A;    ///< 2n×2n, and more with motors: rows and columns δq (rad), then δq̇ (rad/s)
  Eigen::MatrixXd B;    ///< 2n×n: columns δτ_i, N m, + on body i and − on body i−1
  Eigen::VectorXd tau;  ///< n: the torques of OperatingPoint
  Eigen::VectorXd qdd;  ///< n: q̈ under them
  /// What a user should know: joints that stick; q̈ that is not 0 at rest, and the torques that make it 0;
  /// torques beyond effort limits; motors and dead times, which are left out.
  std::vector<std::string> notes{};
};

/// Returns A and B at time t (s). q, qd: relative angles (rad) and rates (rad/s), n each.
/// @throws std::invalid_argument when q or qd is not of size n, or a load names a link or joint that
///   the chain does not have
/// @throws Refused for a tau that is not of size n, not finite, or not 0 in a driven joint; and if no torques
///   hold the state, as its tip is held and moves
LinearModel linearModel(const Scene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qd,
                        const OperatingPoint& about = {});

}  // namespace planar_chain
