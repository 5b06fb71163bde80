#include "dynamics/mechanism.h"

#include <algorithm>

#include "lanes/kernel.h"

namespace planar_chain {

Mechanism::Mechanism(const Scene& scene, bool inOrder)
    : chain_(scene.chain),
      n_(chain_.size()),
      kernelChoice_{scene.integrator.plainKernel},
      kernel_(simd::kernelFor(n_, kernelChoice_)),
      paddedSize_(n_),
      rotations_(simd::kernels(kernelChoice_).front()->rotations) {
  if (inOrder || n_ <= ShortChain::most) return;
  lanes_.emplace(n_, kernel_.lanes);
  paddedSize_ = lanes_->paddedSize();
}

Recursion Mechanism::makeRecursion() const {
  if (n_ <= ShortChain::most) return ShortChain(chain_, kernel_);
  return Segments(chain_, kernel_);
}

GeneralChain Mechanism::makeGeneralRecursion(bool basePays) const {
  return {chain_, kernel_, n_ > ShortChain::most, basePays};
}

void Mechanism::rotate(const double* x, double angle, Rotation<double>* e) const {
  rotate(x, e, n_);
  const Coordinates& coordinates = chain_.coordinates();
  if (coordinates.anyIsPrismatic()) {
    for (int j = 0; j < n_; ++j) {
      if (coordinates.isPrismatic(j))
        e[j] = coordinates.turner(j) >= 0 ? e[coordinates.turner(j)] : Rotation<double>{};
    }
  }
  if (angle == 0) return;
  const Rotation<double> turn = plainRotation(angle);
  for (int j = 0; j < n_; ++j) e[j] = turn * e[j];
}

void Mechanism::toBodies(const double* x, double ofBase, double* angles) const {
  const Coordinates& coordinates = chain_.coordinates();
  const int leading = coordinates.leading();
  if (coordinates.anyIsInside()) {
    for (int j = leading; j < n_; ++j) angles[j] = coordinates.angle(x, j);
  } else {
    std::copy(x + leading, x + n_, angles + leading);
  }
  std::fill_n(angles, leading, 0.0);
  if (ofBase == 0) return;
  for (int j = 0; j < n_; ++j) angles[j] += ofBase;
}

void Mechanism::toLaneOrder(const double* inOrder, double* inLanes) const {
  if (!lanes_) {
    std::copy_n(inOrder, 2 * n_, inLanes);
    return;
  }
  lanes_->toLaneOrder(inOrder, inLanes);
  lanes_->toLaneOrder(inOrder + n_, inLanes + paddedSize_);
}

void Mechanism::toChainOrder(const double* inLanes, double* inOrder) const {
  if (!lanes_) {
    std::copy_n(inLanes, 2 * n_, inOrder);
    return;
  }
  lanes_->toChainOrder(inLanes, inOrder);
  lanes_->toChainOrder(inLanes + paddedSize_, inOrder + n_);
}

const double* Mechanism::quantityInLanes(const double* values, double* room) const {
  if (!lanes_) return values;
  lanes_->toLaneOrder(values, room);
  return room;
}

const double* Mechanism::stateInOrder(const double* y, double* room) const {
  if (!lanes_) return y;
  toChainOrder(y, room);
  return room;
}

void Mechanism::findPinVelocities(const Rotation<double>* e, const double* omega, int count,
                                  Vec2d* velocities) const {
  sweepOutwards<false>(chain_, 0, count, PointAt<double>{}, e, omega, omega, omega,
                       [=](int j, const PointAt<double>& pin) { velocities[j] = pin.velocity; });
}

}  // namespace planar_chain
