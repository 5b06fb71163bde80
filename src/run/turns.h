#pragma once

/// Whole turns, kept apart from the angles that are integrated. The motion depends on θ through cos θ and
/// sin θ alone, but for joints that store energy. An angle of 10¹² rad leaves steps of 10⁻⁴ rad to a double;
/// the same angle less whole turns leaves 10⁻¹⁶.
///
///     q_i = q'_i + 2π m_i,  m_i whole, and 0 in joints that store energy. The state holds θ'_i = q'_1 + … +
///     q'_i.
///
/// Turns are taken off when |q'_i| exceeds `mostAngle`, so shorter ways change no bit.

#include <vector>

#include "ode/system.h"
#include "planar_chain/motion.h"
#include "planar_chain/scene.h"

namespace planar_chain {

class Turns {
 public:
  static constexpr double mostAngle = 1000;  ///< rad

  /// size: of y. Allocates; the other functions do not.
  Turns(const Scene& scene, int size);

  /// Takes the turns off these relative angles, and writes θ'.
  void take(const std::vector<double>& q, double* theta);
  /// Takes more turns off the state, if it is time. y: the same state in chain order; it follows.
  /// @returns true if the state has changed
  bool takeMore(const ode::System& f, ode::State& state, Eigen::VectorXd& y);
  /// Adds the turns to relative angles q', and to the angles of links.
  void addTo(std::vector<double>& q) const;
  void addTo(LinkMotion* motions) const;

 private:
  std::vector<bool> isFree_;   ///< joint i stores no energy and is not driven
  std::vector<double> turns_;  ///< m_i
  bool any_ = false;
  Eigen::VectorXd carry_;
};

}  // namespace planar_chain
