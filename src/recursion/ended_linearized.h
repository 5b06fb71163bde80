#pragma once

/// The exact linear solve of a chain with ends (ends.h): coupled_linearized.h has the recursion of its
/// bodies.
///
/// The places are s_i of the slides, then θ_1 … θ_n; u = σ + u' and v = s u' for both. A slide's force has
/// the tangent −k δs − d δṡ. A change δλ of the tip's force is linear in all that a body shows its inner pin,
/// and so is the acceleration of the tip; beside the terms without δλ,
///
///     δF_pin = … − G δλ          δμ = … − η·δλ          δa_tip = Σ Γ_k y_k + γ u'_parent + C δλ + c_t
///
/// The change is not symmetric, so (G, η) and (Γ, γ) are two pairs. Inwards from G = Γ_a = 1 and zeros,
///
///     e = Gᵀ iP + η                 g = γ + Σ Γ_k z_k P               u' = … + e·δλ/D
///     C ← C + g eᵀ/D                c_t ← c_t + Σ Γ_k w_k P + g (ε/D, or w of a held joint)
///     G ← G − U_R eᵀ/D              Γ_k ← Γ_k − g U_L,kᵀ/D            η ← k̂ e/D     γ ← k̂ g/D
///
/// The first pin moves by y = Σ d_i (s², s, 1) u'_i + d_i (−ρ_v, 0, σ)_i. With m_1, m_2 and λ = Σ φ_j c_j of
/// ended.h, four equations are left:
///
///     slide    d_i·(Σ B_k y_k + m_2 y_a + b − G δλ) + m_1 (s² u'_i − ρ_v,i), for i = 1 of two,
///              + k_i σ_i + (k_i + s d_i) u'_i = 0                 or of a held slide u'_i = ρ_v,i/s²
///     row      c_j·δa_tip = 0
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
  InnerEnd<double> inner;                 ///< forces and accelerations are not read
  PerEnd<double> stiffness{}, damping{};  ///< k, d of the slides: N/m, N s/m
  Tip<double> tip;                        ///< EndsMotion::acting; its acceleration is not read
};

/// CoupledState has ground = EndsMotion::pinAcceleration and tip = EndsMotion::tipForce. kinds: 3, or 1 if no
/// force on a body depends on place or velocity.
template <class Scalar, std::size_t kinds>
class EndedLinearized : public CoupledLinearized<Scalar, kinds> {
  using Open = CoupledLinearized<Scalar, kinds>;

 public:
  /// All must outlive this object; factor() reads them.
  EndedLinearized(const CoupledBodies& bodies, const std::vector<ForceTangent>& tangents,
                  const EndsTangent& ends)
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
    Motion y = drifts(sigma, drift);
    const Numbers x = matrix_.solve(rest(y, tip, sigma, drift));

    tipForce_ = {};
    for (int j = 0; j < ends_.tip.rows; ++j) tipForce_ += x[2 + j] * wide(ends_.tip.row[index(j)]);
    for (std::size_t j = 0; j < tips_.size(); ++j) {
      this->handles_[j].turn += dot(tips_[j].eD, tipForce_);
      this->moments_[j] -= dot(tips_[j].eta, tipForce_);
    }
    const PerEnd<Scalar> turn{x[0], x[1]};
    for (std::size_t i = 0; i < slides(); ++i) add(turns(i), turn[i], y);
    this->pinForce_ += force(y) - times(G_, tipForce_);
    for (std::size_t i = 0; i < slides(); ++i) {
      const PerEnd<double>&k = ends_.stiffness, &d = ends_.damping;
      slideForces_[i] = slide(i).isHeld ? effort(i, y[0], this->pinForce_, s_() * s_() * turn[0] + drift[0])
                                        : -k[i] * sigma[i] - (k[i] + s_() * d[i]) * turn[i];
    }
    ofLast_ = y[0];
    ofInner_ = s_() * s_() * turn[0] + drift[0];
    Open::carryOutwards(rhoQ, rhoV, y, u + slides(), v + slides());
    for (std::size_t i = 0; i < slides(); ++i) {
      u[i] = sigma[i] + turn[i];
      v[i] = s_() * turn[i];
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
    return slides() > 0 ? onSlides(ofLast_, pin, ofInner_, true) : pin;
  }
  Vec2<Scalar> tipForce() const override { return tipForce_; }

 private:
  using Motion = PerMotion<Vec2<Scalar>, kinds>;
  using Matrix = Eigen::Matrix<Scalar, 4, 4>;
  using Numbers = Eigen::Matrix<Scalar, 4, 1>;
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
      const Motion y = turns(i);
      const Vec2<Scalar> pin = force(y), tip = tipBy(y);
      for (std::size_t to = 0; to < slides(); ++to) {
        if (slide(to).isHeld) continue;
        const Scalar inner = i == 0 ? s_() * s_() : Scalar(0);
        E(Eigen::Index(to), Eigen::Index(i)) = effort(to, y[0], pin, inner);
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
  Numbers rest(const Motion& y, Vec2<Scalar> tip, const PerEnd<Scalar>& sigma,
               const PerEnd<Scalar>& drift) const {
    Numbers rest = Numbers::Zero();
    const Vec2<Scalar> pin = force(y) + this->pinForce_, moved = tipBy(y) + tip;
    for (std::size_t i = 0; i < slides(); ++i) {
      rest[Eigen::Index(i)] = slide(i).isHeld
                                  ? -drift[i] / (s_() * s_())
                                  : -effort(i, y[0], pin, drift[0]) - ends_.stiffness[i] * sigma[i];
    }
    for (int j = 0; j < ends_.tip.rows; ++j) rest[2 + j] = -dotMixed(ends_.tip.row[index(j)], moved);
    return rest;
  }

  Scalar s_() const { return Open::s_; }
  std::size_t slides() const { return index(ends_.inner.slides); }
  const Slide<double>& slide(std::size_t i) const { return ends_.inner.slide[i]; }

  /// y if u'_i = 1.
  Motion turns(std::size_t i) const {
    const Vec2<Scalar> d = wide(slide(i).d);
    if constexpr (kinds == 1)
      return {s_() * s_() * d};
    else
      return {s_() * s_() * d, s_() * d, d};
  }
  /// y if all u' = 0.
  Motion drifts(const PerEnd<Scalar>& sigma, const PerEnd<Scalar>& drift) const {
    Motion y{};
    for (std::size_t i = 0; i < slides(); ++i) {
      y[0] += drift[i] * wide(slide(i).d);
      if constexpr (kinds == 3) y[2] += sigma[i] * wide(slide(i).d);
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
  /// The change of the force along rail i; the others as in onSlides().
  Scalar effort(std::size_t i, Vec2<Scalar> last, Vec2<Scalar> pin, Scalar inner) const {
    return dotMixed(slide(i).d, onSlides(last, pin, inner, i == 0));
  }
  /// The change of what moves the last slide, or all, and the bodies. last: of the acceleration of the last
  /// slide. pin: of the force on the first body. inner: of the acceleration of the first slide along its
  /// rail.
  Vec2<Scalar> onSlides(Vec2<Scalar> last, Vec2<Scalar> pin, Scalar inner, bool all) const {
    Vec2<Scalar> change = mulAdd(slide(slides() - 1).mass, last, pin);
    if (all && slides() == 2) change += (slide(0).mass * inner) * wide(slide(0).d);
    return change;
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
  PerEnd<Scalar> slideForces_{};
  Vec2<Scalar> tipForce_, ofLast_;  ///< and the change of the acceleration of the last slide
  Scalar ofInner_{};                ///< the same of the first slide along its rail
};

}  // namespace planar_chain
