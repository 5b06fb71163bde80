#pragma once

/// Reads the frames of a scene.

#include "effects/effect_kind.h"
#include "planar_chain/scene.h"
#include "reading/section.h"

namespace planar_chain {

/// Key `frames` of a scene. names: nullptr if the links could not be read.
std::vector<Frame> readFrames(const Section& top, const std::vector<Sensor>& sensors,
                              const PublishSettings& publish, const ChainNames* names);

/// Adds a fault unless the text is a name that no link and no frame of the node has.
void requireOwnFrame(const Section& in, const std::string& name, const PublishSettings& publish,
                     const ChainNames* names);

/// Takes the key `link`, a name. Returns its number, or 0.
int takeLink(const Section& in, const ChainNames* names);
/// Takes the keys `point` and `angle` of a frame on a link.
void takePointAndAngle(const Section& in, Vec2d& point, double& angle);

}  // namespace planar_chain
