#pragma once

/// The exact linear solve of a chain with ends (ends.h): coupled_linearized.h has the recursion of its
/// bodies.
///
/// The places are s_i of the slides, then θ_1 … θ_n; u = σ + u' and v = s u' for both. A slide's force has
/// the tangent −k δs − d δṡ, and forces on its body have K and D of force_tangent.h. A change δλ of the tip's
/// force is linear in all that a body shows its inner pin, and so is the acceleration of the tip; beside the
/// terms without δλ,
///
///     δF_pin = … − G δλ          δμ = … − η·δλ          δa_tip = Σ Γ_k y_k + γ u'_parent + C δλ + c_t
///
/// The change is not symmetric, so (G, η) and (Γ, γ) are two pairs. Inwards from G = Γ_a = 1 and zeros,
///
///     e = Gᵀ iP + η                 g = γ + Σ Γ_k z_k P               u' = … + e·δλ/D
///     C ← C + g eᵀ/D                c_t ← c_t + Σ Γ_k w_k P + g (ε/D, or w of a held joint)
///     G ← G − U_R eᵀ/D              Γ_k ← Γ_k − g U_L,kᵀ/D            η ← k̂ e/D     γ ← k̂ g/D
///
/// Slide j moves by Y_j, the sum over its own rail and those further in, and the first pin by y, that of the
/// last slide. The rails turn with the base at φ̇ and φ̈, and w = iφ̈ − φ̇²:
///
///     Y_a = Σ (s² + 2 φ̇ s i + w) d_i u'_i + (w σ_i − ρ_v,i) d_i
///     Y_v = Σ (s + i φ̇) d_i u'_i + i φ̇ d_i σ_i                     Y_x = Σ d_i (u'_i + σ_i)
///
/// With λ = Σ φ_j c_j of ended.h, four equations are left:
///
///     slide    d_i·(Σ B_k y_k + b − G δλ + Σ_{j ≥ i} δf_j) + k_i σ_i + (k_i + s d_i) u'_i = 0,
///              δf_j = m_j Y_a + D Y_v + K Y_x                     or of a held slide u'_i = ρ_v,i/s²
///     row      c_j·δa_tip = 0
///
/// With X_j, c_j and f_j of rails.h, the moment of the base about the ground pin, beside that in joint 1,
/// changes by Σ (δX_j×f_j + X_j×δf_j + c_j×m_j Y_a) + δX×F_pin + X×δF_pin, X of the first pin.
///
/// The rows do not change with the state: where a direction of the tip does not act (ended.h), it is left
/// out.
///
/// Source: derived as in linearized.h. Against Newton's and Euler's equations: ended_linearized_test.

#include <Eigen/LU>

#include "recursion/coupled_linearized.h"
#include "recursion/ends.h"

namespace planar_chain {

/// The ends at the state of the solve.
struct EndsTangent {
  InnerEnd<double> inner;                    ///< forces and accelerations are not read
  PerEnd<double> stiffness{}, damping{};     ///< k, d of the slides: N/m, N s/m
  Tip<double> tip;                           ///< EndsMotion::acting; its acceleration is not read
  PerEnd<Matrix2d> ofPlace{}, ofVelocity{};  ///< K, D of the forces on slides: N/m, N s/m
  bool turns = false;                        ///< the base turns: what follows is read
  double rate = 0, turning = 0;              ///< φ̇, φ̈
  PerEnd<Vec2d> place{}, com{}, force{};     ///< X_j, c_j and f_j
  Vec2d firstPin, pinForce;                  ///< X and F_pin
};

/// CoupledState has ground = EndsMotion::pinAcceleration and tip = EndsMotion::tipForce. kinds: 3, or 1 if no
/// force on a body depends on place or velocity.
template <class Scalar, std::size_t kinds>
class EndedLinearized : public CoupledLinearized<Scalar, kinds> {
  using Open = CoupledLinearized<Scalar, kinds>;

 public:
  /// All must outlive this object; factor() reads them.
  EndedLinearized(const CoupledBodies& bodies, const ForceTangent* tangents, const EndsTangent& ends)
      : Open(bodies, tangents), ends_(ends), tips_(bodies.size()) {}

