#pragma once

/// Whole turns, kept apart from the angles that are integrated. The motion depends on θ through cos θ and
/// sin θ alone, but for joints that store energy. Doubles near 10¹² rad are 10⁻⁴ rad apart. Without whole
/// turns they are 10⁻¹⁶ rad apart.
///
///     q_i = q'_i + 2π m_i,  m_i whole, and 0 in joints that store energy. The state holds θ'_i = q'_1 + … +
///     q'_i.
///
/// Turns are taken off when |q'_i| exceeds `mostAngle`, so shorter ways change no bit.

#include <cmath>
#include <vector>

#include "effects/effect_kind.h"
#include "ode/system.h"
#include "planar_chain/motion.h"
#include "planar_chain/scene.h"

namespace planar_chain {

/// Only the constructor allocates.
class Windings {
 public:
  static constexpr double mostAngle = 1000;  ///< rad

  /// size: of y.
  Windings(const Scene& scene, int size)
      : coordinates_(scene.chain.coordinates()), windings_(scene.q.size(), 0), carry_(size) {
    for (const Joint& joint : scene.chain.joints())
      isFree_.push_back(!joint.isPrismatic && !storesEnergy(joint));
    for (const Drive& drive : scene.drives) isFree_[index(drive.joint)] = false;
  }

  /// Takes the turns off these relative angles, and writes θ'.
  void take(const std::vector<double>& q, double* theta) {
    any_ = false;
    double sum = 0;
    for (std::size_t i = 0; i < q.size(); ++i) {
      double rest = q[i];
      windings_[i] = 0;
      if (coordinates_.isPrismatic(static_cast<int>(i))) {
        theta[i] = rest;
        continue;
      }
      if (isFree_[i] && std::abs(q[i]) > mostAngle) {
        rest = std::atan2(std::sin(q[i]), std::cos(q[i]));
        windings_[i] = static_cast<double>(std::round((q[i] - static_cast<long double>(rest)) / turn));
        any_ = true;
      }
      theta[i] = sum += rest;
    }
  }

  /// Takes more turns off the state, if it is time. y: the same state in chain order; it follows. A joint at
  /// rest keeps its angle, at which friction may hold it.
  /// @returns true if the state has changed
  bool takeMore(const ode::System& f, ode::State& state, Eigen::VectorXd& y) {
    const int n = static_cast<int>(windings_.size());
    const auto isDue = [&](int i, double q) {
      return isFree_[index(i)] && std::abs(q) > mostAngle && coordinates_.relative(y.data() + n, i) != 0;
    };
    bool anyIsDue = false;
    for (int i = 0; i < n; ++i) anyIsDue = anyIsDue || isDue(i, coordinates_.relative(y.data(), i));
    if (!anyIsDue) return false;

    f.toChainOrder(state.carry.data(), carry_.data());
    double before = 0, taken = 0;  // θ'_{i−1}, and the turns taken off it
    for (int i = 0; i < n; ++i) {
      if (coordinates_.isPrismatic(i)) continue;
      const double q = y[i] - before;
      before = y[i];
      if (isDue(i, q)) {
        const double own = static_cast<double>(std::round(q / turn));
        windings_[index(i)] += own;
        taken += own;
      }
      const long double rest = y[i] + (carry_[i] - turn * taken);
      y[i] = static_cast<double>(rest);
      carry_[i] = static_cast<double>(rest - y[i]);
    }
    f.toLaneOrder(y.data(), state.y.data());
    f.toLaneOrder(carry_.data(), state.carry.data());
    return any_ = true;
  }

  /// Adds the turns to relative angles q', and to the angles of links.
  void addTo(std::vector<double>& q) const {
    for (std::size_t i = 0; any_ && i < q.size(); ++i) {
      q[i] = static_cast<double>(q[i] + turn * windings_[i]);
    }
  }
  void addTo(LinkMotion* motions) const {
    double turns = 0;
    for (std::size_t i = 0; any_ && i < windings_.size(); ++i) {
      turns += windings_[i];
      motions[i].angle = static_cast<double>(motions[i].angle + turn * turns);
    }
  }

  void saveOrRestore(Snapshot& snapshot) { snapshot(windings_, any_); }

 private:
  static constexpr long double turn = 6.283185307179586476925286766559L;

  const Coordinates coordinates_;
  std::vector<bool> isFree_;      ///< joint i turns, stores no energy and is not driven
  std::vector<double> windings_;  ///< m_i
  bool any_ = false;
  Eigen::VectorXd carry_;
};

}  // namespace planar_chain
