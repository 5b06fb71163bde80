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
  Vec2<Real> tipForce;          ///< λ, N
  Tip<Real> acting;             ///< the tip with those directions alone that act
};

/// The equations of the ends. Allocates nothing.
template <class Real>
class EndsEquations {
 public:
  /// base: a_0. turning: angular acceleration of the base. The arguments must outlive this object.
  EndsEquations(const EndedPin<Real>& shown, const InnerEnd<Real>& inner, Vec2<Real> base, Real turning)
      : shown_(shown), inner_(inner), base_(base), turning_(turning) {
    if (inner.slides == 0) return;
    const Sym2<Real>& A = shown.pin.A;
    const Real m = inner.slide[index(inner.slides - 1)].mass;
    const Sym2<Real> whole{A.xx + m, A.xy, A.yy + m};
    const Vec2<Real> dx = rail(0), dy = rail(1);
    K_ = {isFree(0) ? dot(dx, whole * dx) + innerMass(0) : Real(1), dot(dx, whole * dy),
          isFree(1) ? dot(dy, whole * dy) : Real(1)};
  }

  void solve(const Tip<Real>& tip, EndsMotion<Real>& to) const {
    to.acceleration = {};
    to.pinAcceleration = base_;
    for (int i = 0; i < inner_.slides; ++i) {
      const Slide<Real>& slide = inner_.slide[index(i)];
      if (!slide.isHeld) continue;
      to.acceleration[index(i)] = slide.acceleration;
      to.pinAcceleration += slide.acceleration * slide.d;
    }
    to.pinForce = shown_.pin.A * to.pinAcceleration + turning_ * shown_.pin.H + shown_.pin.b;
    if (inner_.slides > 0) moveSlides({missing(0, to), missing(1, to)}, to);
    if (tip.rows > 0) holdTip(tip, to);
    for (int i = 0; i < inner_.slides; ++i) {
      const Slide<Real>& slide = inner_.slide[index(i)];
      to.force[index(i)] = slide.isHeld ? effort(i, to) : slide.force;
    }
  }

 private:
  bool isFree(int i) const { return i < inner_.slides && !inner_.slide[index(i)].isHeld; }
  /// d_i, or 0 if slide i is held.
  Vec2<Real> rail(int i) const { return isFree(i) ? inner_.slide[index(i)].d : Vec2<Real>{}; }
  /// m_1 of the first slide of two.
  Real innerMass(int i) const { return i == 0 && inner_.slides == 2 ? inner_.slide[0].mass : Real(0); }

  /// The force along rail i that such a motion takes.
  Real effort(int i, const EndsMotion<Real>& motion) const {
    const Real m = inner_.slide[index(inner_.slides - 1)].mass;
    Vec2<Real> force = motion.pinForce + m * motion.pinAcceleration;
    if (i == 0 && inner_.slides == 2) {
      force += inner_.slide[0].mass * (base_ + motion.acceleration[0] * inner_.slide[0].d);
    }
    return dot(inner_.slide[index(i)].d, force);
  }
  Real missing(int i, const EndsMotion<Real>& motion) const {
    return isFree(i) ? inner_.slide[index(i)].force - effort(i, motion) : Real(0);
  }
  /// The acceleration of the pin if the slides have these.
  Vec2<Real> pinUnder(Vec2<Real> slides) const { return slides.x * rail(0) + slides.y * rail(1); }
  Vec2<Real> alongRails(Vec2<Real> force) const { return {dot(rail(0), force), dot(rail(1), force)}; }
  /// Adds what such forces along the rails change.
  void moveSlides(Vec2<Real> forces, EndsMotion<Real>& to) const {
    const Vec2<Real> more = planar_chain::solve(K_, forces), a = pinUnder(more);
    to.acceleration = {to.acceleration[0] + more.x, to.acceleration[1] + more.y};
    to.pinAcceleration += a;
    to.pinForce += shown_.pin.A * a;
  }