  void factor(Scalar s) override {
    Open::factor(s);
    sweepTip();
    findMatrix();
  }

  /// One value more per slide.
  void solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v) override {
    PerEnd<Scalar> sigma{}, drift{};
    for (std::size_t i = 0; i < slides(); ++i) {
      sigma[i] = *rhoQ++ / s_();
      drift[i] = -*rhoV++;
    }
    Open::carryInwards(rhoQ, rhoV);
    Vec2<Scalar> tip;
    for (std::size_t j = 0; j < tips_.size(); ++j) {
      const AtTip& at = tips_[j];
      tip = mulAdd(this->handles_[j].turn, at.g, mulAdd(rhoQ[j] / s_(), at.Eq, mulAdd(-rhoV[j], at.Ev, tip)));
    }
    Moved y = drifts(sigma, drift);
    const Column x = matrix_.solve(rest(y, tip, sigma, drift));

    tipForce_ = {};
    for (int j = 0; j < ends_.tip.rows; ++j) tipForce_ += x[2 + j] * wide(ends_.tip.row[index(j)]);
    for (std::size_t j = 0; j < tips_.size(); ++j) {
      this->handles_[j].turn += dot(tips_[j].eD, tipForce_);
      this->moments_[j] -= dot(tips_[j].eta, tipForce_);
    }
    const PerEnd<Scalar> turn{x[0], x[1]};
    for (std::size_t i = 0; i < slides(); ++i) {
      add(turns_[i], turn[i], y.last);
      if (i == 0 && slides() == 2) add(turns_[0], turn[0], y.inner);
    }
    this->pinForce_ += force(y.last) - times(G_, tipForce_);
    for (std::size_t i = 0; i < slides(); ++i) {
      const PerEnd<double>&k = ends_.stiffness, &d = ends_.damping;
      moved_ = y;
      slideForces_[i] =
          slide(i).isHeld ? effort(i, y, this->pinForce_) : -k[i] * sigma[i] - (k[i] + s_() * d[i]) * turn[i];
    }
    Open::carryOutwards(rhoQ, rhoV, y.last, u + slides(), v + slides());
    for (std::size_t i = 0; i < slides(); ++i) {
      u[i] = sigma[i] + turn[i];
      v[i] = s_() * turn[i];
      along_[i] = u[i];
    }
  }

  /// Of a slide the force along its rail, with springs and dampers.
  Scalar moment(int i) const override {
    const int slides = ends_.inner.slides;
    return i < slides ? slideForces_[index(i)] : Open::moment(i - slides);
  }
  /// With slides: on the base, which moves their masses too.
  Vec2<Scalar> pinForce() const override {
    const Vec2<Scalar> pin = Open::pinForce();
    return slides() > 0 ? onSlides(moved_, pin, true) : pin;
  }
  Vec2<Scalar> tipForce() const override { return tipForce_; }
  Scalar baseMoment() const override {
    const PerEnd<Vec2d>&X = ends_.place, &c = ends_.com, &f = ends_.force;
    Vec2<Scalar> slid;
    Scalar moment{};
    for (std::size_t i = 0; i < slides(); ++i) {
      const Motion& own = i + 1 < slides() ? moved_.inner : moved_.last;
      slid += along_[i] * wide(slide(i).d);
      moment += cross(X[i], onSlide(i, own)) + slide(i).mass * cross(c[i], own[0]) - cross(f[i], slid);
    }
    return moment + cross(ends_.firstPin, Open::pinForce()) - cross(ends_.pinForce, slid);
  }

 private:
  using Motion = PerMotion<Vec2<Scalar>, kinds>;
  /// Of the last slide, and of the first of two.
  struct Moved {
    Motion last{}, inner{};
  };
  using Matrix = Eigen::Matrix<Scalar, 4, 4>;
  using Column = Eigen::Matrix<Scalar, 4, 1>;
  /// eD: e/D. Ev, Eq: how c_t changes with −ρ_v and σ of a body.
  struct AtTip {
    Vec2<Scalar> eD, eta, g, Ev, Eq;
  };

