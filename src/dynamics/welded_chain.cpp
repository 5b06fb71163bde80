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
  welded_.clear();
  first_.clear();
  ground_ = {};
  Body<double>* body = &ground_;
  Rotation<double> e;
  for (std::size_t j = 0; j < bodies_.size(); ++j) {
    const auto& [m, I, r, p] = bodies_[j];
    sticks_[j] = at.joints[j].isHeld;
    if (!sticks_[j]) {
      e = {};
      first_.push_back(j);
      body = &welded_.emplace_back(bodies_[j]);
      continue;
    }
    if (const double q = at.held[j].value; angles_[j] != q) {
      angles_[j] = q;
      turns_[j] = Rotation<double>::of(q);
    }
    e = e * turns_[j];
    const Vec2d com = e * r, apart = body->p + com - body->r;
    const double mass = body->m + m;
    stuck_[j] = {body->p, com};
    body->I += I + body->m * m / mass * dot(apart, apart);
    body->r += (m / mass) * apart;
    body->m = mass;
    body->p += e * p;
  }
  first_.push_back(bodies_.size());
  sumStuck();
  arrange();
}

/// Sums S, Q and D of the stuck links inwards.
void WeldedChain::sumStuck() {
  std::size_t body = welded_.size();
  double m = 0, Q = 0;
  Vec2d S, inner;
  for (std::size_t j = bodies_.size(); j-- > 0;) {
    if (!sticks_[j]) {
      --body;
      m = Q = 0;
      S = {};
      continue;
    }
    const Vec2d pin = stuck_[j].x, com = stuck_[j].S, step = m > 0 ? inner - pin : Vec2d{};
    const double own = bodies_[j].m;
    Q += 2 * dot(step, S) + m * dot(step, step) + bodies_[j].I + own * dot(com, com);
    S += m * step + own * com;
    m += own;
    inner = pin;
    stuck_[j] = {pin, S, (body > 0 ? welded_[body - 1] : ground_).p - pin, Q};
  }
}

/// Writes the bodies in lane order.
void WeldedChain::arrange() {
  const int lanes = kernel_.lanes, count = static_cast<int>(welded_.size());
  steps_ = (count + lanes - 1) / lanes;
  const auto placeOf = [&](int body) { return body % steps_ * lanes + body / steps_; };
  for (int body = 0; body < steps_ * lanes; ++body) {
    const auto& [m, I, r, p] = body < count ? welded_[index(body)] : Body<double>{0, 1, {}, {}};
    const int place = placeOf(body), step = place / lanes;
    if (body < count) placeOf_[index(body)] = index(place);
    double* to = links_.data() + step * lanes * simd::SegmentArrays::linkQuantities + place % lanes;
    for (const double number : {m, I, r.x, r.y, p.x, p.y}) {
      *to = number;
      to += lanes;
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

void WeldedChain::moments(const double* omega, const double* N, double* mu) {
  const auto turnedBack = [](Rotation<double> e, Vec2d a) { return Rotation<double>{e.c, -e.s} * a; };
  const auto rotation = [this](std::size_t body) {
    return Rotation<double>{e_[2 * placeOf_[body]], e_[2 * placeOf_[body] + 1]};
  };

  // The accelerations of the inner pins, in the axes of the bodies, and the forces, outwards.
  const Vec2d ground = -1.0 * chain_.gravity();
  Vec2d a = ground;
  for (std::size_t body = 0; body < welded_.size(); ++body) {
    const Rotation<double> e = rotation(body);
    const double alpha = alpha_[placeOf_[body]], ww = omega[first_[body]] * omega[first_[body]];
    const auto& [m, I, r, p] = welded_[body];
    const Vec2d own = turnedBack(e, a);
    moved_[body] = {own, e * (m * (own + alpha * perp(r) - ww * r))};
    a += e * (alpha * perp(p) - ww * p);
  }

  // The moments, inwards.
  Vec2d outer;
  const auto writeMoments = [&](std::size_t from, std::size_t to, Vec2d pin, double alpha, double ww,
                                Vec2d F) {
    double sum = 0;
    for (std::size_t j = to; j-- > from;) {
      const auto& [x, S, D, Q] = stuck_[j];
      sum += N[j];
      mu[j] = cross(S, pin + alpha * perp(x) - ww * x) + alpha * Q + cross(D, F) - sum;
    }
  };
  for (std::size_t body = welded_.size(); body-- > 0;) {
    const std::size_t first = first_[body];
    writeMoments(first + 1, first_[body + 1], moved_[body].a, alpha_[placeOf_[body]],
                 omega[first] * omega[first], turnedBack(rotation(body), outer));
    mu[first] = 0;
    outer += moved_[body].force;
  }
  writeMoments(0, first_.front(), ground, 0, 0, outer);
}

}  // namespace planar_chain
