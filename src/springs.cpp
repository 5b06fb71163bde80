#include "planar_chain/springs.h"

namespace planar_chain {

namespace {

/// f(i, l, x_{first+i} − x_{first+i−1}) for i = 0 … size − 1; before x_0 there is 0. l counts from 0 to
/// `lanes`, so that sums in as many parts do not wait for each other.
constexpr std::size_t lanes = 8;

template <class F>
void forDifferences(const double* x, std::size_t first, std::size_t size, F f) {
  if (size == 0) return;
  const double* own = x + first;
  f(0, 0, first > 0 ? own[0] - own[-1] : own[0]);
  std::size_t i = 1;
  for (; i + lanes <= size; i += lanes) {
    for (std::size_t l = 0; l < lanes; ++l) f(i + l, l, own[i + l] - own[i + l - 1]);
  }
  for (; i < size; ++i) f(i, 0, own[i] - own[i - 1]);
}

}  // namespace

Springs::Springs(const Chain& chain) {
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
  rest_.resize(size());
  torque_.resize(size());
  if (dissipates) d_.resize(size());
  for (std::size_t i = 0; i < size(); ++i) {
    const Joint& joint = chain.joints()[first_ + i];
    k_[i] = joint.stiffness;
    rest_[i] = joint.restAngle;
    if (dissipates) d_[i] = joint.damping;
  }
}

double Springs::findTorques(const double* theta, const double* omega) {
  const double *k = k_.data(), *rest = rest_.data(), *d = d_.data();
  double* __restrict torque = torque_.data();
  forDifferences(theta, first_, size(),
                 [=](std::size_t i, std::size_t, double q) { torque[i] = -k[i] * (q - rest[i]); });
  double lost[lanes] = {};
  forDifferences(omega, first_, d_.size(), [=, &lost](std::size_t i, std::size_t l, double qd) {
    const double damping = d[i] * qd;
    torque[i] -= damping;
    lost[l] += damping * qd;
  });
  double all = 0;
  for (const double sum : lost) all += sum;
  return all;
}

double Springs::apply(const double* theta, const double* omega, double* N) {
  const double lost = findTorques(theta, omega);
  const double* torque = torque_.data();
  double* own = N + first_;
  const std::size_t last = size() - 1;
  for (std::size_t i = 0; i < last; ++i) own[i] += torque[i] - torque[i + 1];
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
  const double *d = d_.data(), *own = v + first_;
  const bool hasParent = first_ > 0;
  double change[lanes] = {};
  forDifferences(omega, first_, d_.size(), [=, &change](std::size_t i, std::size_t l, double qd) {
    const double along = i > 0 || hasParent ? own[i] - own[i - 1] : own[i];
    change[l] += 2 * d[i] * qd * along;
  });
  double all = 0;
  for (const double sum : change) all += sum;
  return all;
}

}  // namespace planar_chain
