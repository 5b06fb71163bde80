#pragma once

/// Forward dynamics in O(n) of a chain with ends (ends.h): a carriage, no pin at all, a tip that is held.
/// coupled.h has the letters and the recursion of its bodies.
///
/// A force λ on the tip is linear in all that a body shows its inner pin, and so is the acceleration of the
/// tip:
///
///     F_pin = A a + H α_p + b − G λ          μ = H·a + Q α_p + c − η·λ
///     a_tip = Gᵀ a + η α_p + C λ + c_t
///
/// The same G and η stand in both, as the mass matrix is symmetric. Inwards from G = 1, η = 0, C = 0, c_t = 0
/// at the tip, with U, ε, 1/D and κ of coupled.h,
///
///     g = Gᵀ iP + η                    α = (ε + g·λ − U·a)/D + κ α_p + q̈
///     C ← C + g gᵀ/D                   c_t ← c_t + g (ε/D + q̈) − ω² Gᵀ P
///     G ← G − U gᵀ/D                   η ← κ g
///
/// C sums positive terms, so it does not cancel. Let a_0 be the acceleration of the base. All accelerations
/// are less gravity. a = a_0 + Σ d_i s̈_i is that of the first pin, m_2 the mass of the slide on which the
/// chain hangs and m_1 that of a slide further in. The rails say
///
///     d_i·((A + m_2) a + H α_p + b − G λ) + m_1 d_i·(a_0 + d_1 s̈_1), the last term for i = 1 alone,   = f_i
///
/// a 2×2 system K s̈ = … + d_i·G λ of the slides that are not held. So s̈ = s̈_0 + Y φ with λ = Σ φ_j c_j, and
/// the rows of the tip c_j·a_tip = given become
///
///     M φ = given − c_j·a_tip(φ = 0)          M = cᵀ (C + Gᵀ d K⁻¹ dᵀ G) c
///
/// Where the chain is stretched between its ends, or a row moves nothing, M loses a rank. Directions whose
/// eigenvalue is less than singularTip of the largest possible one do not act.
///
/// Source: derived as in coupled.h. Against Newton's and Euler's equations: ended_test.

#include <vector>

#include "recursion/coupled.h"
#include "recursion/ends.h"

namespace planar_chain {

/// How the ends move, and their forces.
template <class Real>
struct EndsMotion {
  PerEnd<Real> acceleration{};  ///< s̈ of the slides, m/s²
  PerEnd<Real> force{};         ///< f on the slides, N: as given, or what holds them
  Vec2<Real> pinAcceleration;   ///< a of the first pin, less gravity, m/s²
  Vec2<Real> pinForce;          ///< on the first body, N
  Vec2<Real> tipAcceleration;   ///< less gravity, m/s²
  Vec2<Real> tipForce;          ///< λ, N
  Tip<Real> acting;             ///< the tip with those directions alone that act
};

/// What a chain shows its ends.
template <class Real>
struct EndedPin {
  CoupledPin<Real> pin;
  Vec2<Real> Gx{Real(1), Real(0)}, Gy{Real(0), Real(1)};  ///< the columns of G
  Vec2<Real> eta, tip;                                    ///< η, c_t
  Sym2<Real> C;

  /// Gᵀ a
  Vec2<Real> transposed(Vec2<Real> a) const { return {dot(Gx, a), dot(Gy, a)}; }
  /// G λ
  Vec2<Real> times(Vec2<Real> lambda) const { return lambda.x * Gx + lambda.y * Gy; }

  /// One body inwards, after inwards() of coupled.h. Returns g.
  Vec2<Real> pass(const Turned<Real>& body, const CoupledHandle<Real>& handle, Real acceleration) {
    const Vec2<Real> g = transposed(perp(body.P)) + eta, gD = handle.inverseD * g;
    C = {mulAdd(gD.x, g.x, C.xx), mulAdd(gD.x, g.y, C.xy), mulAdd(gD.y, g.y, C.yy)};
    const Real turn = mulAdd(handle.epsilon, handle.inverseD, acceleration);
    tip = mulAdd(turn, g, mulAdd(-body.ww, transposed(body.P), tip));
    Gx = flushed(mulAdd(-gD.x, handle.U, Gx));
    Gy = flushed(mulAdd(-gD.y, handle.U, Gy));
    eta = handle.kappa * g;
    return g;
  }

