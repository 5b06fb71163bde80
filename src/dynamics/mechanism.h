#pragma once

/// What never changes of a chain: its bodies, and how its recursion is gone through. Chosen once, by the
/// length and the processor; shared by all that computes with it.
///
/// Behind slides the bodies that turn are a chain of their own: `bodies()`. Recursions have those alone.

#include <optional>
#include <variant>

#include "dynamics/rails.h"
#include "lanes/arrangement.h"
#include "lanes/segments.h"
#include "lanes/short_chain.h"
#include "planar_chain/chain.h"

namespace planar_chain {

/// The recursion for q̈, with its room: written out for short chains, in segments for long ones.
using Recursion = std::variant<ShortChain, Segments>;

class Mechanism {
 public:
  /// The chain must outlive this object. inOrder: a long chain is kept in chain order too.
  /// holdsTip: something holds the tip. Then the chain is kept in chain order.
  explicit Mechanism(const Chain& chain, bool inOrder = false, bool holdsTip = false);

  const Chain& chain() const { return chain_; }
  int size() const { return n_; }  ///< n
  const Coordinates& coordinates() const { return coordinates_; }
  int slides() const { return coordinates_.slides(); }
  /// The bodies that turn: the chain itself, if none slides.
  const Chain& bodies() const { return bodies_ ? *bodies_ : chain_; }
  /// True if the chain has ends (recursion/ends.h).
  bool hasEnds() const { return slides() > 0 || holdsTip_; }
  /// The order of a long chain's bodies, in which its states are kept; nullptr: chain order.
  const Arrangement* lanes() const { return lanes_ ? &*lanes_ : nullptr; }
  /// The numbers that one quantity of all bodies takes in that order: n, or more.
  int places() const { return places_; }
  Recursion makeRecursion() const;
  /// As rotations() of lanes/segments.h.
  void rotate(const double* theta, Rotation<double>* e, int n) const { rotations_(theta, &e->c, n); }
  /// The same of the bodies that turn, of all n in chain order, on a base that is turned by `angle`.
  void rotate(const double* theta, double angle, Rotation<double>* e) const;

  /// [θ ω] from chain order to lane order and back; not in place. Allocate nothing.
  void toLanes(const double* inOrder, double* inLanes) const;
  void toOrder(const double* inLanes, double* inOrder) const;
  /// One number of each body.
  const double* quantityInLanes(const double* values, double* room) const;
  /// [θ ω] in chain order: copied to `room`, or as it stands where that is the order already.
  const double* stateInOrder(const double* y, double* room) const;

  /// Writes the velocities of the first `count` inner pins, m/s, from e = exp(i θ_j) and the rates ω_j in
  /// chain order. Those of slides (rails.h) are left out. v: of the first other one. Allocates nothing.
  void findPinVelocities(const Rotation<double>* e, const double* omega, int count, Vec2d* velocities,
                         Vec2d v = {}) const;
  /// Writes how the places and velocities of these pins change if each θ_j changes by u_j and ω_j by v_j:
  ///
  ///     δx_next = δx + u iP      δẋ_next = δẋ + v iP − ω u P
  ///
  /// and those of slides as `rails` say. dx, dv: of the ground pin. Places may be nullptr. Allocates nothing.
  void findPinChanges(const Rotation<double>* e, const double* omega, const double* u, const double* v,
                      int count, const Rails<Dual>& rails, Vec2d* places, Vec2d* velocities, Vec2d dx = {},
                      Vec2d dv = {}) const;

 private:
  const Chain& chain_;
  Coordinates coordinates_;
  std::optional<Chain> bodies_;
  int n_;
  bool holdsTip_;
  std::optional<Arrangement> lanes_;
  int places_;
  void (*rotations_)(const double* theta, double* e, int n);
};

}  // namespace planar_chain
