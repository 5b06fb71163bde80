#include "run/turns.h"

#include <cmath>

#include "effects/effect_kind.h"

namespace planar_chain {

namespace {

constexpr long double turn = 6.283185307179586476925286766559L;

}  // namespace

Turns::Turns(const Scene& scene, int size) : turns_(scene.q.size(), 0), carry_(size) {
  for (const Joint& joint : scene.chain.joints()) isFree_.push_back(!storesEnergy(joint));
  for (const Drive& drive : scene.drives) isFree_[index(drive.joint)] = false;
}

void Turns::take(const std::vector<double>& q, double* theta) {
  any_ = false;
  double sum = 0;
  for (std::size_t i = 0; i < q.size(); ++i) {
    double rest = q[i];
    turns_[i] = 0;
    if (isFree_[i] && std::abs(q[i]) > mostAngle) {
      rest = std::atan2(std::sin(q[i]), std::cos(q[i]));
      turns_[i] = static_cast<double>(std::round((q[i] - static_cast<long double>(rest)) / turn));
      any_ = true;
    }
    theta[i] = sum += rest;
  }
}

bool Turns::takeMore(const ode::System& f, ode::State& state, Eigen::VectorXd& y) {
  const int n = static_cast<int>(turns_.size());
  bool isDue = false;
  for (int i = 0; i < n; ++i)
    isDue = isDue || (isFree_[index(i)] && std::abs(relative(y.data(), i)) > mostAngle);
  if (!isDue) return false;

  f.restore(state.carry.data(), carry_.data());
  double before = 0, taken = 0;  // θ'_{i−1}, and the turns taken off it
  for (int i = 0; i < n; ++i) {
    const double q = y[i] - before;
    before = y[i];
    if (isFree_[index(i)] && std::abs(q) > mostAngle) {
      const double own = static_cast<double>(std::round(q / turn));
      turns_[index(i)] += own;
      taken += own;
    }
    const long double rest = y[i] + (carry_[i] - turn * taken);
    y[i] = static_cast<double>(rest);
    carry_[i] = static_cast<double>(rest - y[i]);
  }
  f.arrange(y.data(), state.y.data());
  f.arrange(carry_.data(), state.carry.data());
  any_ = true;
  return true;
}

void Turns::addTo(std::vector<double>& q) const {
  if (!any_) return;
  for (std::size_t i = 0; i < q.size(); ++i) {
    q[i] = static_cast<double>(q[i] + turn * turns_[i]);
  }
}

void Turns::addTo(LinkMotion* motions) const {
  if (!any_) return;
  double turns = 0;
  for (std::size_t i = 0; i < turns_.size(); ++i) {
    turns += turns_[i];
    motions[i].angle = static_cast<double>(motions[i].angle + turn * turns);
  }
}

}  // namespace planar_chain
