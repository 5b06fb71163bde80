#include "dynamics/welded_chain.h"

#include <algorithm>
#include <numeric>

#include "lanes/arrangement.h"
#include "lanes/kernel.h"

namespace planar_chain {

WeldedChain::WeldedChain(const Chain& chain) : chain_(chain), kernel_(simd::kernelFor(chain.size())) {
  const auto n = index(chain.size()), places = n + index(kernel_.lanes);
  for (const Link& link : chain.links()) bodies_.push_back({link.mass, link.inertia, link.com, link.pin});
  welded_.reserve(n);
  first_.reserve(n + 1);
  placeOf_.resize(n);
  placeOfLink_.resize(n);
  sticks_.resize(n);
  stuck_.resize(n);
  several_.reserve(n);
  turns_.resize(n);
  angles_.resize(n);
  links_.resize(places * simd::SegmentArrays::linkQuantities);
  handles_.resize(places * simd::SegmentArrays::handleQuantities);
  for (auto* numbers : {&theta_, &omega_, &N_, &alpha_}) numbers->resize(places + 1);
  pins_.resize(places * simd::SegmentArrays::pinQuantities);
  e_.resize(2 * places);
}

std::string WeldedChain::name() const {
  return "in " + std::to_string(kernel_.lanes) + " segments side by side (" + kernel_.name +
         "), stuck joints welded";
}

void WeldedChain::weld(const Couplings& at) {
  // The pins of the bodies, outwards.
  welded_.clear();
  first_.clear();
  several_.clear();
  groundPin_ = {};
  Vec2d* pin = &groundPin_;
  Rotation<double> e;
  for (std::size_t j = 0; j < bodies_.size(); ++j) {
    sticks_[j] = at.joints[j].isHeld;
    if (!sticks_[j]) {
      e = {};
      first_.push_back(j);
      pin = &welded_.emplace_back(bodies_[j]).p;
      continue;
    }
    if (const double q = at.held[j].value; angles_[j] != q) {
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
  arrange();
}

/// Sums over the links that stick together, inwards. Before, S of each stuck link is exp(i φ_j) r_j.
void WeldedChain::sumStuck() {
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
void WeldedChain::arrange() {
  const std::size_t lanes = index(kernel_.lanes), count = welded_.size(), steps = (count + lanes - 1) / lanes;
  steps_ = static_cast<int>(steps);
  std::size_t body = 0;
  const int ground = static_cast<int>(alpha_.size()) - 1;
  std::fill_n(placeOfLink_.begin(), first_.front(), ground);
  for (std::size_t k = 0; k < count; ++k) {
    if (first_[k + 1] > first_[k] + 1) several_.push_back(k);
  }
  alpha_[index(ground)] = 0;
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    for (std::size_t step = 0; step < steps; ++step, ++body) {
      const auto& [m, I, r, p] = body < count ? welded_[body] : Body<double>{0, 1, {}, {}};
      if (body < count) {
        placeOf_[body] = static_cast<int>(step * lanes + lane);
        for (std::size_t j = first_[body]; j < first_[body + 1]; ++j) placeOfLink_[j] = placeOf_[body];
      }
      putInLane(links_.data(), step * lanes + lane, lanes, {m, I, r.x, r.y, p.x, p.y});
    }
  }
  for (auto* numbers : {&theta_, &omega_, &N_}) std::fill(numbers->begin(), numbers->end(), 0.0);
}

void WeldedChain::accelerations(const double* theta, const double* omega, const double* N, double* alpha) {
  for (std::size_t body = 0; body < welded_.size(); ++body) {
    const std::size_t place = index(placeOf_[body]), first = first_[body];
    theta_[place] = theta[first];
    omega_[place] = omega[first];
  }
  for (std::size_t body = 0; N && body < welded_.size(); ++body) {
    const auto sum = std::accumulate(N + first_[body] + 1, N + first_[body + 1], N[first_[body]]);
    N_[index(placeOf_[body])] = sum;
  }
  if (steps_ > 0) {
    kernel_.rotations(theta_.data(), e_.data(), steps_ * kernel_.lanes);
    kernel_.segments({steps_, links_.data(), handles_.data()}, e_.data(), omega_.data(), N_.data(), nullptr,
                     -1.0 * chain_.gravity(), alpha_.data());
  }
  for (std::size_t j = 0; j < placeOfLink_.size(); ++j) alpha[j] = alpha_[index(placeOfLink_[j])];
}

void WeldedChain::moments(const double* N, double* mu) {
  std::fill_n(mu, bodies_.size(), 0.0);
  const Vec2d ground = -1.0 * chain_.gravity();
  Vec2d onFirst;
  if (steps_ > 0) {
    onFirst = kernel_.pins({steps_, links_.data(), handles_.data()}, e_.data(), omega_.data(), alpha_.data(),
                           ground, pins_.data());
  }
  const std::size_t lanes = index(kernel_.lanes);
  for (const std::size_t body : several_) {
    const std::size_t place = index(placeOf_[body]), lane = place % lanes;
    const double* pin = pins_.data() + (place - lane) * simd::SegmentArrays::pinQuantities + lane;
    const Rotation<double> back{e_[2 * place], -e_[2 * place + 1]};
    const Vec2d a{pin[0], pin[lanes]}, F{pin[2 * lanes], pin[3 * lanes]};
    writeMoments(first_[body] + 1, first_[body + 1], back * a, back * F, alpha_[place],
                 omega_[place] * omega_[place], N, mu);
  }
  writeMoments(0, first_.front(), ground, onFirst, 0, 0, N, mu);
}

/// Of the joints of a body, inwards.
inline void WeldedChain::writeMoments(std::size_t from, std::size_t to, Vec2d a, Vec2d F, double alpha,
                                      double ww, const double* N, double* mu) const {
  double sum = 0;
  for (std::size_t j = to; j-- > from;) {
    const auto& [x, S, D, K, L] = stuck_[j];
    sum += N[j];
    mu[j] = cross(S, a) + alpha * K - ww * L + cross(D, F) - sum;
  }
}

}  // namespace planar_chain
