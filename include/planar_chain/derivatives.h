#pragma once

/// Derivatives of a motion: how the state x = (q, q̇) at a time changes with that at an earlier time, with
/// torques in the joints that are held from there on, and with numbers of the scene. They solve
///
///     δẋ = J δx + f_τ δτ + f_p δp
///
/// along the motion, J = ∂f/∂x. Where f jumps at a switch, such as a contact or a joint that comes to rest,
/// the time of the switch changes too: with g = 0 there, f⁻ before and f⁺ behind,
///
///     δx⁺ = δx⁻ + (f⁻ − f⁺) δt          δt = −(∇g·δx⁻ + g_p δp)/ġ⁻
///
/// Source: P. Müller, Calculation of Lyapunov exponents for dynamic systems with discontinuities, Chaos,
/// Solitons and Fractals 5 (1995) 1671–1681.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "planar_chain/scene.h"

namespace planar_chain {

class Value;

/// Derivatives of x = (q, q̇): 2n rows, rad (m) and then rad/s (m/s). With motors, the k torques in their
/// lags, N m, are states behind these, in chain order: T ẋ = u − x (linear_motor.h).
struct Derivatives {
  Eigen::MatrixXd state;    ///< 2n×2n, with motors (2n+k)×(2n+k): by the state at the start
  Eigen::MatrixXd torques;  ///< 2n×n, with motors (2n+k)×n: by torques that are held since, N m
  Eigen::MatrixXd numbers;  ///< 2n rows, a column for each number of the scene
  /// What a user should know: lags and dead times that a product of such derivatives leaves out; joints at
  /// rest with friction, by whose rates the derivatives have one side.
  std::vector<std::string> notes{};
};

/// The scene with a number near its value: what the number does is found by differences of sixth order.
struct VariedNumber {
  std::string path;
  double size;  ///< |number|; 1 if it is 0
  std::vector<Scene> scenes;
  std::vector<double> weights;  ///< of the scenes in the difference, one over the number's unit
};

/// Returns the scenes near this one in the number at a path that requireNumbers() accepts. Allocates.
/// @throws Refused if the scene does not have it, or has no value beside it
VariedNumber variedNumber(const Value& scene, const std::string& path);

}  // namespace planar_chain
