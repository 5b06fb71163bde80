#pragma once

/// The two ends of a chain: what the first pin sits on, and what holds the tip.
///
/// Inner end. None, one or two slides, each of mass m_i on a rail of direction d_i. The first rail is fixed
/// to the base, the second one to the first slide, and the chain hangs on the last slide:
///
///     no slide      the pin is fixed to the base
///     one           a carriage; its mass may be 0
///     two           a table that moves in x and y; with masses of 0: a free end
///
/// f_i is the force along rail i on its slide: of a motor, friction, spring. A slide is held if its
/// acceleration s̈_i is given: driven, or stuck by friction; then f_i comes out. Rails turn with the base.
///
/// Tip. The outer pin of the last body is free, on a line (one row c_1) or pinned (two rows). The rows are
/// unit vectors at right angles. The force on the tip is λ = Σ φ_i c_i, such that c_i·a_tip has a given
/// value.
///
/// All vectors have base axes.

#include <array>
#include <cmath>

#include "planar_chain/chain.h"
#include "planar_chain/planar.h"

namespace planar_chain {

/// Numbers per slide, or per row of the tip.
template <class Value>
using PerEnd = std::array<Value, 2>;

template <class Real>
struct Slide {
  Vec2<Real> d{Real(1), Real(0)};  ///< direction of the rail, length 1
  Real mass{};                     ///< m, kg
  Real force{};                    ///< f, N, if it is not held
  bool isHeld = false;             ///< driven or stuck: s̈ is given
  Real acceleration{};             ///< s̈ if it is held, m/s²
};

/// The inner end. The first slide is next to the base. Two rails are not parallel.
template <class Real>
struct InnerEnd {
  int slides = 0;
  PerEnd<Slide<Real>> slide{};
};

template <class Real>
struct Tip {
  int rows = 0;
  PerEnd<Vec2<Real>> row{};   ///< c_i: length 1, at right angles
  Vec2<Real> acceleration{};  ///< that the tip has along the rows, less gravity, m/s²
};

/// A tip at a fixed or moving point.
template <class Real>
Tip<Real> pinnedTip(Vec2<Real> acceleration) {
  return {2, {Vec2<Real>{Real(1), Real(0)}, Vec2<Real>{Real(0), Real(1)}}, acceleration};
}

/// Eigenvalues of the tip's answer to forces below this share of the largest one are rounding: along such a
/// direction no force can be told from the motion, and none acts.
constexpr double singularTip = 1e-13;

/// The eigenvectors of a symmetric 2×2 tensor, the larger eigenvalue first.
template <class Real>
struct Eigen2 {
  PerEnd<Real> value;
  PerEnd<Vec2<Real>> vector;
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

}  // namespace planar_chain
