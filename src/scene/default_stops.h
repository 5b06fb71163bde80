#pragma once

/// Stops of joints with limits, as stiff as what they stop is heavy.

#include <cstddef>
#include <set>
#include <vector>

#include "planar_chain/chain.h"

namespace planar_chain {

/// Gives each stop without a stiffness k = J / τ² and, unless it is one of withDamping, d = 2 ζ J / τ, with
/// τ = 5 ms, ζ = 0.4. A joint then leaves it with exp(−2 ζ acos ζ/√(1 − ζ²)) = 0.36 of its rate; the torque
/// is at most 0.86 of that without damping. J of a prismatic joint is the mass from there outwards, otherwise
/// the moment of inertia about the joint of all links from there outwards, stretched. With M = Σ m and
/// S = Σ m ρ of the links outwards, at the distances ρ from their inner pin, a pin p further in:
///
///     J ← J + 2 |p| S + |p|² M        S ← S + |p| M
///
/// J may be 0 in a chain that is refused for it.
void setDefaultStops(const std::vector<Link>& links, const std::set<std::size_t>& withDamping,
                     std::vector<Joint>& joints);

}  // namespace planar_chain