 private:
  /// Along a long crooked chain G shrinks exponentially. Denormal numbers would be slow.
  static Vec2<Real> flushed(Vec2<Real> a) { return dot(a, a) < Real(1e-280) ? Vec2<Real>{} : a; }
};

/// The equations of the ends. Allocates nothing.
template <class Real>
class EndsEquations {
 public:
  /// base: a_0. turning: angular acceleration of the base. The arguments must outlive this object.
  EndsEquations(const EndedPin<Real>& shown, const InnerEnd<Real>& inner, Vec2<Real> base, Real turning)
      : shown_(shown), inner_(inner), base_(base), turning_(turning) {
    const Sym2<Real>& A = shown.pin.A;
    const Real m = inner.slides > 0 ? inner.slide[index(inner.slides - 1)].mass : Real(0);
    A_ = {A.xx + m, A.xy, A.yy + m};
    const Vec2<Real> dx = rail(0), dy = rail(1);
    K_ = {isFree(0) ? dot(dx, A_ * dx) + innerMass(0) : Real(1), dot(dx, A_ * dy),
          isFree(1) ? dot(dy, A_ * dy) : Real(1)};
    const Vec2<Real> x = pinUnder(shown.Gx), y = pinUnder(shown.Gy);
    L_ = {shown.C.xx + dot(shown.Gx, x), shown.C.xy + dot(shown.Gx, y), shown.C.yy + dot(shown.Gy, y)};
  }

  EndsMotion<Real> solve(const Tip<Real>& tip) const {
    EndsMotion<Real> motion;
    PerEnd<Real>& slides = motion.acceleration;
    for (int i = 0; i < inner_.slides; ++i) {
      if (!isFree(i)) slides[index(i)] = inner_.slide[index(i)].acceleration;
    }
    const Vec2<Real> more = planar_chain::solve(K_, {missing(0, slides), missing(1, slides)});
    slides = {slides[0] + more.x, slides[1] + more.y};
    motion.acting = actingPart(tip);
    motion.tipForce = tipForce(motion.acting, tipAcceleration(slides, {}));
    const Vec2<Real> byTip = slidesUnder(shown_.times(motion.tipForce));
    slides = {slides[0] + byTip.x, slides[1] + byTip.y};

    motion.pinAcceleration = pinAcceleration(slides);
    motion.pinForce = pinForce(slides, motion.tipForce);
    motion.tipAcceleration = tipAcceleration(slides, motion.tipForce);
    for (int i = 0; i < inner_.slides; ++i) {
      const Slide<Real>& slide = inner_.slide[index(i)];
      motion.force[index(i)] = slide.isHeld ? effort(i, slides, motion.tipForce) : slide.force;
    }
    return motion;
  }

 private:
  bool isFree(int i) const { return i < inner_.slides && !inner_.slide[index(i)].isHeld; }
  /// d_i, or 0 if slide i is held.
  Vec2<Real> rail(int i) const { return isFree(i) ? inner_.slide[index(i)].d : Vec2<Real>{}; }
  /// m_1 of the first slide of two.
  Real innerMass(int i) const { return i == 0 && inner_.slides == 2 ? inner_.slide[0].mass : Real(0); }

  Vec2<Real> pinAcceleration(const PerEnd<Real>& slides) const {
    Vec2<Real> a = base_;
    for (int i = 0; i < inner_.slides; ++i) a += slides[index(i)] * inner_.slide[index(i)].d;
    return a;
  }
  /// On the first body.
  Vec2<Real> pinForce(const PerEnd<Real>& slides, Vec2<Real> lambda) const {
    const CoupledPin<Real>& pin = shown_.pin;
    return pin.A * pinAcceleration(slides) + turning_ * pin.H + pin.b - shown_.times(lambda);
  }
  /// The force along rail i that such a motion takes.
  Real effort(int i, const PerEnd<Real>& slides, Vec2<Real> lambda) const {
    const Slide<Real>& slide = inner_.slide[index(i)];
    const Vec2<Real> inner = innerMass(i) * (base_ + slides[0] * inner_.slide[0].d);
    const Vec2<Real> outer = inner_.slide[index(inner_.slides - 1)].mass * pinAcceleration(slides);
    return dot(slide.d, pinForce(slides, lambda) + inner + outer);
  }
  Real missing(int i, const PerEnd<Real>& slides) const {
    return isFree(i) ? inner_.slide[index(i)].force - effort(i, slides, {}) : Real(0);
  }
  /// How a force on the pin accelerates the slides, and the pin.
  Vec2<Real> slidesUnder(Vec2<Real> force) const {
    return planar_chain::solve(K_, {dot(rail(0), force), dot(rail(1), force)});
  }
  Vec2<Real> pinUnder(Vec2<Real> force) const {
    const Vec2<Real> slides = slidesUnder(force);
    return slides.x * rail(0) + slides.y * rail(1);
  }

  Vec2<Real> tipAcceleration(const PerEnd<Real>& slides, Vec2<Real> lambda) const {
    return shown_.transposed(pinAcceleration(slides)) + turning_ * shown_.eta + shown_.C * lambda +
           shown_.tip;
  }
  Tip<Real> actingPart(const Tip<Real>& tip) const {
    const auto [value, vector] = eigen(L_);
    const Real least = Real(singularTip) * value[0];
    if (tip.rows == 2 && value[1] > least) return tip;
    Tip<Real> acting;
    acting.acceleration = tip.acceleration;
    const Vec2<Real> row = tip.rows == 2 ? vector[0] : tip.row[0];
    if (tip.rows > 0 && dot(row, L_ * row) > least) acting.row[index(acting.rows++)] = row;
    return acting;
  }
  /// λ, if the tip without it had the acceleration `open`.
  Vec2<Real> tipForce(const Tip<Real>& tip, Vec2<Real> open) const {
    const Vec2<Real> rest = tip.acceleration - open;
    if (tip.rows == 2) return planar_chain::solve(L_, rest);
    if (tip.rows == 0) return {};
    const Vec2<Real> c = tip.row[0];
    return (dot(c, rest) / dot(c, L_ * c)) * c;
  }

