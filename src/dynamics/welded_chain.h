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
/// Bodies that stick to the ground do not move. The moments μ of stuck joints follow from sums over the links
/// k = j … b, made when they are welded; μ = 0 in the other joints. F is the force on the next body, and a
/// the acceleration of x_a; all in the axes of body a:
///
///     S = Σ m_k (r_k' − x_j)      Q = Σ I_k + m_k |r_k' − x_j|²      D = x_{b+1} − x_j
///     μ_j = S×a + α K − ω² L + D×F − Σ N_k          K = Q + S·x_j      L = S×x_j

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
  /// Writes α of all bodies. N: nullptr: the same as last time since weld().
  void accelerations(const double* theta, const double* omega, const double* N, double* alpha);
  /// Writes μ of all joints, at the state of the last accelerations().
  void moments(const double* N, double* mu);

 private:
  void sumStuck();
  void arrange();
  void writeMoments(std::size_t from, std::size_t to, Vec2d a, Vec2d F, double alpha, double ww,
                    const double* N, double* mu) const;

  const Chain& chain_;
  const simd::Kernel& kernel_;
  int steps_ = 0;                     ///< of the segments
  std::vector<Body<double>> bodies_;  ///< of the links,
  std::vector<Body<double>> welded_;  ///< and of the welded chain,
  Vec2d groundPin_;                   ///< and the outer pin of what sticks to the ground
  std::vector<std::size_t> first_;    ///< the first link of each, and their end
  std::vector<int> placeOf_;          ///< of each in lane order,
  std::vector<int> placeOfLink_;      ///< and of the body that has each link; that of the ground is the last
  std::vector<char> sticks_;          ///< the joints, true or false
  std::vector<double> angles_;        ///< of the joints when they stuck last, from body to body,
  std::vector<Rotation<double>> turns_;  ///< and their rotations
  struct Stuck {
    Vec2d x{}, S{}, D{};
    double K = 0, L = 0;
  };
  std::vector<Stuck> stuck_;          ///< of the links that stick to the one before
  std::vector<std::size_t> several_;  ///< the bodies of several links
  CacheLines links_, handles_, pins_, theta_, omega_, N_, alpha_, e_;
};

}  // namespace planar_chain
