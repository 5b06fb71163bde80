#pragma once

/// Kane's equations of the chain as matrices, line by line as in the notes.
///
/// Plane motion of pin-connected rigid bodies, after F. Amirouche, Fundamentals of Multibody Dynamics:
/// Theory and Applications. For body i of n, with θ_i = q_1 + … + q_i and ω_i = q̇_1 + … + q̇_i:
///
///     S_i0 = [[c, s], [−s, c]](θ_i)         row of body-i components · S_i0 = row of ground components
///     [ω^i] = Ṡ_i0 S_i0ᵀ = [[0, ω_i], [−ω_i, 0]]
///     S_r^i = [−r_y, r_x],  S_p^i = [−p_y, p_x]                   k̂ × r, k̂ × p as rows
///     T = T_ωq: upper triangle of ones                            [ω_1 … ω_n] = q̇ᵀ T
///     B_ij = S_r^i S_i0 (i = j),  S_p^i S_i0 (i < j),  0 (i > j)
///     C_ij = S_r^i [ω^i] S_i0,    S_p^i [ω^i] S_i0,    0          in the same places
///
///     V_pd = T B                 W_pd = T
///     [v_1x v_1y …] = q̇ᵀ V_pd    [a_1x a_1y …] = q̇ᵀ T C + q̈ᵀ T B
///     A_1 = T C diag(m_1, m_1, m_2, m_2, …)    A_2 = T B diag(m_1, m_1, …)    A_3 = T diag(I)
///     F_in = −q̇ᵀ A_1 − q̈ᵀ A_2    M_in = −q̈ᵀ A_3
///
///     Kane:  V_pd (F + F_in) + W_pd (M + M_in) + τ = 0, that is M_q q̈ = f with
///     f_ext = V_pd F + W_pd M + τ
///     f     = f_ext − V_pd A_1ᵀ q̇
///     M_q   = V_pd A_2ᵀ + W_pd A_3ᵀ + diag(J)                     symmetric, positive definite; J: rotors
///
/// Corrected in the notes: of three bodies, the last block of the velocity matrix is S_r^3 S_30, not S_p^3
/// S_30. The first term of F_in has q̇, not q̈. The superscript 0 of [ω^i] = Ṡ Sᵀ is a dot. M_1, M_2 of the
/// page "Inputs" are moments on bodies, not torques in joints.
///
/// If the base moves, θ_i = φ + q_1 + … + q_i and ω likewise, and f loses the inertia of q̈ = 0: with Ω =
/// (ω_i),
///
///     f = f_ext − V_pd m (Cᵀ Ω + Bᵀ 1 φ̈ + p̈) − W_pd I φ̈
///
/// A prismatic joint i does not turn its body: row i of T is 0. Its partial velocities are its axis d_i,
/// which turns with body i. q_i d_i lengthens the arms of body i, and Coriolis' acceleration is more at all
/// bodies j ≥ i:
///
///     V_pd = T B + D,   D_ij = d_i (i ≤ j), of prismatic joints i          A_2 = V_pd diag(m_1, m_1, …)
///     r^i ← r^i + q_i d^i,   p^i ← p^i + q_i d^i                           p̈ ← p̈ + 2 ω_i q̇_i k̂×d_i
///
/// A held tip has the rows c_j of recursion/tip_constraint.h and the acceleration ẍ_T that they give. With
/// a_tip = J_tip q̈ + a_tip(q̈ = 0), and the forces φ along the rows,
///
///     M_q q̈ = f + J_cᵀ φ          J_c q̈ = c          J_c = (c_j·J_tip),  c = (c_j·(ẍ_T − a_tip(q̈ = 0)))
///
/// They are dense, O(n³), and for long chains less accurate than the recursion that runs
/// (recursion/articulated.h), because cond(M_q) grows like n⁴. They are for reading and for tests.

#include <Eigen/Core>
#include <vector>

#include "planar_chain/scene.h"