  void sweepTip() {
    G_ = C_ = {};
    G_.xx = G_.yy = Scalar(1);
    Gamma_ = {};
    Gamma_[0] = G_;
    Vec2<Scalar> eta, gamma;
    for (std::size_t j = tips_.size(); j-- > 0;) {
      const BodyAt<double>& body = this->bodies_[j];
      const typename Open::Handle& handle = this->handles_[j];
      AtTip& at = tips_[j];
      const Vec2<Scalar> e = transposedTimes(G_, wide(perp(body.P))) + eta;
      const auto z = turnsOf<kinds>(body, s_());
      const auto w = driftsOf<kinds>(body);
      at.Ev = times(Gamma_[0], wide(perp(body.P)));
      at.g = gamma;
      at.Eq = {};
      for (std::size_t k = 0; k < kinds; ++k) {
        at.g += times(Gamma_[k], turnScale(z[k], body.P));
        at.Eq += times(Gamma_[k], wide(turnScale(w[k], body.P)));
      }
      for (std::size_t k = 0; k < kinds; ++k) subtract(at.g, handle.ULD[k], Gamma_[k]);
      at.eD = handle.over * e;
      at.eta = eta = handle.kD * e;
      gamma = handle.kD * at.g;
      subtract(Scalar(-1) * at.g, at.eD, C_);
      subtract(handle.UR, at.eD, G_);
    }
  }

  void findMatrix() {
    Matrix E = Matrix::Identity();
    for (std::size_t i = 0; i < slides(); ++i) {
      const Motion& y = turns_[i] = turns(i);
      const Vec2<Scalar> pin = force(y), tip = tipBy(y);
      for (std::size_t to = 0; to < slides(); ++to) {
        if (slide(to).isHeld) continue;
        E(Eigen::Index(to), Eigen::Index(i)) = effort(to, {y, i == 0 ? y : Motion{}}, pin);
      }
      if (!slide(i).isHeld)
        E(Eigen::Index(i), Eigen::Index(i)) += ends_.stiffness[i] + s_() * ends_.damping[i];
      for (int j = 0; j < ends_.tip.rows; ++j)
        E(2 + j, Eigen::Index(i)) = dotMixed(ends_.tip.row[index(j)], tip);
    }
    for (int j = 0; j < ends_.tip.rows; ++j) {
      const Vec2<Scalar> c = wide(ends_.tip.row[index(j)]), pin = times(G_, c), tip = times(C_, c);
      for (std::size_t i = 0; i < slides(); ++i) {
        if (!slide(i).isHeld) E(Eigen::Index(i), 2 + j) = -dotMixed(slide(i).d, pin);
      }
      for (int to = 0; to < ends_.tip.rows; ++to) E(2 + to, 2 + j) = dotMixed(ends_.tip.row[index(to)], tip);
    }
    matrix_.compute(E);
  }

  /// The right-hand side of the four equations.
  Column rest(const Moved& y, Vec2<Scalar> tip, const PerEnd<Scalar>& sigma,
              const PerEnd<Scalar>& drift) const {
    Column rest = Column::Zero();
    const Vec2<Scalar> pin = force(y.last) + this->pinForce_, moved = tipBy(y.last) + tip;
    for (std::size_t i = 0; i < slides(); ++i) {
      rest[Eigen::Index(i)] =
          slide(i).isHeld ? -drift[i] / (s_() * s_()) : -effort(i, y, pin) - ends_.stiffness[i] * sigma[i];
    }
    for (int j = 0; j < ends_.tip.rows; ++j) rest[2 + j] = -dotMixed(ends_.tip.row[index(j)], moved);
    return rest;
  }

  Scalar s_() const { return Open::s_; }
  std::size_t slides() const { return index(ends_.inner.slides); }
  const Slide<double>& slide(std::size_t i) const { return ends_.inner.slide[i]; }