  const EndedPin<Real>& shown_;
  const InnerEnd<Real>& inner_;
  Vec2<Real> base_;
  Real turning_;
  Sym2<Real> A_, K_, L_;  ///< A_: with the mass of the outermost slide. L_: the tip's answer to λ
};

/// What the motion of a chain with ends depends on, beside its angles and rates: n values each.
template <class Real>
struct EndedActing {
  const Real* N;        ///< moments, N m
  const Vec2<Real>* F;  ///< forces without gravity, N; nullptr: none
  const Coupling<Real>* joints;
  Vec2<Real> base;  ///< acceleration of the base less gravity, m/s²
  Real turning;     ///< its angular acceleration, rad/s²
};

template <class Real = double>
class Ended {
 public:
  explicit Ended(const Chain& chain) : bodies_(index(chain.size())) {
    for (std::size_t j = 0; j < bodies_.size(); ++j) {
      const Link& link = chain.links()[j];
      bodies_[j].of = {Real(link.mass),
                       Real(link.inertia),
                       {Real(link.com.x), Real(link.com.y)},
                       {Real(link.pin.x), Real(link.pin.y)}};
    }
  }

  /// Writes α, rad/s², and the moments μ of the joints, N m, without what N has of them. e: exp(i θ_j).
  /// omega: ω_j, rad/s. n values each. Allocates nothing.
  EndsMotion<Real> accelerations(const Rotation<Real>* e, const Real* omega, const EndedActing<Real>& acting,
                                 const InnerEnd<Real>& inner, const Tip<Real>& tip, Real* alpha,
                                 Real* moments) {
    EndedPin<Real> shown;
    for (std::size_t j = bodies_.size(); j-- > 0;) {
      Swept& body = bodies_[j];
      body.at = turned(body.of, e[j], omega[j]);
      body.joint = numbersOf(acting.joints[j]);
      sweep(body, acting.N[j], shown);
      if (acting.F) shown.pin.b -= acting.F[j];
    }
    const auto motion = EndsEquations<Real>(shown, inner, acting.base, acting.turning).solve(tip);
    Vec2<Real> a = motion.pinAcceleration;
    Real turning = acting.turning;
    for (std::size_t j = 0; j < bodies_.size(); ++j) {
      moments[j] = answer(bodies_[j], motion.tipForce, a, turning);
      alpha[j] = turning;
    }
    return motion;
  }

  /// The motion of least kinetic energy, rotors included, that moves the tip along its rows by
  /// tip.acceleration: an impulse on the chain at rest. It projects rates (m/s, then rad/s and N s) and
  /// angles (m, then rad). Held joints and held slides do not move. Writes the changes of the bodies, and
  /// returns those of the slides, `acceleration`, with the impulse, `tipForce`. Allocates nothing.
  EndsMotion<Real> impulse(const Rotation<Real>* e, const Coupling<Real>* joints, InnerEnd<Real> inner,
                           const Tip<Real>& tip, Real* change) {
    EndedPin<Real> shown;
    for (std::size_t j = bodies_.size(); j-- > 0;) {
      Swept& body = bodies_[j];
      body.at = turned(body.of, e[j], Real(0));
      body.joint = numbersOf(joints[j]);
      body.joint.acceleration = Real(0);
      sweep(body, Real(0), shown);
    }
    for (Slide<Real>& slide : inner.slide) slide.force = slide.acceleration = Real(0);
    const auto motion = EndsEquations<Real>(shown, inner, {}, Real(0)).solve(tip);
    Vec2<Real> a = motion.pinAcceleration;
    Real turning{};
    for (std::size_t j = 0; j < bodies_.size(); ++j) {
      answer(bodies_[j], motion.tipForce, a, turning);
      change[j] = turning;
    }
    return motion;
  }

 private:
  struct Swept {
    Body<Real> of;
    Turned<Real> at;
    JointAt<Real> joint;
    CoupledHandle<Real> handle;
    Vec2<Real> g;
  };

  static void sweep(Swept& body, Real N, EndedPin<Real>& shown) {
    body.handle = inwards(body.at, N, body.joint, shown.pin);
    body.g = shown.pass(body.at, body.handle, body.joint.acceleration);
  }
  /// One body outwards; returns μ.
  static Real answer(const Swept& body, Vec2<Real> lambda, Vec2<Real>& a, Real& turning) {
    CoupledHandle<Real> handle = body.handle;
    handle.epsilon += dot(body.g, lambda);
    return outwards(handle, body.joint, body.at.P, body.at.ww, a, turning);
  }

  std::vector<Swept> bodies_;
};

}  // namespace planar_chain
