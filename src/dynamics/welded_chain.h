#pragma once

/// A chain whose joints slip or stick, without rotors, drives and forces, and on a base at rest. Bodies that
/// stick together are one body, so a plain chain of fewer bodies is left. It runs in segments (segments.h).
///
/// The bodies a … b, with angles q of the stuck joints between them, in the axes of a:
///
///     φ_a = 0, φ_j = φ_{j−1} + q_j      x_a = 0, x_{j+1} = x_j + exp(i φ_j) p_j      p = x_{b+1}
///     r_j' = x_j + exp(i φ_j) r_j       m = Σ m_j, r = Σ m_j r_j' / m                N = Σ N_j
///     I = Σ I_j + m_j |r_j' − r|²
///
/// Bodies that stick to the ground do not move. The moments μ of stuck joints follow from sums over the links
/// k = j … b, made when they are welded; μ = 0 in the other joints. F is the force on the next body, and a
/// the acceleration of x_a; all in the axes of body a:
///
///     S = Σ m_k (r_k' − x_j)      Q = Σ I_k + m_k |r_k' − x_j|²      D = x_{b+1} − x_j
///     μ_j = S×a + α K − ω² L + D×F − Σ N_k          K = Q + S·x_j      L = S×x_j

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

#include "effects/effect.h"
#include "lanes/kernel.h"
#include "lanes/lane_order.h"
#include "planar_chain/chain.h"
#include "recursion/articulated.h"
#include "simd/cache_lines.h"

namespace planar_chain {

/// Only the constructor allocates. Arguments are in chain order.
class WeldedChain {
 public:
  /// The chain must outlive this object.
  WeldedChain(const Chain& chain, const simd::Kernel& kernel) : chain_(chain), kernel_(kernel) {
    const auto n = index(chain.size()), paddedSize = n + index(kernel_.lanes);
    for (const Link& link : chain.links()) bodies_.push_back({link.mass, link.inertia, link.com, link.pin});
    welded_.reserve(n);
    first_.reserve(n + 1);
    laneIndexOf_.resize(n);
    laneIndexOfLink_.resize(n);
    sticks_.resize(n);
    stuck_.resize(n);
    several_.reserve(n);
    turns_.resize(n);
    angles_.resize(n);
    links_.resize(paddedSize * simd::SegmentArrays::linkQuantities);
    factors_.resize(paddedSize * simd::SegmentArrays::factorQuantities);
    for (auto* numbers : {&theta_, &omega_, &N_, &alpha_}) numbers->resize(paddedSize + 1);
    pins_.resize(paddedSize * simd::SegmentArrays::pinQuantities);
    e_.resize(2 * paddedSize);
  }

  std::string name() const {
    return "in " + std::to_string(kernel_.lanes) + " segments side by side (" + kernel_.name +
           "), stuck joints welded";
  }
  /// Takes the joints that stick from now on, and their angles.
  void weld(const Couplings& at) {
    // The pins of the bodies, outwards.
    welded_.clear();
    first_.clear();
    several_.clear();
    groundPin_ = {};
    Vec2d* pin = &groundPin_;
    Rotation<double> e;
    for (std::size_t j = 0; j < bodies_.size(); ++j) {
      sticks_[j] = at.joints[j].isPrescribed;
      if (!sticks_[j]) {
        e = {};
        first_.push_back(j);
        pin = &welded_.emplace_back(bodies_[j]).p;
        continue;
      }
      if (const double q = at.prescribed[j].value; angles_[j] != q) {
        angles_[j] = q;
        turns_[j] = Rotation<double>::of(q);
      }
      e = e * turns_[j];
      stuck_[j].x = *pin;
      stuck_[j].S = e * bodies_[j].r;
      *pin += e * bodies_[j].p;
    }
    first_.push_back(bodies_.size());
    sumStuck();
    putInLaneOrder();
  }
  /// Writes α of all bodies. N: nullptr: the same as last time since weld().
  void accelerations(const double* theta, const double* omega, const double* N, double* alpha) {
    for (std::size_t body = 0; body < welded_.size(); ++body) {
      const std::size_t laneIndex = index(laneIndexOf_[body]), first = first_[body];
      theta_[laneIndex] = theta[first];
      omega_[laneIndex] = omega[first];
    }
    for (std::size_t body = 0; N && body < welded_.size(); ++body) {
      const auto sum = std::accumulate(N + first_[body] + 1, N + first_[body + 1], N[first_[body]]);
      N_[index(laneIndexOf_[body])] = sum;
    }
    if (steps_ > 0) {
      kernel_.rotations(theta_.data(), e_.data(), steps_ * kernel_.lanes);
      kernel_.segments({steps_, links_.data(), factors_.data()}, e_.data(), omega_.data(), N_.data(), nullptr,
                       -1.0 * chain_.gravity(), alpha_.data());
    }
    for (std::size_t j = 0; j < laneIndexOfLink_.size(); ++j) alpha[j] = alpha_[index(laneIndexOfLink_[j])];
  }
  /// Writes μ of all joints, at the state of the last accelerations().
  void moments(const double* N, double* mu) {
    std::fill_n(mu, bodies_.size(), 0.0);
    const Vec2d ground = -1.0 * chain_.gravity();
    Vec2d onFirst;
    if (steps_ > 0) {
      onFirst = kernel_.pins({steps_, links_.data(), factors_.data()}, e_.data(), omega_.data(),
                             alpha_.data(), ground, pins_.data());
    }
    const std::size_t lanes = index(kernel_.lanes);
    for (const std::size_t body : several_) {
      const std::size_t laneIndex = index(laneIndexOf_[body]), lane = laneIndex % lanes;
      const double* pin = pins_.data() + (laneIndex - lane) * simd::SegmentArrays::pinQuantities + lane;
      const Rotation<double> back{e_[2 * laneIndex], -e_[2 * laneIndex + 1]};
      const Vec2d a{pin[0], pin[lanes]}, F{pin[2 * lanes], pin[3 * lanes]};
      writeMoments(first_[body] + 1, first_[body + 1], back * a, back * F, alpha_[laneIndex],
                   omega_[laneIndex] * omega_[laneIndex], N, mu);
    }
    writeMoments(0, first_.front(), ground, onFirst, 0, 0, N, mu);
  }

