#pragma once

/// The recursion of coupled.h in lanes; see coupled_chain.h. The compiler options of the including file
/// choose the CPU.

#include "lanes/lane_kernel.h"
#include "lanes/linear_join.h"
#include "recursion/coupled.h"

namespace planar_chain::simd {
namespace {

template <class Real>
[[gnu::always_inline]] inline JointAt<Real> jointAt(const double* joints, std::ptrdiff_t i) {
  JointAt<Real> joint;
  Reader{joints + i * doubles<JointAt<Real>>}(joint.rotor, joint.held, joint.acceleration);
  return joint;
}

// ---- Link by link ------------------------------------------------------------------------------------

/// Rows of numbers, one of each body: the bodies, turned, and their handles.
class CoupledRows {
 public:
  /// The first row of m, J, R; of P, ω²; of a handle or a reply; of g of the tip.
  static constexpr int bodies = 0, pins = 4, rates = 6, handles = 7, tips = 13;
  static_assert(tips + 2 == CoupledArrays::rows);

  explicit CoupledRows(double* first) : first_(first) {}

  [[gnu::always_inline]] Lane number(int row, std::ptrdiff_t j) const {
    return Lane(first_[row * CoupledArrays::width + j]);
  }
  [[gnu::always_inline]] Vec2<Lane> pair(int row, std::ptrdiff_t j) const {
    return {number(row, j), number(row + 1, j)};
  }
  [[gnu::always_inline]] Turned<Lane> body(std::ptrdiff_t j) const {
    return {number(bodies, j), number(bodies + 1, j), pair(bodies + 2, j), P(j), ww(j)};
  }
  [[gnu::always_inline]] Vec2<Lane> P(std::ptrdiff_t j) const { return pair(pins, j); }
  [[gnu::always_inline]] Lane ww(std::ptrdiff_t j) const { return number(rates, j); }
  [[gnu::always_inline]] CoupledHandle<Lane> handle(std::ptrdiff_t j) const {
    return {pair(handles, j), number(handles + 2, j), number(handles + 3, j), number(handles + 4, j),
            number(handles + 5, j)};
  }
  /// Of a body that couples nothing.
  [[gnu::always_inline]] Reply<Lane> reply(std::ptrdiff_t j) const {
    return {pair(handles, j), P(j), number(handles + 2, j), ww(j)};
  }
  template <class... Numbers>
  [[gnu::always_inline]] void put(int row, std::ptrdiff_t j, Numbers... numbers) const {
    (numbers.store(first_ + row++ * CoupledArrays::width + j), ...);
  }

