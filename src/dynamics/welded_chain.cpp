#include "dynamics/welded_chain.h"

#include <algorithm>

#include "lanes/kernel.h"

namespace planar_chain {

WeldedChain::WeldedChain(const Chain& chain) : chain_(chain), kernel_(simd::kernelFor(chain.size())) {
  const auto n = index(chain.size()), places = n + index(kernel_.lanes);
  for (const Link& link : chain.links()) bodies_.push_back({link.mass, link.inertia, link.com, link.pin});
  welded_.reserve(n);
  first_.reserve(n + 1);
  placeOf_.resize(n);
  sticks_.resize(n);
  stuck_.resize(n);
  moved_.resize(n);
  turns_.resize(n);
  angles_.resize(n);
  links_.resize(places * simd::SegmentArrays::linkQuantities);
  handles_.resize(places * simd::SegmentArrays::handleQuantities);
  for (auto* numbers : {&theta_, &omega_, &N_, &alpha_}) numbers->resize(places);
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
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    for (std::size_t step = 0; step < steps; ++step, ++body) {
      const auto& [m, I, r, p] = body < count ? welded_[body] : Body<double>{0, 1, {}, {}};
      if (body < count) placeOf_[body] = step * lanes + lane;
      double* to = links_.data() + step * lanes * simd::SegmentArrays::linkQuantities + lane;
      for (const double number : {m, I, r.x, r.y, p.x, p.y}) {
        *to = number;
        to += lanes;
      }
    }
  }
  for (auto* numbers : {&theta_, &omega_, &N_}) std::fill(numbers->begin(), numbers->end(), 0.0);
}

void WeldedChain::accelerations(const double* theta, const double* omega, const double* N, double* alpha) {
  for (std::size_t body = 0; body < welded_.size(); ++body) {
    const std::size_t place = placeOf_[body], first = first_[body];
    theta_[place] = theta[first];
    omega_[place] = omega[first];
    double sum = N[first];
    for (std::size_t j = first + 1; j < first_[body + 1]; ++j) sum += N[j];
    N_[place] = sum;
  }
  if (steps_ > 0) {
    kernel_.rotations(theta_.data(), e_.data(), steps_ * kernel_.lanes);
    kernel_.segments({steps_, links_.data(), handles_.data()}, e_.data(), omega_.data(), N_.data(), nullptr,
                     -1.0 * chain_.gravity(), alpha_.data());
  }
  std::fill_n(alpha, first_.front(), 0.0);  // on the ground
  for (std::size_t body = 0; body < welded_.size(); ++body) {
    const double own = alpha_[placeOf_[body]];
    for (std::size_t j = first_[body]; j < first_[body + 1]; ++j) alpha[j] = own;
  }
}

/// exp(i θ) of a body of the welded chain.
inline Rotation<double> WeldedChain::rotationOf(std::size_t body) const {
  const double* e = e_.data() + 2 * placeOf_[body];
  return {e[0], e[1]};
}

void WeldedChain::moments(const double* omega, const double* N, double* mu) {
  // The accelerations of the inner pins, and the forces, outwards.
  const Vec2d ground = -1.0 * chain_.gravity();
  Vec2d a = ground;
  for (std::size_t body = 0; body < welded_.size(); ++body) {
    const auto& [m, I, r, p] = welded_[body];
    const double alpha = alpha_[placeOf_[body]], rate = omega[first_[body]], ww = rate * rate;
    const Rotation<double> e = rotationOf(body), turning{-ww * e.c - alpha * e.s, alpha * e.c - ww * e.s};
    moved_[body] = {a, m * (a + turning * r)};
    a += turning * p;
  }

  // The moments, inwards.
  Vec2d outer;
  const auto writeMoments = [&](std::size_t from, std::size_t to, Rotation<double> back, Vec2d pin,
                                double alpha, double ww) {
    const Vec2d acceleration = back * pin, force = back * outer;
    double sum = 0;
    for (std::size_t j = to; j-- > from;) {
      const auto& [x, S, D, K, L] = stuck_[j];
      sum += N[j];
      mu[j] = cross(S, acceleration) + alpha * K - ww * L + cross(D, force) - sum;
    }
  };
  for (std::size_t body = welded_.size(); body-- > 0;) {
    const std::size_t first = first_[body], end = first_[body + 1];
    if (end > first + 1) {
      const Rotation<double> e = rotationOf(body);
      writeMoments(first + 1, end, {e.c, -e.s}, moved_[body].a, alpha_[placeOf_[body]],
                   omega[first] * omega[first]);
    }
    mu[first] = 0;
    outer += moved_[body].force;
  }
  writeMoments(0, first_.front(), {}, ground, 0, 0);
}

}  // namespace planar_chain