  /// Y if u'_i = 1.
  Motion turns(std::size_t i) const {
    const Vec2d d = slide(i).d, across = ends_.turns ? ends_.rate * perp(d) : Vec2d{};
    const Vec2<Scalar> a = mulAdd(s_() * s_(), d, mulAdd(s_() + s_(), across, wide(drifting(i))));
    if constexpr (kinds == 1)
      return {a};
    else
      return {a, mulAdd(s_(), d, wide(across)), wide(d)};
  }
  /// Y_a if σ_i = 1.
  Vec2d drifting(std::size_t i) const {
    const Vec2d d = slide(i).d;
    return ends_.turns ? ends_.turning * perp(d) - (ends_.rate * ends_.rate) * d : Vec2d{};
  }
  /// Y if all u' = 0.
  Moved drifts(const PerEnd<Scalar>& sigma, const PerEnd<Scalar>& drift) const {
    Moved y;
    for (std::size_t i = 0; i < slides(); ++i) {
      const Vec2d d = slide(i).d;
      y.last[0] += drift[i] * wide(d);
      if constexpr (kinds == 3) y.last[2] += sigma[i] * wide(d);
      if (ends_.turns) {
        y.last[0] += sigma[i] * wide(drifting(i));
        if constexpr (kinds == 3) y.last[1] += (ends_.rate * sigma[i]) * wide(perp(d));
      }
      if (i == 0 && slides() == 2) y.inner = y.last;
    }
    return y;
  }
  static void add(const Motion& more, Scalar factor, Motion& y) {
    for (std::size_t k = 0; k < kinds; ++k) y[k] += factor * more[k];
  }
  Vec2<Scalar> force(const Motion& y) const { return sum(this->shown_.B, y); }
  Vec2<Scalar> tipBy(const Motion& y) const { return sum(Gamma_, y); }
  static Vec2<Scalar> sum(const PerMotion<Matrix2<Scalar>, kinds>& M, const Motion& y) {
    Vec2<Scalar> total;
    for (std::size_t k = 0; k < kinds; ++k) total += times(M[k], y[k]);
    return total;
  }
  /// δf_i of slide i, which moves by y.
  Vec2<Scalar> onSlide(std::size_t i, const Motion& y) const {
    Vec2<Scalar> change = slide(i).mass * y[0];
    if constexpr (kinds == 3)
      change += timesMixed(ends_.ofPlace[i], y[2]) + timesMixed(ends_.ofVelocity[i], y[1]);
    return change;
  }
  /// The change of the force along rail i; pin: of the force on the first body.
  Scalar effort(std::size_t i, const Moved& y, Vec2<Scalar> pin) const {
    return dotMixed(slide(i).d, onSlides(y, pin, i == 0));
  }
  /// The change of what moves the last slide, or all, and the bodies.
  Vec2<Scalar> onSlides(const Moved& y, Vec2<Scalar> pin, bool all) const {
    Vec2<Scalar> change = pin + onSlide(slides() - 1, y.last);
    if (all && slides() == 2) change += onSlide(0, y.inner);
    return change;
  }

  /// a×b
  static Scalar cross(Vec2d a, Vec2<Scalar> b) { return dotMixed(perp(a), b); }
  static Vec2<Scalar> timesMixed(const Matrix2d& M, Vec2<Scalar> a) {
    return {M.xx * a.x + M.xy * a.y, M.yx * a.x + M.yy * a.y};
  }
  static Vec2<Scalar> wide(Vec2d a) { return {Scalar(a.x), Scalar(a.y)}; }
  static Vec2<Scalar> times(const Matrix2<Scalar>& M, Vec2<Scalar> a) { return M.times(a, Vec2<Scalar>{}); }
  /// Subtracts a bᵀ.
  static void subtract(Vec2<Scalar> a, Vec2<Scalar> b, Matrix2<Scalar>& M) {
    M = {M.xx - a.x * b.x, M.xy - a.x * b.y, M.yx - a.y * b.x, M.yy - a.y * b.y};
  }

  const EndsTangent& ends_;
  std::vector<AtTip> tips_;
  Matrix2<Scalar> G_, C_;
  PerMotion<Matrix2<Scalar>, kinds> Gamma_;
  Eigen::PartialPivLU<Matrix> matrix_{Matrix(Matrix::Identity())};
  PerEnd<Motion> turns_{};
  // Along the last solution:
  PerEnd<Scalar> slideForces_{}, along_{};  ///< along_: δs
  Vec2<Scalar> tipForce_;
  Moved moved_;
};

}  // namespace planar_chain
