#include "lanes/short_chain.h"

#include "lanes/kernel.h"
#include "lanes/segments.h"

namespace planar_chain {

namespace {

/// The constants of two bodies in closed form: M_11, J_2 | J_1 J_2 + m_2 |p_1|² I_2 | S_1, S_2 | p_1, p_2,
/// each x, y; one body a lane.
CacheLines twoInLanes(const Chain& chain, int lanes) {
  const Link &first = chain.links()[0], &second = chain.links()[1];
  const double J1 = first.inertia + first.mass * dot(first.com, first.com);
  const double J2 = second.inertia + second.mass * dot(second.com, second.com);
  const double mPP = second.mass * dot(first.pin, first.pin);
  const Vec2d S1 = first.mass * first.com + second.mass * first.pin;
  const Vec2d S2 = second.mass * second.com;
  const double quantities[simd::ShortChains::linkQuantities][2] = {
      {J1 + mPP, J2}, {J1 * J2 + mPP * second.inertia, 0}, {S1.x, S2.x},
      {S1.y, S2.y},   {first.pin.x, second.pin.x},         {first.pin.y, second.pin.y}};
  CacheLines all(static_cast<std::size_t>(simd::ShortChains::linkQuantities * lanes));
  double* to = all.data();
  for (const auto& [one, two] : quantities) {
    to[0] = one;
    to[1] = two;
    to += lanes;
  }
  return all;
}

}  // namespace

const int ShortChain::most = simd::ShortChains::most;

ShortChain::ShortChain(const Chain& chain, const simd::Kernel& kernel) : n_(chain.size()) {
  const simd::ShortChains& kind = *kernel.shortChains;
  for (const LoadKind acting : {LoadKind::nothing, LoadKind::moments, LoadKind::forces}) {
    runs_[static_cast<std::size_t>(acting)] = kind.runFor(n_, acting);
  }
  const int blocks = (n_ + kind.lanes - 1) / kind.lanes;
  links_ = n_ == 2 ? twoInLanes(chain, kind.lanes) : linksInLanes(chain, kind.lanes, blocks, 1, kind.lanes);
}

std::string ShortChain::name() const {
  if (n_ == 2) return "closed form for two";
  return "link by link, written out for " + std::to_string(n_);
}

}  // namespace planar_chain
