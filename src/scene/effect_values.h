#pragma once

/// The values of effects in a scene: numbers below a joint, a link and the scene itself, by the keys that the
/// kinds of effect have.

#include <set>
#include <string>
#include <vector>

#include "effects/effect_kind.h"
#include "reading/section.h"

namespace planar_chain {

/// The joint with some stiffness of its stop, if it has a limit.
Joint withStop(Joint joint);

/// The keys of effects in a link.
std::vector<const char*> linkKeys();
/// Reads and checks those that are given.
void takeEffects(const Section& in, Link& link);

/// The keys of effects in a joint, maps by their name.
std::vector<const char*> effectKeys(bool isInUrdf);
/// Hints for keys of these maps that are written in the joint itself.
Hints hintsAtMaps(const std::string& joint);
/// Reads and checks the values of the effects in a joint. A joint with faults keeps none. A stop without a
/// stiffness keeps 0.
void takeEffects(const Section& in, Joint& joint);

/// True if the joint has a value that a driven joint may not have.
bool hasMoreThanDrive(const Joint& joint);

/// Removes the limits that the URDF gives to a joint, by the scene's key `limits`.
void takeNoLimits(const Section& in, Joint& joint);
/// The links of a URDF to whose joints the scene gives both limits, or none.
std::set<std::string> limitedIn(const Section& links);

/// Hints for keys of a link, or of the scene, at the wrong level, and for unsupported keys.
Hints hintsIn(const std::string& link);
Hints hintsAtTop();

}  // namespace planar_chain
