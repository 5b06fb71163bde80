#pragma once

/// Segments joined two by two in lanes. See segments.h for the equations. All lanes of a group of neighbours
/// hold the matrices of the group, so each round joins all pairs of groups at once.

#include "planar_chain/planar.h"
#include "simd/pack.h"

namespace planar_chain::simd {
namespace {

// ---- Two segments ----------------------------------------------------------------------------------

/// 2×2, by rows.
struct Square {
  Vec2p x, y;
};

inline Vec2p operator*(const Square& M, Vec2p a) {
  return {dot(M.x, a), dot(M.y, a)};
}
inline Vec2p transposedTimes(const Square& M, Vec2p a) {
  return mulAdd(a.x, M.x, a.y * M.y);
}
inline Square operator*(const Square& M, const Square& N) {
  return {transposedTimes(N, M.x), transposedTimes(N, M.y)};
}
inline Square operator*(const Square& M, const Sym2<Pack>& A) {
  return {A * M.x, A * M.y};
}
inline Square operator*(const Sym2<Pack>& A, const Square& M) {
  return {mulAdd(A.xx, M.x, A.xy * M.y), mulAdd(A.xy, M.x, A.yy * M.y)};
}

inline Square transposed(const Square& M) {
  return {{M.x.x, M.y.x}, {M.x.y, M.y.y}};
}
/// A + M Nᵀ, which is symmetric.
inline Sym2<Pack> plusSymmetric(const Sym2<Pack>& A, const Square& M, const Square& N) {
  return {mulAdd(M.x.x, N.x.x, mulAdd(M.x.y, N.x.y, A.xx)), mulAdd(M.x.x, N.y.x, mulAdd(M.x.y, N.y.y, A.xy)),
          mulAdd(M.y.x, N.y.x, mulAdd(M.y.y, N.y.y, A.yy))};
}

/// The matrices of a segment or a group, with the direction d of its last link.
struct SegmentMatrices {
  Vec2p d;
  Sym2<Pack> A, C;
  Vec2p b, c;
  Square G;
};

template <int size>
constexpr auto toInner = [](Pack a) { return ofInner<size>(a); };
template <int size>
constexpr auto toOuter = [](Pack a) { return ofOuter<size>(a); };
constexpr auto flush = [](Pack a) { return flushed(a); };

/// f of each number.
template <int count, class F>
inline PackOf<count> mapped(PackOf<count> a, F f) {
  return f(a);
}
template <class Scalar, class F>
inline Vec2<Scalar> mapped(Vec2<Scalar> a, F f) {
  return {mapped(a.x, f), mapped(a.y, f)};
}
template <class F>
inline Sym2<Pack> mapped(const Sym2<Pack>& A, F f) {
  return {f(A.xx), f(A.xy), f(A.yy)};
}
template <class F>
inline Square mapped(const Square& A, F f) {
  return {mapped(A.x, f), mapped(A.y, f)};
}

// ---- Quantities in memory ---------------------------------------------------------------------------

template <class Quantity>
constexpr int doubles = sizeof(Quantity) / sizeof(double);

/// Stores quantities one after the other.
struct Writer {
  double* to;

  template <class... Quantities>
  [[gnu::always_inline]] void operator()(const Quantities&... quantities) {
    const auto write = [this](auto a) {
      a.store(to);
      to += doubles<decltype(a)>;
      return a;
    };
    (mapped(quantities, write), ...);
  }
};

/// Loads them.
struct Reader {
  const double* from;