  /// λ, and what it changes.
  void holdTip(const Tip<Real>& tip, EndsMotion<Real>& to) const {
    const Sym2<Real> L = tipAnswer();
    to.acting = actingPart(tip, L);
    const Vec2<Real> open = shown_.transposed(to.pinAcceleration) + turning_ * shown_.eta + shown_.tip;
    to.tipForce = tipForce(to.acting, L, tip.acceleration - open);
    const Vec2<Real> onPin = shown_.times(to.tipForce);
    to.pinForce -= onPin;
    if (inner_.slides > 0) moveSlides(alongRails(onPin), to);
  }
  /// C + Gᵀ d K⁻¹ dᵀ G
  Sym2<Real> tipAnswer() const {
    const auto& [pin, Gx, Gy, eta, tip, C] = shown_;
    if (inner_.slides == 0) return C;
    const auto pinUnderForce = [&](Vec2<Real> force) {
      return pinUnder(planar_chain::solve(K_, alongRails(force)));
    };
    const Vec2<Real> x = pinUnderForce(Gx), y = pinUnderForce(Gy);
    return {C.xx + dot(Gx, x), C.xy + dot(Gx, y), C.yy + dot(Gy, y)};
  }
  static Tip<Real> actingPart(const Tip<Real>& tip, const Sym2<Real>& L) {
    // The determinant shows at once that both directions act, unless they nearly do not. Any share far above
    // singularTip will do: below it, eigenvalues decide.
    constexpr double surely = 1e-6;
    const Real trace = L.xx + L.yy, determinant = L.xx * L.yy - L.xy * L.xy;
    if (tip.rows == 2 && determinant > Real(surely) * (trace * trace)) return tip;
    const auto [value, vector] = eigen(L);
    const Real least = Real(singularTip) * value[0];
    if (tip.rows == 2 && value[1] > least) return tip;
    Tip<Real> acting;
    acting.acceleration = tip.acceleration;
    const Vec2<Real> row = tip.rows == 2 ? vector[0] : tip.row[0];
    if (dot(row, L * row) > least) acting.row[index(acting.rows++)] = row;
    return acting;
  }
  /// λ that gives the tip so much more acceleration.
  static Vec2<Real> tipForce(const Tip<Real>& tip, const Sym2<Real>& L, Vec2<Real> rest) {
    if (tip.rows == 2) return planar_chain::solve(L, rest);
    if (tip.rows == 0) return {};
    const Vec2<Real> c = tip.row[0];
    return (dot(c, rest) / dot(c, L * c)) * c;
  }

  const EndedPin<Real>& shown_;
  const InnerEnd<Real>& inner_;
  Vec2<Real> base_;
  Real turning_;
  Sym2<Real> K_;
};

/// What the motion of a chain depends on, beside its angles and rates: n values each.
template <class Real>
struct EndedActing {
  const Real* N;        ///< moments, N m
  const Vec2<Real>* F;  ///< forces without gravity, N; nullptr: none
  const Coupling<Real>* joints;
  Vec2<Real> base;  ///< acceleration of the base less gravity, m/s²
  Real turning;     ///< its angular acceleration, rad/s²
};

/// Body by body, with any numbers. Simulations run lanes/coupled_chain.h.
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
      body.handle = inwards(body.at, acting.N[j], body.joint, shown.pin);
      if (acting.F) shown.pin.b -= acting.F[j];
      if (tip.rows > 0) pass(body, shown);
    }
    EndsMotion<Real> motion;
    EndsEquations<Real>(shown, inner, acting.base, acting.turning).solve(tip, motion);
    Vec2<Real> a = motion.pinAcceleration;
    Real turning = acting.turning;
    for (std::size_t j = 0; j < bodies_.size(); ++j) {
      Swept& body = bodies_[j];
      if (tip.rows > 0) body.handle.epsilon += dot(body.g, motion.tipForce);
      moments[j] = outwards(body.handle, body.joint, body.at.P, body.at.ww, a, turning);
      alpha[j] = turning;
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

  static void pass(Swept& body, EndedPin<Real>& shown) {
    const auto& [U, epsilon, inverseD, kappa, D0] = body.handle;
    body.g = shown.pass(body.at, U, inverseD, mulAdd(epsilon, inverseD, body.joint.acceleration));
    shown.eta = kappa * body.g;
    // Along a long crooked chain G shrinks exponentially. Denormal numbers, below 1e-308, would be slow.
    constexpr double small = 1e-280;
    for (Vec2<Real>* column : {&shown.Gx, &shown.Gy}) {
      if (dot(*column, *column) < Real(small)) *column = {};
    }
  }

  std::vector<Swept> bodies_;
};

}  // namespace planar_chain