namespace planar_chain {

/// The forces, moments and torques on a chain, without those of inertia.
struct ActiveForces {
  Eigen::VectorXd F;    ///< 2n: x_1 y_1 x_2 y_2 …, at the centres of mass, ground components, N
  Eigen::VectorXd M;    ///< n: on the bodies, N m
  Eigen::VectorXd tau;  ///< n: τ_i on body i and −τ_i on body i−1, N m; springs, dampers, stops included

  // Rotors and the motion of the base; none by default.
  Eigen::VectorXd rotors{};  ///< J, kg m²: n, or none
  Vec2d acceleration{};      ///< p̈ of the ground pin, m/s²
  double angle = 0;          ///< φ of the base, rad, with φ̇ and φ̈
  double rate = 0, turning = 0;

  Eigen::MatrixXd tipRows{};  ///< k×2: the rows c_j of a held tip; k = 0: free
  Vec2d tipAcceleration{};    ///< ẍ_T of a held tip, m/s²
};

/// Returns the sum at time t (s) of gravity m g at the centres of mass, loads, springs and dampers
/// −k (q − q0) − d q̇, stops that push (effects/stops.h), friction, and the torques of the drives, with which
/// q̈ of a driven joint is the given one. A force at another point of a body is replaced
/// by the same force at the centre of mass and its moment about it. q, qd: relative angles (rad) and rates
/// (rad/s), n each.
/// @throws std::invalid_argument when q or qd is not of size n, or a load names a link or joint that
///   the chain does not have
ActiveForces activeForces(const Scene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qd);

/// Returns the torques in the joints, N m, that give the accelerations qdd (rad/s², n) in addition to
/// everything else that acts: M_q q̈ − f without drives. If the tip is held they are not unique: these have
/// the smallest Σ τ². Friction opposes the rate, or at rest the acceleration; breakaway does not count, so a
/// joint at rest may stick under these torques. In O(n).
/// @throws std::invalid_argument as activeForces(), and for a qdd that is not of size n
/// @throws Refused for a qdd that moves a held tip
Eigen::VectorXd inverseDynamics(const Scene& scene, double t, const Eigen::VectorXd& q,
                                const Eigen::VectorXd& qd, const Eigen::VectorXd& qdd);

/// Every matrix of the notes at one state. SI units; rows belong to q_i, columns of V_pd, A_1 and A_2
/// to x_1 y_1 x_2 y_2 …
struct Kane {
  Eigen::VectorXd q;                   ///< n, rad, relative
  Eigen::VectorXd qd;                  ///< n, rad/s
  std::vector<Eigen::Matrix2d> S;      ///< n: S_i0
  std::vector<Eigen::Matrix2d> omega;  ///< n: [ω^i], rad/s
  Eigen::MatrixXd T;                   ///< n×n
  Eigen::MatrixXd V_pd;                ///< n×2n, m: ∂v/∂q̇ᵀ
  Eigen::MatrixXd W_pd;                ///< n×n: ∂ω/∂q̇ᵀ
  Eigen::MatrixXd A_1;                 ///< n×2n, kg m/s
  Eigen::MatrixXd A_2;                 ///< n×2n, kg m
  Eigen::MatrixXd A_3;                 ///< n×n, kg m²
  Eigen::VectorXd f_ext;               ///< n, N m
  Eigen::VectorXd f;                   ///< n, N m
  Eigen::MatrixXd M_q;                 ///< n×n, kg m²
  Eigen::VectorXd qdd;                 ///< n, rad/s²: M_q q̈ = f + J_cᵀ φ, by Cholesky's L D Lᵀ
  Eigen::MatrixXd J_c;                 ///< k×n, of a tip that is held; k = 0: free
  Eigen::VectorXd c;                   ///< k, m/s²
  Eigen::VectorXd phi;                 ///< k, N: forces along the rows, of least norm
};

/// @throws std::invalid_argument when q, qd, M or tau is not of size n, or F not of size 2n
Kane kane(const Chain& chain, const Eigen::VectorXd& q, const Eigen::VectorXd& qd,
          const ActiveForces& active);

}  // namespace planar_chain
