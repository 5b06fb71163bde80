#pragma once

/// The Taylor series of one body. See motion_series.h for the equations.

#include "lanes/series_two.h"

namespace planar_chain::simd {
namespace {

using Pair = LanesOf<2>;

/// i e
Pair turned(Pair e) {
  return {Pair::Register{-e.v[1], e.v[0]}};
}
Four joined(Pair a, Pair b) {
  return {Four::Register{a.v[0], a.v[1], b.v[0], b.v[1]}};
}
/// a + b of joined(a, b)
Pair sumOf(Four a) {
  return Pair(Pair::Register{a.v[0], a.v[1]}) + Pair(Pair::Register{a.v[2], a.v[3]});
}

/// With S = m R, whose cross product with a is a product of e with two numbers,
///
///     J α = N − S×a        z = Σ_{j≤k} ω_j e_{k+1−j}        e_{k+2} = i (ω_{k+1} e_0 + z)/(k+2)
///
/// Two terms of z are one product of (e_i, e_{i+1}) and (ω_j, ω_{j−1}). Each stands in memory as it was
/// stored at once: a load of what two stores have written waits for both.
class One {
 public:
  using Some = Number;
  One(const SeriesArrays& of, Vec2<Number> ground, const double* omega) {
    const SeriesLink<Number> link = seriesLinkAt<Number>(of.links, 0);
    inverseJ_ = Number(1) / link.J;
    pull_ = {inverseJ_ * cross(ground, link.mr), inverseJ_ * dot(link.mr, ground)};
    omega_ = read<Number>(omega, 0);
    omega0_ = Pair(omega_.v);
    e_ = e0_ = Pair::load(of.e);
    nextE_ = omega0_ * turned(e_);
    nextE_.store(of.e + 2);
  }
  int bodies() const { return 1; }
  int stride() const { return width / 2; }

  /// All but ω_0 e_{k+1}.
  void know(const double* rows, int k) {
    Four sums[2];
    if (k % 2 == 1) sums[1] = joined(Pair::load(rows + width + half) * e_, {});
    const auto add = [&](int i, int part) {
      const double *e = rows + i * width, *omega = rows + (k + 1 - i) * width + half;
      sums[part] = mulAdd(Four::load(e), Four::load(omega), sums[part]);
    };
    int i = k - 1 - k % 2;
    for (; i > 1; i -= 4) {
      add(i, 0);
      add(i - 2, 1);
    }
    if (i == 1) add(1, 0);
    known_ = sumOf(sums[0] + sums[1]);
  }

  template <bool isFirst>
  [[gnu::always_inline]] void find(const Order<Number>& order) {
    const Number own = inverseJ_ * order.moment(0);
    const Number alpha = mulAdd(pull_.x, Number(e_.v[0]), mulAdd(pull_.y, Number(e_.v[1]), own));
    const Number next = alpha * order.perOrder;
    (omega_ * order.perOrder).store(order.next);
    next.store(order.next + 1);

    Pair z = mulAdd(Pair(next.v), e0_, isFirst ? Pair() : known_);
    z = mulAdd(omega0_, nextE_, z);
    const Pair afterNext = turned(z) * order.perNext;
    afterNext.store(order.nextE);
    double* row = order.row + width;
    joined(nextE_, afterNext).store(row);
    joined(Pair(next.v), Pair(omega_.v)).store(row + half);
    e_ = nextE_;
    nextE_ = afterNext;
    omega_ = next;
  }

 private:
  static constexpr int width = 8, half = 4;
  Number inverseJ_, omega_;
  Vec2<Number> pull_;
  Pair e0_, omega0_, e_, nextE_, known_;
};

}  // namespace
}  // namespace planar_chain::simd
