#pragma once

namespace planar_chain {

/// What acts on the bodies besides pins, gravity and inertia. Each has all before it.
enum class Acting {
  nothing,
  moments,  ///< springs, dampers, stops, joint torques
  forces,   ///< at points of links, with the moments that they have
};

}  // namespace planar_chain
