#include "ode/local_stiffness.h"

#include <cmath>
#include <limits>

namespace planar_chain::ode {

namespace {

/// The pattern of the highest modes of a chain: every component opposite to its neighbours.
Vector zigzagOf(const System& f) {
  Vector pattern(f.size()), arranged(f.arrangedSize());
  pattern.setOnes();
  for (Eigen::Index i = 1; i < pattern.size(); i += 2) pattern[i] = -1;
  f.arrange(pattern.data(), arranged.data());
  return arranged;
}

/// Sums one by one, so that zeros at the end do not change the rounding.
double lengthOf(const Vector& direction) {
  double square = 0;
  for (Eigen::Index i = 0; i < direction.size(); ++i) square += direction[i] * direction[i];
  return std::sqrt(square);
}

}  // namespace

LocalStiffness::LocalStiffness(System& f)
    : f_(f),
      zigzag_(zigzagOf(f)),
      direction_(zigzag_),
      base_(direction_),
      moved_(direction_),
      slope_(direction_),
      noise_(f.arrangedSize()) {}

void LocalStiffness::maybeUpdate(double t, const Vector& y) {
  if (calls_ == 0) update(t, y);
  calls_ = (calls_ + 1) % 100;
}

void LocalStiffness::update(double t, const Vector& y) {
  f_.slope(t, y.data(), base_.data());

  // |λ|² is the factor by which J J stretches its dominant direction.
  for (int k = 0; k < 2; ++k) {
    const double before = lengthOf(direction_);
    applyJacobian(t, y);
    applyJacobian(t, y);
    const double after = lengthOf(direction_);
    if (!(after > 0) || !std::isfinite(after)) {
      direction_ = zigzag_.cwiseAbs();
      eigenvalue_ = 0;
      break;
    }
    eigenvalue_ = std::sqrt(after / before);
    direction_ /= after;
  }

  // Move each component by one unit in the last place of 1 + |y_i|, up and down by turns.
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    const double ulp = std::numeric_limits<double>::epsilon() * (1 + std::abs(y[i]));
    moved_[i] = y[i] + zigzag_[i] * ulp;
  }
  f_.slope(t, moved_.data(), slope_.data());
  noise_ = (slope_ - base_).cwiseAbs();
  if (!noise_.allFinite()) noise_.setZero();
}

void LocalStiffness::applyJacobian(double t, const Vector& y) {
  const double size = 1e-6 / direction_.cwiseAbs().maxCoeff();
  moved_ = y + size * direction_;
  f_.slope(t, moved_.data(), slope_.data());
  direction_ = (slope_ - base_) / size;
}

}  // namespace planar_chain::ode
