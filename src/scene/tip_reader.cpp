#include "scene/tip_reader.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "dynamics/closed_state.h"
#include "dynamics/given_state.h"
#include "effects/stick_slip.h"
#include "model/prismatic.h"
#include "scene/settings_reader.h"

namespace planar_chain {

namespace {

void takePin(const Section& tip, TipLaws& laws) {
  if (tip.find("pin")->map()) {
    const Section pin = tip.section("pin", {"x", "y"});
    for (const char* axis : {"x", "y"}) {
      if (!pin.has(axis)) pin.fault(axis, "a law of motion, such as {offset: 1.0}", "nothing");
    }
    if (pin.has("x")) laws.x = readLaw(pin, "x", "m", false);
    if (pin.has("y")) laws.y = readLaw(pin, "y", "m", false);
    return;
  }
  Vec2d at;
  if (!tip.take("pin", "m", at)) return;
  laws.x = MotionLaw::sine(0, 0, 0, at.x);
  laws.y = MotionLaw::sine(0, 0, 0, at.y);
}

void takeLine(const Section& tip, TipLaws& laws) {
  const Section line = tip.section("line", {"point", "direction"});
  Vec2d point, along{1, 0};
  line.take("point", "m", point);
  line.take("direction", "no unit: a direction", along);
  if (!isDirection(along)) line.fault("direction", directionInWords);
  laws.line = (isDirection(along) ? 1 / length(along) : 1) * along;
  laws.x = MotionLaw::sine(0, 0, 0, point.x);
  laws.y = MotionLaw::sine(0, 0, 0, point.y);
}

/// The key below `tip` that this chain has.
std::string keyOf(const TipLaws& tip) {
  return tip.line ? "tip/line" : "tip/pin";
}

}  // namespace

std::optional<TipLaws> takeTip(const Section& top) {
  if (!top.has("tip")) return std::nullopt;
  const Section tip = top.section("tip", {"pin", "line"});
  TipLaws laws;
  if (tip.has("pin") == tip.has("line")) {
    if (top.find("tip")->map()) top.fault("tip", "pin or line", tip.has("pin") ? "both" : "neither");
    return std::nullopt;
  }
  tip.has("pin") ? takePin(tip, laws) : takeLine(tip, laws);
  return laws;
}

std::optional<TipLaws> takeTip(const Section& top, const Chain& chain, const std::vector<Drive>& drives) {
  std::optional<TipLaws> tip = takeTip(top);
  if (!tip) return tip;
  // Joints that are held, or may stick, leave too few to close the chain.
  int moving = chain.size() - static_cast<int>(drives.size());
  std::string held;
  const auto take = [&held](const char* how, const Joint& joint) {
    held += (held.empty() ? ", as " : ", ") + (how + joint.name);
  };
  for (const Drive& drive : drives) take("a drive gives ", chain.joints()[index(drive.joint)]);
  for (const Joint& joint : chain.joints()) {
    if (!mayStick(joint)) continue;
    --moving;
    take("friction may hold ", joint);
  }
  if (moving < tip->rows()) {
    top.fault(keyOf(*tip),
              tip->rows() == 2 ? "at least 2 joints without drive and friction"
                               : "a joint without drive and friction",
              std::to_string(moving) + held);
  }
  return tip;
}

bool closeStart(Scene& scene, const Section& top) {
  if (!scene.tip) return true;
  const std::vector<double> given = scene.q;
  const Closing closing = closeState(scene, 0, scene.q, scene.qd);
  if (!closing.isClosed) {
    char gap[40];
    std::snprintf(gap, sizeof gap, "a gap of %.6g m", closing.gap);
    top.fault(keyOf(*scene.tip), "a place that the tip reaches", gap);
    return false;
  }
  if (closing.onlyTouches) {
    top.fault(keyOf(*scene.tip), "a line that the tip crosses", "one that it touches and cannot leave");
    return false;
  }
  const std::string moved = movedWords("", scene.chain, given.data(), scene.q.data());
  if (!moved.empty()) scene.notes.push_back({keyOf(*scene.tip), moved});
  return true;
}

}  // namespace planar_chain
