#include "dynamics/welded_chain.h"

#include <algorithm>

#include "lanes/kernel.h"

namespace planar_chain {

WeldedChain::WeldedChain(const Chain& chain) : chain_(chain), kernel_(simd::kernelFor(chain.size())) {
  const auto n = index(chain.size()), places = n + index(kernel_.lanes);
  for (const Link& link : chain.links()) bodies_.push_back({link.mass, link.inertia, link.com, link.pin});
  welded_.reserve(n);
  first_.reserve(n);
  placeOf_.resize(n);
  sticks_.resize(n);
  own_.resize(n);
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
  Rotation<double> e;
  for (std::size_t j = 0; j < bodies_.size(); ++j) {
    const auto& [m, I, r, p] = bodies_[j];
    sticks_[j] = at.joints[j].isHeld;
    if (!sticks_[j]) {
      e = {};
      first_.push_back(static_cast<int>(j));
      welded_.push_back(bodies_[j]);
    } else if (!welded_.empty()) {
      if (const double q = at.held[j].value; angles_[j] != q) {
        angles_[j] = q;
        turns_[j] = Rotation<double>::of(q);
      }
      e = e * turns_[j];
      Body<double>& body = welded_.back();
      const Vec2d apart = body.p + e * r - body.r;
      const double mass = body.m + m;
      body.I += I + body.m * m / mass * dot(apart, apart);
      body.r += (m / mass) * apart;
      body.m = mass;
      body.p += e * p;
    }
    placeOf_[j] = static_cast<int>(welded_.size()) - 1;
  }
  arrange();
}

/// Writes the bodies in lane order. The ground has the last place, whose α is 0.
void WeldedChain::arrange() {
  const int lanes = kernel_.lanes, count = static_cast<int>(welded_.size());
  steps_ = (count + lanes - 1) / lanes;
  const auto placeOf = [&](int body) { return body % steps_ * lanes + body / steps_; };
  for (int body = 0; body < steps_ * lanes; ++body) {
    const auto& [m, I, r, p] = body < count ? welded_[index(body)] : Body<double>{0, 1, {}, {}};
    const int place = placeOf(body), step = place / lanes;
    double* to = links_.data() + step * lanes * simd::SegmentArrays::linkQuantities + place % lanes;
    for (const double number : {m, I, r.x, r.y, p.x, p.y}) {
      *to = number;
      to += lanes;
    }
  }
  for (int& body : placeOf_) body = body < 0 ? static_cast<int>(alpha_.size()) - 1 : placeOf(body);
  for (auto* numbers : {&theta_, &omega_, &alpha_}) std::fill(numbers->begin(), numbers->end(), 0.0);
}

void WeldedChain::accelerations(const double* theta, const double* omega, const double* N, double* alpha) {
  for (const int first : first_) {
    const auto place = index(placeOf_[index(first)]);
    theta_[place] = theta[first];
    omega_[place] = omega[first];
  }
  std::fill(N_.begin(), N_.end(), 0.0);
  for (std::size_t j = 0; j < placeOf_.size(); ++j) N_[index(placeOf_[j])] += N[j];
  if (steps_ > 0) {
    kernel_.rotations(theta_.data(), e_.data(), steps_ * kernel_.lanes);
    kernel_.segments({steps_, links_.data(), handles_.data()}, e_.data(), omega_.data(), N_.data(), nullptr,
                     -1.0 * chain_.gravity(), alpha_.data());
  }
  for (std::size_t j = 0; j < placeOf_.size(); ++j) alpha[j] = alpha_[index(placeOf_[j])];
}

void WeldedChain::moments(const Rotation<double>* e, const double* omega, const double* N,
                          const double* alpha, double* mu) {
  Vec2d a = -1.0 * chain_.gravity();
  for (std::size_t j = 0; j < bodies_.size(); ++j) {
    const auto [m, J, R, P, ww] = turned(bodies_[j], e[j], omega[j]);
    const Vec2d f = m * (a + alpha[j] * perp(R) - ww * R);
    a += alpha[j] * perp(P) - ww * P;
    own_[j] = {f, P, bodies_[j].I * alpha[j] - N[j] + cross(R, f)};
  }
  Vec2d outer;
  double next = 0;
  for (std::size_t j = bodies_.size(); j-- > 0;) {
    const auto& [f, P, moment] = own_[j];
    mu[j] = next = sticks_[j] ? next + (moment + cross(P, outer)) : 0;
    outer += f;
  }
}

}  // namespace planar_chain
