#include "scene/joint_types.h"

#include <string>

namespace planar_chain {

namespace {

/// The type that a link's other keys fit: only floating ones have a linear velocity, only prismatic ones an
/// axis and a position, and only prismatic ones may leave out their centre of mass.
JointType likelyType(const Section& link) {
  if (link.has("initial/linear_velocity")) return JointType::floating;
  return link.has("joint/axis") || link.has("initial/position") || !link.has("com") ? JointType::prismatic
                                                                                    : JointType::revolute;
}

}  // namespace

JointType takeType(const Section& link, bool& isSound) {
  const Value* joint = link.find("joint");
  if (!joint || !joint->map() || joint->map()->count("type") == 0) return JointType::revolute;
  std::string type;
  const auto isType = [](const std::string& text) {
    return text == "revolute" || text == "prismatic" || text == "floating";
  };
  if (!link.section("joint").takeText("type", isType, "revolute, prismatic or floating", type)) {
    isSound = false;
    return likelyType(link);
  }
  if (type == "floating") return JointType::floating;
  return type == "prismatic" ? JointType::prismatic : JointType::revolute;
}

FreeAxis freeAxis(const std::string& link, const std::string& joint, int axis) {
  const char* suffix = axis == 0 ? "_x" : "_y";
  FreeAxis free;
  free.link.name = link + suffix;
  free.joint.name = joint + suffix;
  free.joint.isPrismatic = true;
  free.joint.axis = axis == 0 ? Vec2d{1, 0} : Vec2d{0, 1};
  return free;
}

void refuseBesideTypes(const Section& top, const Chain& chain, const std::vector<Load>& loads) {
  for (const Load& load : loads) {
    if (load.link == Load::none || chain.coordinates().turner(load.link) >= 0 || load.moment == 0) continue;
    top.fault("loads/" + load.name + "/moment", "no moment on a prismatic link that does not turn",
              toText(load.moment));
  }
}

}  // namespace planar_chain
