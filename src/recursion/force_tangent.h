#pragma once

/// How the active force and moment on a body change with its position and velocity.
///
/// (x, θ) are the position of the inner pin and the angle of the body, (v, ω) their rates, (F, N) the active
/// force and the moment about the inner pin, all in base axes. Then
///
///     δ(F, N) = −K δ(x, θ) − D δ(v, ω)
///
/// K and D are any 3×3 matrices. A spring from the body to the ground gives K, air drag gives D and, as it
/// depends on the direction of the body, K too.
///
/// A force F that acts at a point at X from the inner pin. X turns with the body, so the point moves by
///
///     δx_X = δx + iX δθ          δv_X = δv + iX δω − ω X δθ
///
/// With F_x = ∂F/∂x_X, F_v = ∂F/∂v_X (2×2) and F_θ = ∂F/∂θ where point and velocity stay,
///
///     δF = F_x δx + F_v δv + (F_x iX − ω F_v X + F_θ) δθ + F_v iX δω
///     δN = iX·δF − X·F δθ                                          N = X×F = iX·F

#include "planar_chain/planar.h"
#include "recursion/linearized.h"

namespace planar_chain {

using Matrix2d = Matrix2<double>;

/// A 3×3 matrix that acts on (x, θ) or (v, ω): rows force, moment.
struct PlaneTangent {
  Matrix2d forceShift;  ///< ∂F/∂x: N/m, or N s/m
  Vec2d forceTurn;      ///< ∂F/∂θ: N/rad, or N s/rad
  Vec2d momentShift;    ///< ∂N/∂x: N, or N s
  double momentTurn{};  ///< ∂N/∂θ: N m/rad, or N m s/rad
};

/// K and D of one body, 0 without forces that change.
struct ForceTangent {
  PlaneTangent K, D;
};

/// A force at a point of a body, base axes.
struct ForceAt {
  Vec2d X;            ///< from the inner pin to the point, m
  Vec2d F;            ///< N
  Matrix2d position;  ///< F_x, N/m
  Matrix2d velocity;  ///< F_v, N s/m
  Vec2d turn;         ///< F_θ, N/rad
};

inline Vec2d operator*(const Matrix2d& M, Vec2d a) {
  return M.times(a, Vec2d{});
}

/// Mᵀ a
template <class Scalar>
Vec2<Scalar> transposedTimes(const Matrix2<Scalar>& M, Vec2<Scalar> a) {
  return {M.xx * a.x + M.yx * a.y, M.xy * a.x + M.yy * a.y};
}

inline Matrix2d& operator-=(Matrix2d& M, const Matrix2d& other) {
  M = {M.xx - other.xx, M.xy - other.xy, M.yx - other.yx, M.yy - other.yy};
  return M;
}

/// Adds a force to the K and D of its body, which turns at ω. K then has the force's X·F, too: it must not be
/// in CoupledState::XF again.
inline void addForce(const ForceAt& force, double omega, ForceTangent& to) {
  const auto& [X, F, position, velocity, turn] = force;
  const Vec2d iX = perp(X);
  const Vec2d byTurn = position * iX - omega * (velocity * X) + turn, byRate = velocity * iX;
  to.K.forceShift -= position;
  to.K.forceTurn -= byTurn;
  to.K.momentShift -= transposedTimes(position, iX);
  to.K.momentTurn -= dot(iX, byTurn) - dot(X, F);
  to.D.forceShift -= velocity;
  to.D.forceTurn -= byRate;
  to.D.momentShift -= transposedTimes(velocity, iX);
  to.D.momentTurn -= dot(iX, byRate);
}

}  // namespace planar_chain
