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
  explicit CoupledRows(double* first) : first_(first) {}

  [[gnu::always_inline]] Lane number(int row, std::ptrdiff_t j) const {
    return Lane(first_[row * CoupledArrays::width + j]);
  }
  [[gnu::always_inline]] Vec2<Lane> pair(int row, std::ptrdiff_t j) const {
    return {number(row, j), number(row + 1, j)};
  }
  [[gnu::always_inline]] Turned<Lane> body(std::ptrdiff_t j) const {
    return {number(0, j), number(1, j), pair(2, j), P(j), ww(j)};
  }
  [[gnu::always_inline]] Vec2<Lane> P(std::ptrdiff_t j) const { return pair(4, j); }
  [[gnu::always_inline]] Lane ww(std::ptrdiff_t j) const { return number(6, j); }
  [[gnu::always_inline]] CoupledHandle<Lane> handle(std::ptrdiff_t j) const {
    return {pair(7, j), number(9, j), number(10, j), number(11, j), number(12, j)};
  }
  /// Of a body that couples nothing.
  [[gnu::always_inline]] Reply<Lane> reply(std::ptrdiff_t j) const {
    return {pair(7, j), P(j), number(9, j), ww(j)};
  }
  template <class... Numbers>
  [[gnu::always_inline]] void put(int row, std::ptrdiff_t j, Numbers... numbers) const {
    (numbers.store(first_ + row++ * CoupledArrays::width + j), ...);
  }

 private:
  double* first_;
};

PLANAR_CHAIN_IN_ONE_PIECE void coupledLinks(const CoupledArrays& given, const Outside& acting,
                                            const double* theta, const double* omega, double turning,
                                            CoupledMotion to) {
  const CoupledArrays arrays = given;  // what they point to is no part of them
  const Outside outside = acting;
  const CoupledRows rows(arrays.handles);
  for (int first = 0; first < arrays.n; first += laneCount) {
    const int k = first / laneCount, count = arrays.n - first;
    double* e = &outside.e[first].c;
    const Turned<Pack> body =
        turned(linkAt(arrays.links, k), theta ? rotationsOfSome(theta + first, count, e) : loadRotations(e),
               loadSome(omega + first, count));
    rows.put(0, first, body.m, body.J, body.R.x, body.R.y, body.P.x, body.P.y, body.ww);
  }

  CoupledPin<Lane> pin;
  PLANAR_CHAIN_WRITTEN_OUT
  for (int j = CoupledArrays::most - 1; j >= 0; --j) {
    if (j >= arrays.n) continue;
    const Turned<Lane> body = rows.body(j);
    const Lane N(outside.N[j]);
    if (arrays.couples[j]) {
      const auto handle = inwards(body, N, jointAt<Lane>(arrays.joints, j), pin);
      rows.put(7, j, handle.U.x, handle.U.y, handle.epsilon, handle.inverseD, handle.kappa, handle.D0);
    } else {
      const Reply<Lane> reply = replyOf(inwards<false>(body, N, pin.A, pin.b), body);
      rows.put(7, j, reply.UD.x, reply.UD.y, reply.uD);
    }
    if (outside.F) pin.b -= vectorOf(outside.F[j]);
  }

  Vec2<Lane> a = vectorOf(outside.ground);
  Lane alpha(turning);
  const Vec2<Lane> force = pin.A * a + alpha * pin.H + pin.b;
  *to.pinForce = {force.x.v, force.y.v};
  PLANAR_CHAIN_WRITTEN_OUT
  for (int j = 0; j < CoupledArrays::most; ++j) {
    if (j >= arrays.n) break;
    Lane moment;
    if (arrays.couples[j]) {
      moment = outwards(rows.handle(j), jointAt<Lane>(arrays.joints, j), rows.P(j), rows.ww(j), a, alpha);
    } else {
      alpha = outwards(rows.reply(j), a);
    }
    to.alpha[j] = alpha.v;
    to.moments[j] = moment.v;
  }
}

// ---- In segments -------------------------------------------------------------------------------------

struct CoupledSegment {
  Shows<Pack> shows;
  ShowsOfSide<Pack> constant;
};

inline double* handleAt(const CoupledArrays& arrays, int i) {
  return arrays.handles + static_cast<std::ptrdiff_t>(i) * CoupledArrays::handleQuantities * laneCount;
}

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
    Writer{handleAt(arrays, i)}(handle.U, handle.epsilon, handle.inverseD, handle.kappa, handle.D0, P,
                                body.ww, g);
  }
  C.y.x = C.x.y;
  C.z.x = C.x.z;
  C.z.y = C.y.z;
  const auto& [A, b, H, Q, moment] = pin;
  const Matrix3<Pack> K{{A.xx, A.xy, H.x}, {A.xy, A.yy, H.y}, {H.x, H.y, Q}};
  const Matrix3<Pack> Gt{{Gx.x, Gy.x, Gm.x}, {Gx.y, Gy.y, Gm.y}, {Gx.z, Gy.z, Gm.z}};
  return {{d, K, Gt, {Gx, Gy, Gm}, C}, {{b.x, b.y, moment}, c}};
}

template <bool hasForces>
PLANAR_CHAIN_IN_ONE_PIECE void runCoupledSegments(const CoupledArrays& arrays, const Outside& outside,
                                                  const double* omega, double turning, CoupledMotion to) {
  const CoupledSegment segment = coupledInwards<hasForces>(arrays, outside, omega);
  Triple<Pack> X{Pack(outside.ground.x), Pack(outside.ground.y), Pack(turning)}, Y{};
  LinearPairs<Pack, 1>::factor(segment.shows, arrays.pairs);
  LinearPairs<Pack, 1>::solve(segment.constant, arrays.pairs, X, Y);
  const Triple<Pack> force = segment.constant.y + (segment.shows.K * X + segment.shows.G * Y);
  *to.pinForce = {force.x.v[0], force.y.v[0]};

  Vec2p a{X.x, X.y};
  Pack alpha = X.z;
  for (int i = 0; i < arrays.steps; ++i) {
    CoupledHandle<Pack> handle;
    Vec2p P;
    Pack ww;
    Triple<Pack> g;
    Reader{handleAt(arrays, i)}(handle.U, handle.epsilon, handle.inverseD, handle.kappa, handle.D0, P, ww, g);
    handle.epsilon -= dot(g, Y);
    const Pack moment = outwards(handle, jointAt<Pack>(arrays.joints, i), P, ww, a, alpha);
    alpha.store(to.alpha + static_cast<std::ptrdiff_t>(i) * laneCount);
    moment.store(to.moments + static_cast<std::ptrdiff_t>(i) * laneCount);
  }
}

void coupledSegments(const CoupledArrays& arrays, const Outside& outside, const double* /*theta*/,
                     const double* omega, double turning, CoupledMotion to) {
  (outside.F ? runCoupledSegments<true> : runCoupledSegments<false>)(arrays, outside, omega, turning, to);
}

}  // namespace
}  // namespace planar_chain::simd
