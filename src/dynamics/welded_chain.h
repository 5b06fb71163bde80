#pragma once

/// A chain whose joints slide or stick, without rotors, drives and forces, and on a base at rest. Bodies that
/// stick together are one body, so a plain chain of fewer bodies is left. It runs in segments (segments.h).
///
/// The bodies a … b, with angles q of the stuck joints between them, in the axes of a:
///
///     φ_a = 0, φ_j = φ_{j−1} + q_j      x_a = 0, x_{j+1} = x_j + exp(i φ_j) p_j      p = x_{b+1}
///     r_j' = x_j + exp(i φ_j) r_j       m = Σ m_j, r = Σ m_j r_j' / m                N = Σ N_j
///     I = Σ I_j + m_j |r_j' − r|²
///
/// Bodies that stick to the ground do not move. From the accelerations follow, inwards, the forces in the
/// pins and the moments μ of stuck joints; μ = 0 in the others:
///
///     f_j = m (a + iα R − ω² R)      μ = I α + R×f_j + P×F' + μ' − N      F = f_j + F'

#include <string>
#include <vector>

#include "effects/effect.h"
#include "planar_chain/chain.h"
#include "recursion/articulated.h"
#include "simd/cache_lines.h"

namespace planar_chain {

namespace simd {
struct Kernel;
}

/// Only the constructor allocates. Arguments are in chain order.
class WeldedChain {
 public:
  /// The chain must outlive this object.
  explicit WeldedChain(const Chain& chain);

  std::string name() const;
  /// Takes the joints that stick from now on, and their angles.
  void weld(const Couplings& at);
  /// Writes α of all bodies.
  void accelerations(const double* theta, const double* omega, const double* N, double* alpha);
  /// Writes μ of all joints at those accelerations. e: exp(i θ_j).
  void moments(const Rotation<double>* e, const double* omega, const double* N, const double* alpha,
               double* mu);

 private:
  void arrange();

  const Chain& chain_;
  const simd::Kernel& kernel_;
  int steps_ = 0;                        ///< of the segments
  std::vector<Body<double>> bodies_;     ///< of the links,
  std::vector<Body<double>> welded_;     ///< and of the welded chain
  std::vector<int> first_;               ///< the first link of each
  std::vector<int> placeOf_;             ///< of each link's body in lane order
  std::vector<char> sticks_;             ///< the joints, true or false
  std::vector<double> angles_;           ///< of the joints when they stuck last, from body to body,
  std::vector<Rotation<double>> turns_;  ///< and their rotations
  struct Own {
    Vec2d f, P;
    double moment;  ///< I α + R×f − N
  };
  std::vector<Own> own_;
  CacheLines links_, handles_, theta_, omega_, N_, alpha_, e_;
};

}  // namespace planar_chain