 private:
  double* first_;
};

enum class EndKind { none, slides, tip };

/// For a function that is compiled for every CPU.
[[gnu::always_inline]] inline EndedPin<double> numbersOf(const EndedPin<Lane>& shown) {
  const auto& [pin, Gx, Gy, eta, tip, C] = shown;
  const auto vector = [](const Vec2<Lane>& a) { return Vec2d{a.x.v, a.y.v}; };
  const auto tensor = [](const Sym2<Lane>& a) { return Sym2<double>{a.xx.v, a.xy.v, a.yy.v}; };
  return {{tensor(pin.A), vector(pin.b), vector(pin.H), pin.Q.v, pin.c.v},
          vector(Gx),
          vector(Gy),
          vector(eta),
          vector(tip),
          tensor(C)};
}

/// Inwards, body by body: takes what a body shows from the rows, and adds what the way out needs.
template <EndKind ends>
[[gnu::always_inline]] inline void coupledLinkInwards(const CoupledArrays& arrays, const Outside& outside,
                                                      const CoupledRows& rows, int j, EndedPin<Lane>& shown) {
  CoupledPin<Lane>& pin = shown.pin;
  const Turned<Lane> body = rows.body(j);
  const Lane N(outside.N[j]);
  if (arrays.couples[j]) {
    const JointAt<Lane> joint = jointAt<Lane>(arrays.joints, j);
    const auto handle = inwards(body, N, joint, pin);
    rows.put(CoupledRows::handles, j, handle.U.x, handle.U.y, handle.epsilon, handle.inverseD, handle.kappa,
             handle.D0);
    if constexpr (ends == EndKind::tip) {
      const Lane turn = mulAdd(handle.epsilon, handle.inverseD, joint.acceleration);
      const Vec2<Lane> g = shown.pass(body, handle.U, handle.inverseD, turn);
      shown.eta = handle.kappa * g;
      rows.put(CoupledRows::tips, j, g.x, g.y);
    }
  } else {
    const Handle<Lane> handle = inwards<false>(body, N, pin.A, pin.b);
    const Reply<Lane> reply = replyOf(handle, body);
    rows.put(CoupledRows::handles, j, reply.UD.x, reply.UD.y, reply.uD);
    if constexpr (ends == EndKind::tip) {
      const Vec2<Lane> gD = handle.inverseD * shown.pass(body, handle.U, handle.inverseD, reply.uD);
      rows.put(CoupledRows::tips, j, gD.x, gD.y);
    }
  }
  if (outside.F) pin.b -= vectorOf(outside.F[j]);
}

/// Outwards. Returns μ.
template <EndKind ends>
[[gnu::always_inline]] inline Lane coupledLinkOutwards(const CoupledArrays& arrays, const CoupledRows& rows,
                                                       int j, Vec2<Lane> tipForce, Vec2<Lane>& a,
                                                       Lane& alpha) {
  if (arrays.couples[j]) {
    CoupledHandle<Lane> handle = rows.handle(j);
    if constexpr (ends == EndKind::tip) handle.epsilon += dot(rows.pair(CoupledRows::tips, j), tipForce);
    return outwards(handle, jointAt<Lane>(arrays.joints, j), rows.P(j), rows.ww(j), a, alpha);
  }
  Reply<Lane> reply = rows.reply(j);
  if constexpr (ends == EndKind::tip) reply.uD += dot(rows.pair(CoupledRows::tips, j), tipForce);
  alpha = outwards(reply, a);
  return {};
}

template <EndKind ends>
PLANAR_CHAIN_IN_ONE_PIECE void coupledLinks(const CoupledArrays& given, const Outside& acting,
                                            const double* theta, const double* omega, double turning,
                                            CoupledResults to) {
  const CoupledArrays arrays = given;  // what they point to is no part of them
  const Outside outside = acting;
  const CoupledRows rows(arrays.handles);
  for (int first = 0; first < arrays.n; first += laneCount) {
    const int k = first / laneCount, count = arrays.n - first;
    double* e = &outside.e[first].c;
    const Turned<Pack> body =
        turned(linkAt(arrays.links, k), theta ? rotationsOfSome(theta + first, count, e) : loadRotations(e),
               loadSome(omega + first, count));
    rows.put(CoupledRows::bodies, first, body.m, body.J, body.R.x, body.R.y, body.P.x, body.P.y, body.ww);
  }

  EndedPin<Lane> shown;
  PLANAR_CHAIN_WRITTEN_OUT
  for (int j = CoupledArrays::most - 1; j >= 0; --j) {
    if (j < arrays.n) coupledLinkInwards<ends>(arrays, outside, rows, j, shown);
  }

  Vec2<Lane> a = vectorOf(outside.ground), tipForce;
  Lane alpha(turning);
  if constexpr (ends == EndKind::none) {
    const Vec2<Lane> force = shown.pin.A * a + alpha * shown.pin.H + shown.pin.b;
    *to.pinForce = {force.x.v, force.y.v};
  } else {
    Vec2d ofPin, ofTip;
    meet(numbersOf(shown), *to.ends, ofPin, ofTip);
    a = vectorOf(ofPin);
    tipForce = vectorOf(ofTip);
  }
  PLANAR_CHAIN_WRITTEN_OUT
  for (int j = 0; j < CoupledArrays::most; ++j) {
    if (j >= arrays.n) break;
    const Lane moment = coupledLinkOutwards<ends>(arrays, rows, j, tipForce, a, alpha);
    to.alpha[j] = alpha.v;
    to.moments[j] = moment.v;
  }
}

// ---- In segments -------------------------------------------------------------------------------------

struct CoupledSegment {
  Shows<Pack> shows;
  ShowsOfSide<Pack> constant;
};

template <bool hasForces>
[[gnu::always_inline]] inline CoupledSegment coupledInwards(const CoupledArrays& arrays,
                                                            const Outside& outside, const double* omega) {
  const double* e = &outside.e->c;
  const Pack zero;
  const Vec2p d = outerFrames(arrays.links, e, arrays.steps);
  CoupledPin<Pack> pin;
  Triple<Pack> Gx{d.x, -d.y, zero}, Gy{d.y, d.x, zero}, Gm{zero, zero, Pack(1)};  // rows of G
  Matrix3<Pack> C{};
  Triple<Pack> c{};
  for (int i = arrays.steps - 1; i >= 0; --i) {
    const Turned<Pack> body = turned(linkAt(arrays.links, i), readRotation(e, i), read(omega, i));
    const Vec2p P = body.P;
    const JointAt<Pack> joint = jointAt<Pack>(arrays.joints, i);
    const CoupledHandle<Pack> handle = inwards(body, read(outside.N, i), joint, pin);
    if constexpr (hasForces) pin.b -= readVector(&outside.F->x, i);

    const Triple<Pack> g = mulAdd(P.x, Gy, mulAdd(-P.y, Gx, Gm));
    const Triple<Pack> gD = handle.inverseD * g;
    C.x = mulAdd(g.x, gD, C.x);
    C.y.y = mulAdd(g.y, gD.y, C.y.y);
    C.y.z = mulAdd(g.y, gD.z, C.y.z);
    C.z.z = mulAdd(g.z, gD.z, C.z.z);
    c = mulAdd(mulAdd(handle.inverseD, handle.epsilon, joint.acceleration), g,
               mulAdd(-body.ww * P.x, Gx, mulAdd(-body.ww * P.y, Gy, c)));
    Gx = mulAdd(-handle.U.x, gD, Gx);
    Gy = mulAdd(-handle.U.y, gD, Gy);
    Gm = handle.kappa * g;
    if (i % stepsPerFlush == 0) {
      Gx = mapped(Gx, flush);
      Gy = mapped(Gy, flush);
      Gm = mapped(Gm, flush);
    }
    Writer{stepAt<CoupledArrays::handleQuantities>(arrays.handles, i)}(
        handle.U, handle.epsilon, handle.inverseD, handle.kappa, handle.D0, P, body.ww, g);
  }
  C.y.x = C.x.y;
  C.z.x = C.x.z;
  C.z.y = C.y.z;
  const auto& [A, b, H, Q, moment] = pin;
  const Matrix3<Pack> K{{A.xx, A.xy, H.x}, {A.xy, A.yy, H.y}, {H.x, H.y, Q}};
  const Matrix3<Pack> Gt{{Gx.x, Gy.x, Gm.x}, {Gx.y, Gy.y, Gm.y}, {Gx.z, Gy.z, Gm.z}};
  return {{d, K, Gt, {Gx, Gy, Gm}, C}, {{b.x, b.y, moment}, c}};
}

/// What all segments together show, in ground axes. sides: b, c and c_y.
[[gnu::always_inline]] inline EndedPin<double> shownBy(const Shows<Pack>& all,
                                                       const ShowsOfSide<Pack>& sides) {
  const auto first = [](const Pack& a) { return a.v[0]; };
  const auto vector = [&](const Vec2p& a) { return Vec2d{first(a.x), first(a.y)}; };
  const Axes axes{all.d};
  // What takes a force in the tip's own axes takes one in ground axes.
  const Matrix3<Pack>&K = all.K, &G = all.G;
  const Triple<Pack> Gx = axes.toGround(G.x), Gy = axes.toGround(G.y), eta = axes.toGround(G.z);
  const Triple<Pack> tip = axes.toGround(sides.c);
  const Triple<Pack> Cx = axes.toGround(all.C.x), Cy = axes.toGround(all.C.y);
  const Vec2p x = axes.d, y = perp(axes.d);
  const Vec2p C_x = mulAdd(x.x, Vec2p{Cx.x, Cx.y}, y.x * Vec2p{Cy.x, Cy.y});
  const Vec2p C_y = mulAdd(x.y, Vec2p{Cx.x, Cx.y}, y.y * Vec2p{Cy.x, Cy.y});
  return {{{first(K.x.x), first(K.x.y), first(K.y.y)},
           vector({sides.y.x, sides.y.y}),
           vector({K.x.z, K.y.z}),
           first(K.z.z),
           first(sides.y.z)},
          vector({Gx.x, Gy.x}),
          vector({Gx.y, Gy.y}),
          vector({eta.x, eta.y}),
          vector({tip.x, tip.y}),
          {first(C_x.x), first(C_x.y), first(C_y.y)}};
}

template <bool hasEnds, bool hasForces>
PLANAR_CHAIN_IN_ONE_PIECE void runCoupledSegments(const CoupledArrays& arrays, const Outside& outside,
                                                  const double* omega, double turning, CoupledResults to) {
  const CoupledSegment segment = coupledInwards<hasForces>(arrays, outside, omega);
  Triple<Pack> X{Pack(outside.ground.x), Pack(outside.ground.y), Pack(turning)}, Y{};
  const Shows<Pack> all = LinearPairs<Pack, 1>::factor(segment.shows, arrays.pairs);
  [[maybe_unused]] const auto meetEnds = [&](const ShowsOfSide<Pack>& sides) {
    Vec2d a, tipForce;
    meet(shownBy(all, sides), *to.ends, a, tipForce);
    X.x = Pack(a.x);
    X.y = Pack(a.y);
    Y = Axes{all.d}.fromGround(Triple<Pack>{Pack(-tipForce.x), Pack(-tipForce.y), Pack()});
  };
  if constexpr (hasEnds) {
    LinearPairs<Pack, 1>::solve(segment.constant, arrays.pairs, X, Y, meetEnds);
  } else {
    LinearPairs<Pack, 1>::solve(segment.constant, arrays.pairs, X, Y);
    const Triple<Pack> force = segment.constant.y + (segment.shows.K * X + segment.shows.G * Y);
    *to.pinForce = {force.x.v[0], force.y.v[0]};
  }

  Vec2p a{X.x, X.y};
  Pack alpha = X.z;
  for (int i = 0; i < arrays.steps; ++i) {
    CoupledHandle<Pack> handle;
    Vec2p P;
    Pack ww;
    Triple<Pack> g;
    Reader{stepAt<CoupledArrays::handleQuantities>(arrays.handles, i)}(
        handle.U, handle.epsilon, handle.inverseD, handle.kappa, handle.D0, P, ww, g);
    handle.epsilon -= dot(g, Y);
    const Pack moment = outwards(handle, jointAt<Pack>(arrays.joints, i), P, ww, a, alpha);
    alpha.store(stepAt<1>(to.alpha, i));
    moment.store(stepAt<1>(to.moments, i));
  }
}

template <bool hasEnds>
void coupledSegments(const CoupledArrays& arrays, const Outside& outside, const double* /*theta*/,
                     const double* omega, double turning, CoupledResults to) {
  const auto run = outside.F ? runCoupledSegments<hasEnds, true> : runCoupledSegments<hasEnds, false>;
  run(arrays, outside, omega, turning, to);
}

}  // namespace
}  // namespace planar_chain::simd
