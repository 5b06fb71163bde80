#include "dynamics/pull.h"

#include <cmath>

namespace planar_chain {

Pull::Pull(const Chain& chain) : chain_(chain), recursion_(chain) {
  const auto n = index(chain.size());
  theta_.resize(n);
  omega_.resize(n);
  e_.resize(n);
  still_.resize(n);
  N_.resize(n);
  alpha_.resize(n);
  F_.resize(n);
  for (const Link& link : chain.links()) mass_ += link.mass;
}

PointMotion Pull::motionOf(const double* q, const double* qd, int link, Vec2d point) {
  PointMotion motion;
  toAbsolute(q, chain_.size(), theta_.data());
  toAbsolute(qd, chain_.size(), omega_.data());
  for (int i = 0; i < chain_.size(); ++i) {
    const auto at = index(i);
    e_[at] = Rotation<double>::of(theta_[at]);
    if (i > link) continue;
    const Vec2d arm = e_[at] * (i < link ? chain_.links()[at].pin : point);
    motion.position += arm;
    motion.velocity += omega_[at] * perp(arm);
    arm_ = arm;
  }
  motion.turn = e_[index(link)];
  const Vec2d alongX = answer(link, {1, 0}), alongY = answer(link, {0, 1});
  motion.mobility = {alongX.x, (alongX.y + alongY.x) / 2, alongY.y};
  return motion;
}

/// The acceleration that the force gives the point.
Vec2d Pull::answer(int link, Vec2d force) {
  const std::size_t last = index(link);
  N_[last] = cross(arm_, force);
  F_[last] = force;
  recursion_.accelerations(e_.data(), still_.data(), N_.data(), F_.data(), {}, alpha_.data());
  N_[last] = 0;
  F_[last] = {};

  Vec2d a;
  for (std::size_t i = 0; i < last; ++i) a += alpha_[i] * perp(e_[i] * chain_.links()[i].pin);
  return a + alpha_[last] * perp(arm_);
}

Vec2d Pull::force(const PointMotion& point, Vec2d target, double pulsation) const {
  const Vec2d wanted = pulsation * pulsation * (target - point.position) - 2 * pulsation * point.velocity;
  // The axes of Λ⁻¹, and 1/m along each.
  const auto [xx, xy, yy] = point.mobility;
  const double middle = (xx + yy) / 2, half = std::hypot((xx - yy) / 2, xy);
  const Rotation<double> axes = Rotation<double>::of(std::atan2(2 * xy, xx - yy) / 2);
  const auto massAt = [this](double inverse) { return 1 / std::fmax(inverse, 1 / mass_); };
  const Vec2d u = axes * Vec2d{1, 0}, w = axes * Vec2d{0, 1};
  return massAt(middle + half) * dot(u, wanted) * u + massAt(middle - half) * dot(w, wanted) * w;
}

}  // namespace planar_chain
