#pragma once

/// How far a machine extends, the first view of all of it, and its rails.

#include "planar_chain/scene.h"

namespace planar_chain {

/// A part of a straight line, m along its axis.
struct Range {
  double from, to;
};

/// True if a joint is prismatic and its axis turns with a link.
bool isInside(const Chain& chain, int joint);

/// The part of a prismatic joint's rail that is drawn. It ends at the limits of q. A side without a limit
/// within ten lengths of the chain is two lengths long, measured from the initial position or from the
/// drive's farthest one; on a link that turns a quarter of a length. links: Extent::links.
Range railOf(const Scene& scene, int slider, double links);

/// The largest |q| on that rail, m.
double travelOf(const Scene& scene, int slider, double links);

struct Extent {
  explicit Extent(const Scene& scene);

  double links = 0;  ///< m: the length of the chain, with prismatic joints at 0
  double reach = 0;  ///< m: the largest possible distance from the first pin; rails on links count
  Vec2d middle;  ///< m: no pin can be further than `span` from it. The first pin, or halfway to a pinned tip
  double span;   ///< m: the reach, or half of it

  // The part of the base frame that rviz shows at first; src/tools/show.py has the same formulas. It is
  // `half` high above and below `centre`, and at least as wide. It has room for the reach around each
  // position that rails and base allow. A long chain that falls from rest stays in the lower half of its
  // reach.
  Vec2d centre;  ///< m
  double half;   ///< m
};

/// The part of a tip's line that the chain can reach, from the point of the line that the scene gives.
Range lineOf(const Scene& scene, const Extent& extent);

}  // namespace planar_chain
