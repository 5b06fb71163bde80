#include "lanes/segments.h"

#include "lanes/kernel.h"

namespace planar_chain {

namespace {

constexpr std::size_t linkQuantities = simd::SegmentArrays::linkQuantities;
constexpr std::size_t handleQuantities = 8;

}  // namespace

void rotations(const double* theta, Rotation<double>* e, int n) {
  static_assert(sizeof(Rotation<double>) == 2 * sizeof(double));
  static const auto run = simd::kernels().front()->rotations;
  run(theta, &e->c, n);
}

bool Segments::areWorthwhile(int n) {
  constexpr int leastLinks = 13;
  constexpr int leastLanes = 4;
  return n >= leastLinks && simd::kernels().front()->lanes >= leastLanes;
}

namespace {

/// bodyIn(s, i, steps): the number of the body in lane s of step i.
template <class BodyIn>
CacheLines linksWith(const Chain& chain, int lanes_, int steps_, BodyIn bodyIn) {
  const auto lanes = static_cast<std::size_t>(lanes_);
  const std::vector<Link>& all = chain.links();
  const auto steps = static_cast<std::size_t>(steps_);
  CacheLines links(steps * lanes * linkQuantities);
  for (std::size_t s = 0; s < lanes; ++s) {
    for (std::size_t i = 0; i < steps; ++i) {
      const std::size_t j = bodyIn(s, i, steps);
      double* to = links.data() + i * linkQuantities * lanes + s;
      to[lanes] = 1;  // I of a body beyond the end, which has no more
      if (j >= all.size()) continue;
      const Link& link = all[j];
      to[0] = link.mass;
      to[lanes] = link.inertia;
      to[2 * lanes] = link.com.x;
      to[3 * lanes] = link.com.y;
      to[4 * lanes] = link.pin.x;
      to[5 * lanes] = link.pin.y;
    }
  }
  return links;
}

}  // namespace

CacheLines linksArranged(const Chain& chain, const Arrangement& arrangement) {
  return linksWith(chain, arrangement.lanes(), arrangement.steps(),
                   [](std::size_t s, std::size_t i, std::size_t steps) { return s * steps + i; });
}

CacheLines linksInBlocks(const Chain& chain, int lanes) {
  return linksWith(
      chain, lanes, (chain.size() + lanes - 1) / lanes,
      [lanes](std::size_t s, std::size_t i, std::size_t) { return i * static_cast<std::size_t>(lanes) + s; });
}

Segments::Segments(const Chain& chain, const simd::Kernel* kernel)
    : kernel_(kernel ? *kernel : simd::kernelFor(chain.size())),
      arrangement_(chain.size(), kernel),
      links_(linksArranged(chain, arrangement_)),
      handles_(static_cast<std::size_t>(arrangement_.places()) * handleQuantities) {}

std::string Segments::name() const {
  return "in " + std::to_string(kernel_.lanes) + " segments side by side (" + kernel_.name + ")";
}

void Segments::accelerations(const Rotation<double>* e, const double* omega, const double* N, const Vec2d* F,
                             Vec2d ground, double* alpha) {
  kernel_.segments({arrangement_.steps(), links_.data(), handles_.data()}, &e->c, omega, N,
                   F ? &F->x : nullptr, ground, alpha);
}

}  // namespace planar_chain
