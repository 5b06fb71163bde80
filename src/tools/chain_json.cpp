#include "tools/chain_json.h"

#include "effects/air_drag.h"
#include "effects/effect_kind.h"

namespace planar_chain::tools {

namespace {

using Json = nlohmann::json;

Json jsonOf(const MotionLaw& law) {
  const std::vector<MotionLaw::Piece>& pieces = law.pieces();
  if (pieces.size() == 1) {
    return {{"amplitude", law.amplitude()},
            {"frequency", law.frequency()},
            {"phase", law.phase()},
            {"offset", pieces[0].c[0]}};
  }
  Json times = Json::array(), values = Json::array();
  for (std::size_t k = 1; k < pieces.size(); ++k) {
    times.push_back(pieces[k].start);
    values.push_back(pieces[k].c[0]);
  }
  return {{"times", times}, {"values", values}};
}

/// A load that never stops has the stop null.
Json jsonOf(const Load& load, const Chain& chain) {
  Json all{{"start", load.start}, {"stop", load.stop}};
  if (load.link != Load::none) {
    all["link"] = chain.links()[index(load.link)].name;
    all["force"] = {load.force.x, load.force.y};
    all["point"] = {load.point.x, load.point.y};
    all["moment"] = load.moment;
  }
  if (load.joint != Load::none) {
    all["joint"] = chain.joints()[index(load.joint)].name;
    all["torque"] = load.torque;
  }
  if (const auto* sine = std::get_if<Sine>(&load.law)) {
    all["frequency"] = sine->frequency;
    all["phase"] = sine->phase;
  } else if (const auto* ramp = std::get_if<Ramp>(&load.law)) {
    all["times"] = ramp->times;
    all["values"] = ramp->values;
  }
  return all;
}

Json jsonOf(const GroundSpring& spring, const Link& link) {
  return {{"link", link.name},
          {"point", {spring.point.x, spring.point.y}},
          {"ground", {spring.ground.x, spring.ground.y}},
          {"stiffness", spring.stiffness},
          {"damping", spring.damping},
          {"rest_length", spring.restLength},
          {"slack", spring.goesSlack}};
}

Json jsonOf(const Frame& frame, const Chain& chain) {
  return {{"link", chain.links()[index(frame.link)].name},
          {"point", {frame.point.x, frame.point.y}},
          {"angle", frame.angle}};
}

Json jsonOf(const TipLaws& tip) {
  if (!tip.line) return {{"pin", {{"x", jsonOf(tip.x)}, {"y", jsonOf(tip.y)}}}};
  return {{"line",
           {{"point", {tip.x.at(0).value, tip.y.at(0).value}}, {"direction", {tip.line->x, tip.line->y}}}}};
}

}  // namespace

Json chainAsJson(const Scene& scene, const Eigen::VectorXd& q, const Eigen::VectorXd& qd) {
  const Chain& chain = scene.chain;
  Json links = Json::array(), springs = Json::object();
  for (std::size_t i = 0; i < chain.links().size(); ++i) {
    const Link& link = chain.links()[i];
    const Joint& joint = chain.joints()[i];
    Json ofJoint{{"name", joint.name}};
    if (joint.isPrismatic) {
      ofJoint["type"] = "prismatic";
      ofJoint["axis"] = {joint.axis.x, joint.axis.y};
    }
    for (const EffectKind* kind : effectKinds()) {
      for (const JointKey& key : kind->jointKeys()) {
        if (key.member || joint.has(key.name))
          ofJoint[Json::json_pointer(std::string("/") + key.name)] = key.of(joint);
      }
    }
    links.push_back({{"name", link.name},
                     {"mass", link.mass},
                     {"inertia", link.inertia},
                     {"com", {link.com.x, link.com.y}},
                     {"pin", {link.pin.x, link.pin.y}},
                     {"joint", ofJoint}});
    const auto [drag, at] = airDragOf(link);
    if (drag > 0) links.back()["drag"] = {{"coefficient", drag}, {"point", {at.x, at.y}}};
    for (const GroundSpring& spring : link.springs) springs[spring.name] = jsonOf(spring, link);
  }
  for (const Drive& drive : scene.drives) links[index(drive.joint)]["joint"]["drive"] = jsonOf(drive.law);
  Json loads = Json::object();
  for (const Load& load : scene.loads) loads[load.name] = jsonOf(load, chain);
  Json all{{"gravity", {chain.gravity().x, chain.gravity().y}},
           {"q", std::vector<double>(q.data(), q.data() + q.size())},
           {"qd", std::vector<double>(qd.data(), qd.data() + qd.size())},
           {"links", links}};
  if (!loads.empty()) all["loads"] = loads;
  if (!springs.empty()) all["springs"] = springs;
  if (const auto& base = scene.base) {
    all["base"] = {{"x", jsonOf(base->x)}, {"y", jsonOf(base->y)}, {"angle", jsonOf(base->angle)}};
  }
  if (scene.tip) all["tip"] = jsonOf(*scene.tip);
  for (const Frame& frame : scene.frames) all["frames"][frame.name] = jsonOf(frame, chain);
  return all;
}

}  // namespace planar_chain::tools
