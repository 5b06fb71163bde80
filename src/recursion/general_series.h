#pragma once

/// The motion of a chain of revolute joints of any law (general.h) as a Taylor series: θ(t + h) = Σ θ_k h^k,
/// and so on.
///
/// With e_j = exp(i θ_j), a the acceleration of the inner pin (less gravity), f the force on the body there,
/// and μ the moment of the joint,
///
///     ë = i d(ω e)/dt           a_next = a + p ë           f = f_next + m (a + r ë) − F
///     (I + m|r|²) α + e×w = N + μ − μ_next                 w = m r̄ a + p̄ f_next
///
/// Order k of a product is Cauchy's sum over the orders of its factors. Only one term of each sum contains
/// α_k, and its factor depends on the present angles alone. So all orders have the same matrix, and the
/// recursion of general.h, at rest and without gravity, solves
///
///     M(θ_0) α_k = N_k − (e×w)_k at α_k = 0              joints with order k of q̈
///
/// Source: as lanes/motion_series.h, which has the series of chains whose joints do not couple.

#include <algorithm>
#include <vector>

#include "recursion/general_recursion.h"

namespace planar_chain {

class GeneralSeries {
 public:
  /// For orders 0 … orders − 1 of α. Allocates.
  GeneralSeries(const Chain& chain, int orders)
      : links_(chain.links()), n_(links_.size()), orders_(orders), recursion_(chain) {
    const std::size_t numbers = n_ * index(orders);
    omega_.resize(numbers);
    e_.resize(numbers + 2 * n_);
    w_.resize(numbers);
    second_.resize(n_);
    z_.resize(n_);
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
    for (std::size_t j = 0; j < n_; ++j) e_[n_ + j] = {-omega[j] * e[j].s, omega[j] * e[j].c};
    turn(0);
    complete(0, alpha, ground, F);
  }

  /// Takes order k > 0 of ω, N, F, of the joints' q̈ and of the base's acceleration. Writes α_k, n values.
  void find(int k, const double* omega, const double* N, const Vec2d* F, const JointLaw<double>* joints,
            Vec2d ground, double turning, double* alpha) {
    std::copy_n(omega, n_, row(omega_, k));
    turn(k);
    findForces(k, ground, F);
    std::copy_n(N, n_, left_.begin());
    for (int i = 0; i <= k; ++i) {
      const Rotation<double>* e = row(e_, i);
      const Vec2d* w = row(w_, k - i);
      for (std::size_t j = 0; j < n_; ++j) left_[j] -= e[j].c * w[j].y - e[j].s * w[j].x;
    }
    recursion_.accelerations({e_.data(), atRest_.data(), nullptr},
                             {left_.data(), nullptr, joints, {}, turning}, {}, alpha, moments_.data());
    complete(k, alpha, ground, F);
  }

 private:
  template <class Value>
  Value* row(std::vector<Value>& of, int k) {
    return of.data() + index(k) * n_;
  }

  /// From the orders of ω up to k: order k of ë, as if α_k were 0, and the sum z,
  ///
  ///     z = Σ_{j≤k} ω_j e_{k+1−j}          ë_k = i (α_k e_0 + (k+1) z)
  void turn(int k) {
    std::fill(z_.begin(), z_.end(), Vec2d{});
    for (int i = 0; i <= k; ++i) {
      const double* omega = row(omega_, i);
      const Rotation<double>* e = row(e_, k + 1 - i);
      for (std::size_t j = 0; j < n_; ++j) z_[j] += omega[j] * Vec2d{e[j].c, e[j].s};
    }
    for (std::size_t j = 0; j < n_; ++j) second_[j] = {-(k + 1) * z_[j].y, (k + 1) * z_[j].x};
  }

  /// Adds what α_k turns, and finds the next order of e:  (k+2) e_{k+2} = i (z + ω_{k+1} e_0)
  void complete(int k, const double* alpha, Vec2d ground, const Vec2d* F) {
    const double share = 1.0 / (k + 1), part = 1.0 / (k + 2);
    Rotation<double>* next = row(e_, k + 2);
    for (std::size_t j = 0; j < n_; ++j) {
      const Vec2d turn{-alpha[j] * e_[j].s, alpha[j] * e_[j].c};
      second_[j] = {second_[j].c + turn.x, second_[j].s + turn.y};
      next[j] = {part * (share * turn.x - z_[j].y), part * (share * turn.y + z_[j].x)};
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
  GeneralRecursion<double> recursion_;
  std::vector<double> omega_;
  std::vector<Rotation<double>> e_, second_;  ///< second_: ë, of one order
  std::vector<Vec2d> w_, a_, z_;
  std::vector<double> left_, moments_, atRest_;
};

}  // namespace planar_chain
