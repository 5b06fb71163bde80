#include "dynamics/pull.h"

#include <algorithm>
#include <cmath>

#include "dynamics/inner_end.h"
#include "lanes/short_chain.h"

namespace planar_chain {

Pull::Pull(const Chain& chain)
    : chain_(chain), recursion_(chain.withoutSlides()), joints_(index(chain.size())) {
  recursion_.couple(joints_.data());
  const auto n = index(chain.size());
  for (auto* numbers : {&theta_, &omega_, &still_, &N_, &alpha_, &moments_}) numbers->resize(n);
  e_.resize(index(ShortChain::roomFor(chain.size())));
  F_.resize(n);
  for (const Link& link : chain.links()) mass_ += link.mass;
}

PointMotion Pull::motionOf(const double* q, const double* qd, int link, Vec2d point) {
  PointMotion motion;
  const Coordinates coordinates = chain_.coordinates();
  coordinates.toAbsolute(q, theta_.data());
  coordinates.toAbsolute(qd, omega_.data());
  for (int i = 0; i < chain_.size(); ++i) {
    const auto at = index(i);
    const bool slides = coordinates.slides(i);
    if (!slides) e_[at] = Rotation<double>::of(theta_[at]);
    if (i > link) continue;
    const Vec2d arm = e_[at] * (i < link ? chain_.links()[at].pin : point), axis = chain_.joints()[at].axis;
    motion.position += arm;
    motion.velocity += slides ? omega_[at] * axis : omega_[at] * perp(arm);
    if (slides) motion.position += theta_[at] * axis;
    arm_ = arm;
  }
  motion.turn = e_[index(link)];
  const Vec2d alongX = answer(link, {1, 0}), alongY = answer(link, {0, 1});
  motion.mobility = {alongX.x, (alongX.y + alongY.x) / 2, alongY.y};
  return motion;
}

/// The acceleration that the force gives the point, at rest and without gravity.
Vec2d Pull::answer(int link, Vec2d force) {
  const std::size_t last = index(link);
  const std::size_t slides = index(chain_.slides());
  N_[last] = last < slides ? 0 : cross(arm_, force);
  F_[last] = force;
  InnerEnd<double> inner = innerEndOf(chain_, joints_.data());
  setForces(N_.data(), F_.data(), inner);
  EndsMotion<double> ends;
  recursion_.accelerations({e_.data() + slides, N_.data() + slides, F_.data() + slides, {}}, nullptr,
                           still_.data(), 0, inner, {}, alpha_.data() + slides, moments_.data(), ends);
  std::copy_n(ends.acceleration.begin(), slides, alpha_.begin());
  N_[last] = 0;
  F_[last] = {};

  Vec2d a;
  for (std::size_t i = 0; i < std::min(slides, last + 1); ++i) a += alpha_[i] * chain_.joints()[i].axis;
  for (std::size_t i = slides; i < last; ++i) a += alpha_[i] * perp(e_[i] * chain_.links()[i].pin);
  return last < slides ? a : a + alpha_[last] * perp(arm_);
}

Vec2d Pull::force(const PointMotion& point, Vec2d target, double pulsation) const {
  const Vec2d wanted = pulsation * pulsation * (target - point.position) - 2 * pulsation * point.velocity;
  const auto [inverse, axis] = eigen(point.mobility);  // 1/m along each axis of Λ⁻¹
  Vec2d force;
  for (const std::size_t i : {0, 1}) {
    force += (dot(axis[i], wanted) / std::fmax(inverse[i], 1 / mass_)) * axis[i];
  }
  return force;
}

}  // namespace planar_chain
