#pragma once

/// The Taylor series of one body. See motion_series.h for the equations.

#include "lanes/series_two.h"

namespace planar_chain::simd {
namespace {

using Pair = PackOf<2>;

/// The numbers change places.
Pair swapped(Pair a) {
  return shuffled(a, a, [](int s) { return 1 - s; });
}
/// i e
Pair turned(Pair e) {
  return shuffled(-e, e, [](int s) { return s + 1; });
}
Pair first(Four a) {
  return {Pair::Register{a.v[0], a.v[1]}};
}
Pair second(Four a) {
  return {Pair::Register{a.v[2], a.v[3]}};
}
Four joined(Pair a, Pair b) {
  return {Four::Register{a.v[0], a.v[1], b.v[0], b.v[1]}};
}
/// a/k, by SeriesArrays::inverses
[[gnu::always_inline]] inline Pair over(const double* inverses, int k, Pair a) {
  const double* inverse = inverses + 4 * k;
  return quotient(a, k, Pair::load(inverse), Pair::load(inverse + 2));
}

/// With S = m R, whose cross product with a is a product of e with two numbers,
///
///     J α = N − S×a        z_k = Σ_{1<j<k} ω_j e_{k+1−j}
///     e_{k+2} = i (z_k + ω_k e_1 + ω_1 e_k + ω_{k+1} e_0 + ω_0 e_{k+1})/(k+2)
///
/// Each order waits for those before it. What counts is the longest chain of operations from one to the next.
/// So the terms beside z come last, and their known factors are divided by k + 2 in advance. z is found for
/// four orders at a time, from k = 1, 5, 9 … on. Most of its terms have been in memory for some time:
///
///     Σ_{3<j<k−1} ω_j e_{k+1−j}    of z_k, and of z_{k+1} with e_{k+2−j}, are a register
///     Σ_{3<j<k−1} ω_j e_{k+3−j}    of z_{k+2}, and of z_{k+3} with e_{k+4−j}, likewise
///
/// The others, with j up to 3 or from k − 1 on, are added one by one. If every order sums its own terms, a
/// step at 1e-15 takes a third longer.
class One {
 public:
  One(const SeriesArrays& of, Vec2d ground, double* c)
      : rows_(of.rows), e_(of.e), inverses_(of.inverses), c_(c) {
    const auto& link = *reinterpret_cast<const SeriesLink<double>*>(of.links);
    inverseJ_ = 1 / link.J;
    pull_ = {Pair::Register{-inverseJ_ * dot(link.mr, ground), inverseJ_ * cross(ground, link.mr)}};
    omega_ = omega0_ = Pair(c[1]);
    turned0_ = turned_ = turned(Pair::load(e_));
    const Pair e1 = omega0_ * turned0_;
    e1.store(e_ + 2);
    nextTurned_ = turned(e1);
  }

  /// N: the moment, of order 0 at first, or nullptr; `loads` may be nullptr.
  template <bool acts>
  [[gnu::always_inline]] void findAll(int order, const double* N, SeriesLoads* loads) {
    const auto find = [&](int k, Pair iz) {
      if (k >= order) return;
      if (acts && loads && k > 0) loads->findOrder(k);
      findOrder(k, iz, acts ? inverseJ_ * *N : 0);
    };
    find(0, {});
    turned1_ = turned_;
    const Pair turned2 = nextTurned_;
    Pair omega2, omega3;  // omega1_, too: 0 as long as the term is also one of the last
    for (int k = 1; k < order; k += 4) {
      Pair z, nextZ;
      Four later;
      if (k > 1) {
        omega2 = Pair(c_[5]);
        omega3 = Pair(c_[7]);
        const Four sum = sumFromMemory(k, later);
        z = mulAdd(omega3, turnedAt(k - 2), first(sum));
        z = mulAdd(lastOmega_, turned2, z);
        z = mulAdd(omega2, lastTurned_, z);
        nextZ = mulAdd(omega3, lastTurned_, second(sum));
        nextZ = mulAdd(lastOmega_, turnedAt(3), nextZ);
        nextZ = mulAdd(omega2, turned_, nextZ);
      }
      nextZ = mulAdd(omega_, turned2, nextZ);
      find(k, z);
      find(k + 1, nextZ);

      omega1_ = Pair(c_[3]);
      z = mulAdd(lastOmega_, turned2, first(later));
      z = mulAdd(omega2, lastTurned_, z);
      nextZ = mulAdd(lastOmega_, turnedAt(3), second(later));
      nextZ = mulAdd(omega2, turned_, nextZ);
      nextZ = mulAdd(omega_, turned2, nextZ);
      find(k + 2, z);
      find(k + 3, nextZ);
    }
  }