  template <class... Quantities>
  [[gnu::always_inline]] void operator()(Quantities&... quantities) {
    const auto read = [this](auto a) {
      a = decltype(a)::load(from);
      from += doubles<decltype(a)>;
      return a;
    };
    ((quantities = mapped(quantities, read)), ...);
  }
};

// ---- Pairs of segments -----------------------------------------------------------------------------

/// Pack by pack.
template <int size, class Quantity>
[[gnu::always_inline]] inline Quantity either(const Quantity& inner, const Quantity& outer) {
  Pack numbers[sizeof(Quantity) / sizeof(Pack)];
  int i = 0;
  mapped(inner, [&](Pack a) { return numbers[i++] = a; });
  i = 0;
  return mapped(outer, [&](Pack a) { return either<size>(numbers[i++], a); });
}

template <int size>
class JoinedPair;

/// All lanes are joined.
template <>
class JoinedPair<0> {};

/// A joined pair of groups of `size` lanes, and all larger pairs: what the way out needs of them.
template <int size>
class JoinedPair {
 public:
  explicit JoinedPair(const SegmentMatrices& all) {
    const auto inner = [](const auto& a) { return mapped(a, toInner<size>); };
    const auto outer = [](const auto& a) { return mapped(a, toOuter<size>); };
    d_ = inner(all.d);
    G_ = inner(all.G);
    C_ = inner(all.C);
    c_ = inner(all.c);
    SegmentMatrices pair;
    pair.d = outer(all.d);

    // The outer group's inner matrices, in the axes of the pin between.
    const Sym2<Pack> given = outer(all.A);
    const Vec2p x = given * d_, y = given * perp(d_);
    const Sym2<Pack> A{dot(d_, x), dot(d_, y), dot(perp(d_), y)};
    const auto turnedBack = [this](Vec2p a) { return Vec2p{dot(d_, a), cross(d_, a)}; };
    const Square whole = outer(all.G);
    const Square G{mulAdd(d_.x, whole.x, d_.y * whole.y), mulAdd(d_.x, whole.y, -d_.y * whole.x)};

    // K = (1 + A C)⁻¹
    const Vec2p one{A.xx, A.xy}, two{A.xy, A.yy};
    const Vec2p ACx = C_ * one, ACy = C_ * two;
    const Pack xx = Pack(1) + ACx.x, yy = Pack(1) + ACy.y;
    const Pack inverse = Pack(1) / mulAdd(xx, yy, -ACx.y * ACy.x);
    const Square K{{yy * inverse, -ACx.y * inverse}, {-ACy.x * inverse, xx * inverse}};

    KA_ = K * A;
    KG_ = K * G;
    Kb_ = KA_ * c_;
    Kb_ += K * turnedBack(outer(all.b));
    pair.A = plusSymmetric(inner(all.A), G_ * KA_, G_);
    pair.b = inner(all.b);
    pair.b += G_ * Kb_;
    pair.G = G_ * KG_;
    pair.G = mapped(pair.G, flush);
    pair.C = plusSymmetric(outer(all.C), transposed(G), transposed(C_ * KG_));
    pair.c = outer(all.c);
    pair.c += transposedTimes(G, c_ - C_ * Kb_);

    if constexpr (2 * size < laneCount) larger_ = JoinedPair<2 * size>(pair);
  }
  JoinedPair() = default;

  /// Turns the acceleration a of the chain's inner pin and f = 0 into those of each lane's segment.
  void passOutwards(Vec2p& a, Vec2p& f) const {
    if constexpr (2 * size < laneCount) larger_.passOutwards(a, f);
    const Vec2p carried = transposedTimes(G_, a);
    Vec2p force = KA_ * carried;
    force += Kb_;
    force += KG_ * f;
    const Vec2p at = carried - C_ * force + c_;
    const Rotation<Pack> frame{d_.x, d_.y};
    const Vec2p beyond = frame * at;
    a = either<size>(a, beyond);
    f = either<size>(force, f);
  }

 private:
  static constexpr int next = 2 * size < laneCount ? 2 * size : 0;
  Vec2p d_, c_, Kb_;
  Sym2<Pack> C_;
  Square G_, KA_, KG_;
  JoinedPair<next> larger_;
};

}  // namespace
}  // namespace planar_chain::simd
