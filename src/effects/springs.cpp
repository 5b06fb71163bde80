#include "effects/springs.h"

namespace planar_chain {

namespace {

constexpr std::size_t lanes = 8;  // sums in as many parts do not wait for each other

double sumOf(const double (&parts)[lanes]) {
  double all = 0;
  for (const double part : parts) all += part;
  return all;
}

/// Of the outer body's number and the inner one's, which is 0 where there is none.
struct Difference {
  std::size_t outer, inner;
  bool hasInner;
  double operator()(const double* x) const { return hasInner ? x[outer] - x[inner] : x[outer]; }
};

}  // namespace

/// f(i, l, difference) for the first `count` joints; l: less than `lanes`, and another one for each
/// neighbour.
template <class F>
void Springs::forJoints(std::size_t count, F f) const {
  if (count == 0) return;
  f(0, 0, Difference{first_, first_ - 1, first_ > 0});
  const std::size_t lastRow = count - row_;
  for (std::size_t i = 1; i < row_; ++i) {  // what a lane begins with hangs on the last of the lane before
    f(i, 0, Difference{i, lastRow + i - 1, true});
  }
  const auto next = [&](std::size_t i, std::size_t l) {
    f(i, l, Difference{first_ + i, first_ + i - row_, true});
  };
  std::size_t i = row_;
  for (; i + lanes <= count; i += lanes) {
    for (std::size_t l = 0; l < lanes; ++l) next(i + l, l);
  }
  for (; i < count; ++i) next(i, 0);
}

Springs::Springs(const Chain& chain, const Arrangement* arrangement) {
  bool dissipates = false;
  std::size_t last = 0;
  for (std::size_t i = 0; i < chain.joints().size(); ++i) {
    const Joint& joint = chain.joints()[i];
    if (!(joint.stiffness > 0 || joint.damping > 0)) continue;
    if (k_.empty()) first_ = i;
    last = i;
    k_.resize(last - first_ + 1);
    dissipates = dissipates || joint.damping > 0;
  }
  if (k_.empty()) return;
  if (arrangement) {
    first_ = 0;
    last = chain.joints().size() - 1;
    row_ = static_cast<std::size_t>(arrangement->lanes());
    k_.resize(static_cast<std::size_t>(arrangement->places()));
  }
  rest_.resize(size());
  torque_.resize(size());
  if (dissipates) d_.resize(size());
  for (std::size_t i = first_; i <= last; ++i) {
    const Joint& joint = chain.joints()[i];
    const std::size_t place = arrangement ? arrangement->placeOf(i) : i - first_;
    k_[place] = joint.stiffness;
    rest_[place] = joint.restAngle;
    if (dissipates) d_[place] = joint.damping;
  }
}

double Springs::findTorques(const double* theta, const double* omega) {
  const double *k = k_.data(), *rest = rest_.data(), *d = d_.data();
  double* __restrict torque = torque_.data();
  forJoints(size(), [=](std::size_t i, std::size_t, const Difference& difference) {
    torque[i] = -k[i] * (difference(theta) - rest[i]);
  });
  double lost[lanes] = {};
  forJoints(d_.size(), [=, &lost](std::size_t i, std::size_t l, const Difference& difference) {
    const double qd = difference(omega), damping = d[i] * qd;
    torque[i] -= damping;
    lost[l] += damping * qd;
  });
  return sumOf(lost);
}

double Springs::apply(const double* theta, const double* omega, double* N) {
  const double lost = findTorques(theta, omega);
  const double* torque = torque_.data();
  double* own = N + first_;
  const std::size_t last = size() - 1, lastRow = size() - row_;
  for (std::size_t i = 0; i < lastRow; ++i) own[i] += torque[i] - torque[i + row_];
  for (std::size_t i = lastRow; i < last; ++i) own[i] += torque[i] - torque[i - lastRow + 1];
  own[last] += torque[last];
  if (first_ > 0) N[first_ - 1] -= torque[0];
  return lost;
}

void Springs::addTorques(const double* theta, const double* omega, double* tau) {
  findTorques(theta, omega);
  for (std::size_t i = 0; i < size(); ++i) tau[first_ + i] += torque_[i];
}

void Springs::addStiffness(double* k, double* d) const {
  for (std::size_t i = 0; i < size(); ++i) k[first_ + i] += k_[i];
  for (std::size_t i = 0; i < d_.size(); ++i) d[first_ + i] += d_[i];
}

double Springs::dissipationAlong(const double* omega, const double* v) const {
  const double* d = d_.data();
  double change[lanes] = {};
  forJoints(d_.size(), [=, &change](std::size_t i, std::size_t l, const Difference& difference) {
    change[l] += 2 * d[i] * difference(omega) * difference(v);
  });
  return sumOf(change);
}

}  // namespace planar_chain
