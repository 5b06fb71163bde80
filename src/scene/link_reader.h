#pragma once

/// One entry of `links` in a scene.

#include <optional>
#include <string>

#include "planar_chain/chain.h"
#include "planar_chain/motion_law.h"
#include "scene/effect_values.h"

namespace planar_chain {

/// One entry of `links`, for `repeat` equal links.
struct Entry {
  Link link;
  Joint joint;
  double q = 0;
  double qd = 0;
  std::optional<MotionLaw> drive{};
  int repeat = 1;
  bool isSound = true;          ///< else there are faults in the names or the joint's type
  bool isCounted = true;        ///< else there is a fault in `repeat`
  bool hasStopDamping = false;  ///< true if the scene gives it, perhaps 0
  bool floats = false;          ///< nothing holds the inner pin, with this position and velocity
  Vec2d position{}, linearVelocity{};
};

/// Reads the entry `name`.
Entry readEntry(const Section& links, const std::string& name);
/// Reads the entry of a link of a URDF. It may only have what URDF cannot express, and limits in place of
/// those of the URDF.
void takeBeside(const Section& links, Entry& entry);

}  // namespace planar_chain
