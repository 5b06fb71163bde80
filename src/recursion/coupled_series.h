#pragma once

/// The motion of a chain with coupled joints (coupled.h) as a Taylor series: θ(t + h) = Σ θ_k h^k, and so on.
///
/// With e_j = exp(i θ_j), a the acceleration of the inner pin (less gravity), f the force on the body there,
/// and μ the moment of the joint,
///
///     ë = i d(ω e)/dt           a_next = a + p ë           f = f_next + m (a + r ë) − F
///     (I + m|r|²) α + e×w = N + μ − μ_next                 w = m r̄ a + p̄ f_next
///
/// Order k of a product is Cauchy's sum over the orders of its factors. Only one term of each sum contains
/// α_k, and its factor depends on the present angles alone. So all orders have the same matrix, and the
/// recursion of coupled.h, at rest and without gravity, solves
///
///     M(θ_0) α_k = N_k − (e×w)_k at α_k = 0              joints with order k of q̈
///
/// Source: as lanes/motion_series.h, which has the series of chains whose joints do not couple.

#include <vector>

#include "recursion/coupled.h"

namespace planar_chain {

class CoupledSeries {
 public:
  /// For orders 0 … orders − 1 of α. Allocates.
  CoupledSeries(const Chain& chain, int orders)
      : links_(chain.links()), n_(links_.size()), orders_(orders), recursion_(chain) {
    const std::size_t numbers = n_ * index(orders);
    omega_.resize(numbers);
    e_.resize(numbers + n_);
    w_.resize(numbers);
    second_.resize(n_);
    a_.resize(n_);
    left_.resize(n_);
    moments_.resize(n_);
    atRest_.resize(n_);
  }

  int orders() const { return orders_; }
  /// Row k of n values: order k of e.
  const Rotation<double>* rotations() const { return e_.data(); }

  /// Takes order 0. ground: the acceleration of the ground pin less gravity. F: nullptr if no force acts.
  void begin(const Rotation<double>* e, const double* omega, const double* alpha, Vec2d ground,
             const Vec2d* F) {
    std::copy_n(e, n_, e_.begin());
    std::copy_n(omega, n_, omega_.begin());
    turn(0);
    complete(0, alpha, ground, F);
  }

  /// Takes order k > 0 of ω, N, F, of the joints' q̈ and of the base's acceleration. Writes α_k, n values.
  void find(int k, const double* omega, const double* N, const Vec2d* F, const Coupling<double>* joints,
            Vec2d ground, double turning, double* alpha) {
    std::copy_n(omega, n_, row(omega_, k));
    turn(k);
    findForces(k, ground, F);
    for (std::size_t j = 0; j < n_; ++j) {
      left_[j] = N[j];
      for (int i = 0; i <= k; ++i) {
        const Rotation<double>& e = row(e_, i)[j];
        left_[j] -= cross(Vec2d{e.c, e.s}, row(w_, k - i)[j]);
      }
    }
    recursion_.accelerations(e_.data(), atRest_.data(), left_.data(), nullptr, joints, {}, turning, alpha,
                             moments_.data());
    complete(k, alpha, ground, F);
  }

 private:
  template <class Number>
  Number* row(std::vector<Number>& of, int k) {
    return of.data() + index(k) * n_;
  }

  /// From the orders of ω up to k: order k + 1 of e, and order k of ë as if α_k were 0,
  ///
  ///     (k+1) e_{k+1} = i Σ_{j≤k} ω_j e_{k−j}          ë_k = (k+1) i (Σ_{j≤k} ω_j e_{k+1−j} + ω_{k+1} e_0)
  void turn(int k) {
    const double next = k + 1;
    for (std::size_t j = 0; j < n_; ++j) {
      const auto sum = [&](int order) {
        Vec2d z;
        for (int i = 0; i <= k; ++i) {
          const Rotation<double>& e = row(e_, order - i)[j];
          z += row(omega_, i)[j] * Vec2d{e.c, e.s};
        }
        return perp(z);
      };
      const Vec2d e = 1 / next * sum(k);
      row(e_, k + 1)[j] = {e.x, e.y};
      const Vec2d second = next * sum(k + 1);
      second_[j] = {second.x, second.y};
    }
  }

  /// Adds what α_k turns: ω_{k+1} = α_k/(k+1).
  void complete(int k, const double* alpha, Vec2d ground, const Vec2d* F) {
    for (std::size_t j = 0; j < n_; ++j) {
      second_[j].c -= alpha[j] * e_[j].s;
      second_[j].s += alpha[j] * e_[j].c;
    }
    findForces(k, ground, F);
  }

  /// Order k of w.
  void findForces(int k, Vec2d ground, const Vec2d* F) {
    Vec2d a = ground;
    for (std::size_t j = 0; j < n_; ++j) {
      a_[j] = a;
      a += second_[j] * links_[j].pin;
    }
    Vec2d f;
    for (std::size_t j = n_; j-- > 0;) {
      const Link& link = links_[j];
      row(w_, k)[j] = link.mass * conjugateTimes(link.com, a_[j]) + conjugateTimes(link.pin, f);
      f += link.mass * (a_[j] + second_[j] * link.com);
      if (F) f -= F[j];
    }
  }

  static Vec2d conjugateTimes(Vec2d r, Vec2d a) { return {dot(r, a), cross(r, a)}; }

  const std::vector<Link>& links_;
  std::size_t n_;
  int orders_;
  Coupled<double> recursion_;
  std::vector<double> omega_;
  std::vector<Rotation<double>> e_, second_;  ///< second_: ë, of one order
  std::vector<Vec2d> w_, a_;
  std::vector<double> left_, moments_, atRest_;
};

}  // namespace planar_chain
