#pragma once

/// The matrices of segments for the exact solve, joined two by two in lanes. See linearized_segments.h for
/// the equations and join_kernel.h for the groups.

#include "lanes/join_kernel.h"
#include "lanes/lane_streams.h"

namespace planar_chain::simd {
namespace {

/// 3×3, by rows.
template <class Scalar>
struct Matrix3 {
  Triple<Scalar> x, y, z;
};

template <class Scalar>
inline Scalar dot(const Triple<Scalar>& a, const Triple<Scalar>& b) {
  return mulAdd(a.x, b.x, mulAdd(a.y, b.y, a.z * b.z));
}
template <class Scalar>
inline Triple<Scalar> operator+(const Triple<Scalar>& a, const Triple<Scalar>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Scalar>
inline Triple<Scalar> operator-(const Triple<Scalar>& a, const Triple<Scalar>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Scalar>
inline Triple<Scalar> cross(const Triple<Scalar>& a, const Triple<Scalar>& b) {
  return {mulAdd(a.y, b.z, -a.z * b.y), mulAdd(a.z, b.x, -a.x * b.z), mulAdd(a.x, b.y, -a.y * b.x)};
}

template <class Scalar>
inline Triple<Scalar> operator*(const Matrix3<Scalar>& M, const Triple<Scalar>& a) {
  return {dot(M.x, a), dot(M.y, a), dot(M.z, a)};
}
/// M + A N
template <class Scalar>
inline Matrix3<Scalar> mulAdd(const Matrix3<Scalar>& A, const Matrix3<Scalar>& N, const Matrix3<Scalar>& M) {
  const auto row = [&N](const Triple<Scalar>& a, const Triple<Scalar>& m) {
    return mulAdd(a.x, N.x, mulAdd(a.y, N.y, mulAdd(a.z, N.z, m)));
  };
  return {row(A.x, M.x), row(A.y, M.y), row(A.z, M.z)};
}
template <class Scalar>
inline Matrix3<Scalar> operator*(const Matrix3<Scalar>& A, const Matrix3<Scalar>& N) {
  const auto row = [&N](const Triple<Scalar>& a) { return mulAdd(a.x, N.x, mulAdd(a.y, N.y, a.z * N.z)); };
  return {row(A.x), row(A.y), row(A.z)};
}
template <class Scalar>
inline Matrix3<Scalar> operator-(const Matrix3<Scalar>& A) {
  return {-A.x, -A.y, -A.z};
}

/// (1 + M)⁻¹, by its cofactors.
template <class Scalar>
inline Matrix3<Scalar> inverseOfOnePlus(Matrix3<Scalar> M) {
  const Scalar one = Pack(1);
  M.x.x += one, M.y.y += one, M.z.z += one;
  const Triple<Scalar> yz = cross(M.y, M.z), zx = cross(M.z, M.x), xy = cross(M.x, M.y);
  const Scalar inverse = Pack(1) / dot(M.x, yz);
  return {inverse * Triple<Scalar>{yz.x, zx.x, xy.x}, inverse * Triple<Scalar>{yz.y, zx.y, xy.y},
          inverse * Triple<Scalar>{yz.z, zx.z, xy.z}};
}

/// Changes between the ground's axes and those along d.
struct Axes {
  Vec2p d;

  template <class Scalar>
  Triple<Scalar> fromGround(const Triple<Scalar>& a) const {
    return {mulAdd(d.x, a.x, d.y * a.y), mulAdd(d.x, a.y, -d.y * a.x), a.z};
  }
  template <class Scalar>
  Triple<Scalar> toGround(const Triple<Scalar>& a) const {
    return {mulAdd(d.x, a.x, -d.y * a.y), mulAdd(d.y, a.x, d.x * a.y), a.z};
  }
  /// M for vectors in these axes.
  template <class Scalar>
  Matrix3<Scalar> taking(const Matrix3<Scalar>& M) const {
    return {fromGround(M.x), fromGround(M.y), fromGround(M.z)};
  }
  /// M with results in these axes.
  template <class Scalar>
  Matrix3<Scalar> giving(const Matrix3<Scalar>& M) const {
    return {mulAdd(d.x, M.x, d.y * M.y), mulAdd(d.x, M.y, -d.y * M.x), M.z};
  }
};

// ---- Groups of lanes -------------------------------------------------------------------------------

template <class Scalar, class F>
inline Matrix3<Scalar> mapped(const Matrix3<Scalar>& A, F f) {
  return {mapped(A.x, f), mapped(A.y, f), mapped(A.z, f)};
}

// ---- Two segments ----------------------------------------------------------------------------------

/// K, H, G, C of a segment, with its last link's direction; and y, c for a right-hand side.
template <class Scalar>
struct SegmentTerms {
  Vec2p d;
  Matrix3<Scalar> K, H, G, C;
};
template <class Scalar>
struct SegmentSides {
  Triple<Scalar> y, c;
};

/// Pairs of groups of `size` lanes, and all larger pairs.
template <class Scalar, int size>
struct LinearPairs {
  template <class Quantity>
  static Quantity inner(const Quantity& a) {
    return mapped(a, toInner<size>);
  }
  template <class Quantity>
  static Quantity outer(const Quantity& a) {
    return mapped(a, toOuter<size>);
  }

  /// Returns what all together show.
  static SegmentTerms<Scalar> factor(const SegmentTerms<Scalar>& all, double* kept) {
    if constexpr (size == laneCount) {
      return all;
    } else {
      const Axes axes{inner(all.d)};
      const Matrix3<Scalar> G = inner(all.G), H = inner(all.H), C = inner(all.C);
      const Matrix3<Scalar> outerK = axes.giving(axes.taking(outer(all.K)));
      const Matrix3<Scalar> outerG = axes.giving(outer(all.G));
      const Matrix3<Scalar> outerH = axes.taking(outer(all.H));
      const Matrix3<Scalar> S = inverseOfOnePlus(outerK * C);
      const Matrix3<Scalar> SK = S * outerK, SKH = SK * H, SG = S * outerG;

      SegmentTerms<Scalar> pair;
      pair.d = outer(all.d);
      pair.K = mulAdd(G, SKH, inner(all.K));
      pair.G = G * SG;
      pair.H = outerH * mulAdd(-C, SKH, H);
      pair.C = mulAdd(outerH, C * SG, outer(all.C));
      pair.G = mapped(pair.G, flush);
      pair.H = mapped(pair.H, flush);

      Writer write{kept};
      write(axes.d, S, SK, SKH, SG, G, H, C, outerH);
      return LinearPairs<Scalar, 2 * size>::factor(pair, write.to);
    }
  }

  /// Turns X at the chain's inner joint and Y at its outer one into those of each lane's segment.
  static void solve(const SegmentSides<Scalar>& all, const double* kept, Triple<Scalar>& X,
                    Triple<Scalar>& Y) {
    solve(all, kept, X, Y, [](const SegmentSides<Scalar>&) {});
  }
  /// meet: sets X and Y, given the sides of all together.
  template <class Meet>
  static void solve(const SegmentSides<Scalar>& all, const double* kept, Triple<Scalar>& X, Triple<Scalar>& Y,
                    const Meet& meet) {
    if constexpr (size == laneCount) {
      meet(all);
    } else {
      Axes axes;
      Matrix3<Scalar> S, SK, SKH, SG, G, H, C, outerH;
      Reader read{kept};
      read(axes.d, S, SK, SKH, SG, G, H, C, outerH);
      const Triple<Scalar> c = inner(all.c);
      const Triple<Scalar> k = SK * c + S * axes.fromGround(outer(all.y));
      LinearPairs<Scalar, 2 * size>::solve({inner(all.y) + G * k, outer(all.c) + outerH * (c - C * k)},
                                           read.from, X, Y, meet);

      const Triple<Scalar> between = SKH * X + (k + SG * Y);
      const Triple<Scalar> beyond = axes.toGround(H * X + (c - C * between));
      X = either<size>(X, beyond);
      Y = either<size>(between, Y);
    }
  }
};

}  // namespace
}  // namespace planar_chain::simd
