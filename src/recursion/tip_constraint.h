#pragma once

/// The constraint of a held tip: the outer pin of the last body is on a line (one row c_1) or at a point (two
/// rows). The rows are unit vectors at right angles. The force on the tip is λ = Σ φ_i c_i, such that
/// c_i·a_tip has a given value. With C λ + c_t the acceleration of the tip (general.h),
///
///     cᵀ C c φ = given − c·c_t
///
/// Where the chain is stretched between its ends, or a row moves nothing, the matrix loses a rank. Directions
/// whose eigenvalue is less than singularTip of the largest possible one do not act.
///
/// All vectors have ground components. Nothing here allocates or throws.

#include <array>
#include <cmath>
#include <cstddef>

#include "planar_chain/planar.h"

namespace planar_chain {

template <class Real>
struct Tip {
  int rows = 0;
  std::array<Vec2<Real>, 2> row{};  ///< c_i: length 1, at right angles
  Vec2<Real> acceleration{};        ///< that the tip has along the rows, less gravity, m/s²
};

/// A tip at a fixed or moving point.
template <class Real>
Tip<Real> pinnedTip(Vec2<Real> acceleration) {
  return {2, {Vec2<Real>{Real(1), Real(0)}, Vec2<Real>{Real(0), Real(1)}}, acceleration};
}

/// The force on the tip, and the constraint with those directions alone that act.
template <class Real>
struct TipReaction {
  Vec2<Real> force;  ///< λ, N
  Tip<Real> acting;
  Sym2<Real> answer;  ///< C
};

/// Eigenvalues of the tip's answer to forces below this share of the largest one are rounding: along such a
/// direction no force can be told from the motion, and none acts.
constexpr double singularTip = 1e-13;

/// The eigenvectors of a symmetric 2×2 tensor, the larger eigenvalue first.
template <class Real>
struct Eigen2 {
  std::array<Real, 2> value;
  std::array<Vec2<Real>, 2> vector;
};

template <class Real>
Eigen2<Real> eigen(const Sym2<Real>& M) {
  using std::hypot;
  using std::sqrt;
  const Real mean = (M.xx + M.yy) / 2, half = (M.xx - M.yy) / 2, r = hypot(half, M.xy);
  Vec2<Real> v = half >= 0 ? Vec2<Real>{half + r, M.xy} : Vec2<Real>{M.xy, r - half};
  const Real size = sqrt(dot(v, v));
  v = size > 0 ? (1 / size) * v : Vec2<Real>{Real(1), Real(0)};
  return {{mean + r, mean - r}, {v, perp(v)}};
}

/// M⁻¹ b, by elimination of the row with the larger pivot.
template <class Real>
Vec2<Real> solve(const Sym2<Real>& M, Vec2<Real> b) {
  if (M.xx < M.yy) {
    const Vec2<Real> turned = solve<Real>({M.yy, M.xy, M.xx}, {b.y, b.x});
    return {turned.y, turned.x};
  }
  const Real l = M.xy / M.xx, y = (b.y - l * b.x) / (M.yy - l * M.xy);
  return {(b.x - M.xy * y) / M.xx, y};
}

/// The rows of a tip with this C that act.
template <class Real>
Tip<Real> actingPart(const Tip<Real>& tip, const Sym2<Real>& C) {
  // The determinant shows at once that both directions act, unless they nearly do not. Any share far above
  // singularTip will do: below it, eigenvalues decide.
  constexpr double surely = 1e-6;
  const Real trace = C.xx + C.yy, determinant = C.xx * C.yy - C.xy * C.xy;
  if (tip.rows == 2 && determinant > Real(surely) * (trace * trace)) return tip;
  const auto [value, vector] = eigen(C);
  const Real least = Real(singularTip) * value[0];
  if (tip.rows == 2 && value[1] > least) return tip;
  Tip<Real> acting;
  acting.acceleration = tip.acceleration;
  const Vec2<Real> row = tip.rows == 2 ? vector[0] : tip.row[0];
  if (dot(row, C * row) > least) acting.row[static_cast<std::size_t>(acting.rows++)] = row;
  return acting;
}

/// The force on a tip that without it has this acceleration.
template <class Real>
TipReaction<Real> holdTip(const Tip<Real>& tip, const Sym2<Real>& C, Vec2<Real> free) {
  TipReaction<Real> held{{}, actingPart(tip, C), C};
  const Vec2<Real> missing = tip.acceleration - free;
  if (held.acting.rows == 2) {
    held.force = solve(C, missing);
  } else if (held.acting.rows == 1) {
    const Vec2<Real> c = held.acting.row[0];
    held.force = (dot(c, missing) / dot(c, C * c)) * c;
  }
  return held;
}

}  // namespace planar_chain
