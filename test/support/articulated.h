#pragma once

/// The recursion of recursion/articulated.h link by link, in any number type: what the kernels are compared
/// with.

#include <vector>

#include "planar_chain/chain.h"
#include "recursion/articulated.h"

namespace planar_chain {

template <class Real = double>
class Articulated {
 public:
  explicit Articulated(const Chain& chain) : outwardTerms_(index(chain.size())) {
    bodies_.reserve(index(chain.size()));
    for (const Link& link : chain.links()) {
      bodies_.push_back({Real(link.mass),
                         Real(link.inertia),
                         {Real(link.com.x), Real(link.com.y)},
                         {Real(link.pin.x), Real(link.pin.y)}});
    }
  }

  int size() const { return static_cast<int>(bodies_.size()); }
  /// Writes the angular accelerations alpha, rad/s². e: exp(i θ_j). omega: ω_j, rad/s. N: moments, N m. F:
  /// forces without gravity, N, ground components. N and F are nullptr if there are none. Each array has n
  /// elements. ground: acceleration of the ground pin minus gravity, m/s². Allocates nothing.
  void accelerations(const Rotation<Real>* e, const Real* omega, const Real* N, const Vec2<Real>* F,
                     Vec2<Real> ground, Real* alpha) {
    Sym2<Real> A;
    Vec2<Real> b;
    for (int j = size() - 1; j >= 0; --j) {
      const BodyPose<Real> body = bodyPose(bodies_[index(j)], e[j], omega[j]);
      const Factors<Real> factors = inwards<false>(body, N ? N[j] : Real(0), A, b);
      if (F) b -= F[j];
      outwardTerms_[index(j)] = outwardTermsOf(factors, body);
    }
    Vec2<Real> a = ground;
    for (int j = 0; j < size(); ++j) alpha[j] = outwards(outwardTerms_[index(j)], a);
  }

 private:
  std::vector<Body<Real>> bodies_;
  std::vector<OutwardTerms<Real>> outwardTerms_;
};

}  // namespace planar_chain