 private:
  /// Row j is i e_j and i e_{j+1}, stored at once: a load of what two stores have written waits for both.
  static constexpr int row = 4;

  /// i e_j
  Pair turnedAt(int j) const { return Pair::load(rows_ + row * (j - 1) + 2); }

  /// The sums of i z_k and i z_{k+1}; and of the next two orders, with their terms up to j = k.
  [[gnu::always_inline]] Four sumFromMemory(int k, Four& later) const {
    // From the middle on: the first terms and the last ones have hardly been stored.
    Four sums[2], laterSums[2];
    const double *low = c_ + k + 2, *high = low + 2;
    const double *down = rows_ + row * (k - 1) / 2, *up = down + row;
    for (; low > c_ + 8; low -= 4, high += 4, down -= 2 * row, up += 2 * row) {
      PLANAR_CHAIN_WRITTEN_OUT
      for (int i = 0; i < 2; ++i) {
        const Four lowOmega(low[-2 * i]), highOmega(high[2 * i]);
        sums[0] = mulAdd(lowOmega, Four::load(up + row * i), sums[0]);
        sums[1] = mulAdd(highOmega, Four::load(down - row * i), sums[1]);
        laterSums[0] = mulAdd(lowOmega, Four::load(up + row * (i + 2)), laterSums[0]);
        laterSums[1] = mulAdd(highOmega, Four::load(down - row * (i - 2)), laterSums[1]);
      }
    }
    const auto term = [&](int j, Four& sum) {
      sum = mulAdd(Four(c_[2 * j + 1]), Four::load(rows_ + row * (k + 3 - j)), sum);
    };
    term(k - 1, laterSums[0]);
    term(k, laterSums[1]);
    later = laterSums[0] + laterSums[1];
    term(3, later);
    return sums[0] + sums[1];
  }

  /// Order k of α, and what follows from it.
  [[gnu::always_inline]] void findOrder(int k, Pair iz, double own) {
    const Pair parts = mulAdd(pull_, turned_, Pair(Pair::Register{own, 0}));
    const Pair alpha = parts + swapped(parts);
    const Pair theta = over(inverses_, k + 1, omega_), omega = over(inverses_, k + 1, alpha);
    Pair(Pair::Register{theta.v[0], omega.v[1]}).store(c_ + 2 * (k + 1));

    Pair e = over(inverses_, k + 2, iz);
    e = mulAdd(omega_, over(inverses_, k + 2, turned1_), e);
    e = mulAdd(turned_, over(inverses_, k + 2, omega1_), e);
    e = mulAdd(omega, over(inverses_, k + 2, turned0_), e);
    e = mulAdd(nextTurned_, over(inverses_, k + 2, omega0_), e);
    e.store(e_ + 2 * (k + 2));

    lastOmega_ = omega_;
    omega_ = omega;
    lastTurned_ = turned_;
    turned_ = nextTurned_;
    nextTurned_ = turned(e);
    joined(turned_, nextTurned_).store(rows_ + row * (k + 1));
  }

  double *rows_, *e_;
  const double* inverses_;
  double* c_;
  double inverseJ_;
  Pair pull_;                                 ///< J α = N + J (pull · i e)
  Pair omega0_, turned0_, omega1_, turned1_;  ///< turned: i e
  Pair lastOmega_, omega_;                    ///< of orders k − 1 and k
  Pair lastTurned_, turned_, nextTurned_;     ///< of orders k − 1, k and k + 1
};

void seriesOfOne(const SeriesArrays& of, int order, const Loads& external, SeriesLoads* loads, double* c) {
  One one(of, external.ground, c);
  if (external.N) return one.findAll<true>(order, external.N, loads);
  one.findAll<false>(order, nullptr, nullptr);
}

}  // namespace
}  // namespace planar_chain::simd
