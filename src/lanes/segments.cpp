#include "lanes/segments.h"

#include "lanes/kernel.h"

namespace planar_chain {

void rotations(const double* theta, Rotation<double>* e, int n) {
  static_assert(sizeof(Rotation<double>) == 2 * sizeof(double));
  static const auto run = simd::kernels().front()->rotations;
  run(theta, &e->c, n);
}

void plainRotations(const double* theta, Rotation<double>* e, int n) {
  simd::kernelBaseline.rotations(theta, &e->c, n);
}
Rotation<double> plainRotation(double theta) {
  Rotation<double> e;
  plainRotations(&theta, &e, 1);
  return e;
}

CacheLines linksInLanes(const Chain& chain, int lanes, int steps, int apart, int next) {
  CacheLines links(index(steps * lanes * simd::SegmentArrays::linkQuantities));
  Link none;
  none.inertia = 1;
  for (int s = 0; s < lanes; ++s) {
    for (int i = 0; i < steps; ++i) {
      const int j = s * apart + i * next;
      const Link& link = j < chain.size() ? chain.links()[index(j)] : none;
      putInLane(links.data(), index(i * lanes + s), index(lanes),
                {link.mass, link.inertia, link.com.x, link.com.y, link.pin.x, link.pin.y});
    }
  }
  return links;
}

Segments::Segments(const Chain& chain, const simd::Kernel& kernel)
    : kernel_(kernel),
      laneOrder_(chain.size(), kernel.lanes),
      links_(linksInLaneOrder(chain, laneOrder_)),
      factors_(index(laneOrder_.paddedSize() * simd::SegmentArrays::factorQuantities)) {}

std::string Segments::name() const {
  return "in " + std::to_string(kernel_.lanes) + " segments side by side (" + kernel_.name + ")";
}

void Segments::accelerations(const Rotation<double>* e, const double* omega, const double* N, const Vec2d* F,
                             Vec2d ground, double* alpha) {
  kernel_.segments({laneOrder_.steps(), links_.data(), factors_.data()}, &e->c, omega, N, F ? &F->x : nullptr,
                   ground, alpha);
}

}  // namespace planar_chain