 private:
  /// Sums over the links that stick together, inwards. Before, S of each stuck link is exp(i φ_j) r_j.
  void sumStuck() {
    std::size_t body = welded_.size();
    double m = 0, Q = 0;
    Vec2d S, inner;
    const auto add = [&](const Body<double>& link, Vec2d pin, Vec2d com) {
      const Vec2d step = inner - pin;
      Q += 2 * dot(step, S) + m * dot(step, step) + link.I + link.m * dot(com, com);
      S += m * step + link.m * com;
      m += link.m;
      inner = pin;
    };
    for (std::size_t j = bodies_.size(); j-- > 0;) {
      if (sticks_[j]) {
        const Vec2d pin = stuck_[j].x, outer = body > 0 ? welded_[body - 1].p : groundPin_;
        add(bodies_[j], pin, stuck_[j].S);
        stuck_[j] = {pin, S, outer - pin, Q + dot(S, pin), cross(S, pin)};
        continue;
      }
      --body;
      if (m > 0) {
        add(bodies_[j], {}, bodies_[j].r);
        const Vec2d com = (1 / m) * S;
        welded_[body] = {m, Q - dot(com, S), com, welded_[body].p};
      }
      m = Q = 0;
      S = {};
    }
  }
  /// Writes the bodies in lane order.
  void putInLaneOrder() {
    const std::size_t lanes = index(kernel_.lanes), count = welded_.size(),
                      steps = (count + lanes - 1) / lanes;
    steps_ = static_cast<int>(steps);
    std::size_t body = 0;
    const int ground = static_cast<int>(alpha_.size()) - 1;
    std::fill_n(laneIndexOfLink_.begin(), first_.front(), ground);
    for (std::size_t k = 0; k < count; ++k) {
      if (first_[k + 1] > first_[k] + 1) several_.push_back(k);
    }
    alpha_[index(ground)] = 0;
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      for (std::size_t step = 0; step < steps; ++step, ++body) {
        const auto& [m, I, r, p] = body < count ? welded_[body] : Body<double>{0, 1, {}, {}};
        if (body < count) {
          laneIndexOf_[body] = static_cast<int>(step * lanes + lane);
          for (std::size_t j = first_[body]; j < first_[body + 1]; ++j)
            laneIndexOfLink_[j] = laneIndexOf_[body];
        }
        putInLane(links_.data(), step * lanes + lane, lanes, {m, I, r.x, r.y, p.x, p.y});
      }
    }
    for (auto* numbers : {&theta_, &omega_, &N_}) std::fill(numbers->begin(), numbers->end(), 0.0);
  }
  /// Writes the moments mu of the joints within a body, inwards.
  void writeMoments(std::size_t from, std::size_t to, Vec2d a, Vec2d F, double alpha, double ww,
                    const double* N, double* mu) const {
    double sum = 0;
    for (std::size_t j = to; j-- > from;) {
      const auto& [x, S, D, K, L] = stuck_[j];
      sum += N[j];
      mu[j] = cross(S, a) + alpha * K - ww * L + cross(D, F) - sum;
    }
  }

  const Chain& chain_;
  const simd::Kernel& kernel_;
  int steps_ = 0;                     ///< of the segments
  std::vector<Body<double>> bodies_;  ///< of the links,
  std::vector<Body<double>> welded_;  ///< and of the welded chain,
  Vec2d groundPin_;                   ///< and the outer pin of what sticks to the ground
  std::vector<std::size_t> first_;    ///< the first link of each, and their end
  std::vector<int> laneIndexOf_;      ///< of each in lane order,
  std::vector<int> laneIndexOfLink_;  ///< and of the body that has each link; that of the ground is the last
  std::vector<char> sticks_;          ///< the joints, true or false
  std::vector<double> angles_;        ///< of the joints when they stuck last, from body to body,
  std::vector<Rotation<double>> turns_;  ///< and their rotations
  struct Stuck {
    Vec2d x{}, S{}, D{};
    double K = 0, L = 0;
  };
  std::vector<Stuck> stuck_;          ///< of the links that stick to the one before
  std::vector<std::size_t> several_;  ///< the bodies of several links
  CacheLines links_, factors_, pins_, theta_, omega_, N_, alpha_, e_;
};

}  // namespace planar_chain
