#include "planar_chain/scene_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "dynamics/equilibrium.h"
#include "effects/effect_kind.h"
#include "planar_chain/energy.h"
#include "planar_chain/urdf_reader.h"
#include "reading/section.h"
#include "scene/law_reader.h"
#include "scene/settings_reader.h"

namespace planar_chain {

namespace {

constexpr double highestFactor = 1000;
constexpr double missing = std::numeric_limits<double>::quiet_NaN();

// ---- links -----------------------------------------------------------------------------------

/// One entry of `links`. It stands for `repeat` equal links.
struct Entry {
  Link link;
  Joint joint;
  double q = 0;
  double qd = 0;
  std::optional<MotionLaw> drive{};
  int repeat = 1;
  bool namesAreSound = true;
};

/// Stands for a body with faults, so that the names and the other links can still be checked.
Link disc(const std::string& name) {
  return {name, 1, 1, {0, 0}, {1, 0}};
}

/// The joint with some stiffness of its stop, if it has a limit.
Joint withStop(Joint joint) {
  if (joint.isLimited()) joint.stopStiffness = 1;
  return joint;
}

/// Reads and checks the values of the effects in a joint. A joint with faults keeps none. A stop without a
/// stiffness keeps 0: setDefaultStops() gives it one.
void takeEffects(const Section& in, Joint& joint) {
  std::set<std::string> refused;
  for (const EffectKind* kind : effectKinds()) {
    for (const JointKey& key : kind->jointKeys()) {
      if (!in.has(key.name)) continue;
      const double value = in.unchecked(key.name, missing);
      if (!std::isfinite(value)) {
        in.fault(key.name, key.range.inWords(value));
        refused.insert(key.name);
      } else if (key.member) {
        joint.*key.member = value;
      } else {
        joint.others.emplace_back(key.name, value);
      }
    }
  }
  for (const Fault& fault : faultsOf(in.has("stop_stiffness") ? joint : withStop(joint))) {
    const std::string key = fault.path.substr(fault.path.find('/') + 1);
    if (refused.insert(key).second) in.fault(key, fault.expected);
  }
  if (!refused.empty()) joint = {joint.name};
}

/// Reads `drive`, which gives the angle: nothing else may.
void takeDrive(const Section& link, const Section& joint, Entry& entry) {
  entry.drive = readLaw(joint, "drive", "rad", true);
  for (const char* other :
       {"friction", "breakaway", "stiffness", "damping", "rest_angle", "lower", "upper"}) {
    if (joint.has(other)) joint.fault(other, std::string("no ") + other + " in a driven joint");
  }
  if (link.has("initial")) link.fault("initial", "no initial state of a driven joint", "initial");
  const GivenMotion start = entry.drive->at(0);
  entry.q = start.value;
  entry.qd = start.rate;
}

/// Reads `joint` and `initial` of a link. A link of a URDF may only have what URDF cannot express.
void takeMotion(const Section& in, bool isInUrdf, Entry& entry) {
  std::vector<const char*> keys{"drive"};
  if (!isInUrdf) keys.push_back("name");
  for (const EffectKind* kind : effectKinds()) {
    for (const JointKey& key : kind->jointKeys()) {
      if (!isInUrdf || !key.isInUrdf) keys.push_back(key.name);
    }
  }
  const Section joint = in.section("joint", keys);
  if (joint.has("name") && !isInUrdf) {
    entry.namesAreSound &= joint.takeText("name", isName, nameInWords, entry.joint.name);
  }
  takeEffects(joint, entry.joint);

  const Section initial = in.section("initial", {"angle", "velocity"});
  const Joint complete = withStop(entry.joint);
  if (initial.take("angle", NumberRule::any("rad"), entry.q) && std::abs(entry.q) > largestAngle(complete)) {
    initial.fault("angle", storesEnergy(complete)
                               ? "a number from -1e6 to 1e6 rad (the joint has a spring or a limit)"
                               : "a number from -5e16 to 5e16 rad (2^53 turns)");
  }
  initial.take("velocity", NumberRule::any("rad/s"), entry.qd);
  if (joint.has("drive")) takeDrive(in, joint, entry);
}

Entry readEntry(const Section& links, const std::string& name) {
  // The name.
  Entry entry{disc(name), {}};
  const Section in = links.section(name, {"mass", "inertia", "com", "pin", "repeat", "joint", "initial"});
  if (!isName(name)) {
    links.fault(name, nameInWords, quoted(name));
    entry.namesAreSound = false;
  }
  if (!links.find(name)->map()) return entry;

  // The body.
  const Vec2d nowhere{missing, missing};
  const Link link{name, in.unchecked("mass", missing), in.unchecked("inertia", missing),
                  in.unchecked("com", nowhere), in.unchecked("pin", nowhere)};
  const std::vector<Fault> ofLink = faultsOf(link);
  for (const Fault& fault : ofLink) in.fault(fault.path, fault.expected);
  if (ofLink.empty()) entry.link = link;

  // The number of links.
  if (!takeCount(in, "repeat", entry.repeat)) entry.namesAreSound = false;

  takeMotion(in, false, entry);
  return entry;
}

// ---- chain -----------------------------------------------------------------------------------

/// The links in chain order, with `repeat` expanded.
struct Expanded {
  std::vector<Link> links;
  std::vector<Joint> joints;
  std::vector<double> q;
  std::vector<double> qd;
  std::vector<Drive> drives;
  ChainNames names;
  std::map<std::string, std::string> entryOf;  ///< the key in `links`, by link name
  Vec2d gravity{0, -9.81};                     ///< m/s², unless the scene sets it
};

/// Adds the links of an entry, numbered if there are several.
void append(const Entry& entry, Expanded& to) {
  for (int i = 1; i <= entry.repeat; ++i) {
    const std::string suffix = entry.repeat > 1 ? "_" + std::to_string(i) : "";
    Link link = entry.link;
    Joint joint = entry.joint;
    link.name += suffix;
    joint.name = joint.name.empty() ? link.name + "_joint" : joint.name + suffix;
    const int at = static_cast<int>(to.links.size());
    to.names.links.emplace(link.name, at);
    to.names.joints.emplace(joint.name, at);
    to.names.com.push_back(link.com);
    to.entryOf.emplace(link.name, entry.link.name);
    to.links.push_back(std::move(link));
    to.joints.push_back(std::move(joint));
    to.q.push_back(entry.q);
    to.qd.push_back(entry.qd);
    if (entry.drive) to.drives.push_back({at, *entry.drive});
  }
}

/// The links from `chain` and `links`.
/// @returns nothing if there is a fault in the order or in the names
std::optional<Expanded> readLinks(const Section& top) {
  // All entries, whether listed in `chain` or not.
  const Section links = top.section("links");
  if (links.entries().empty() && (!top.has("links") || top.find("links")->map())) {
    top.fault("links", "a map with at least one link");
  }
  std::map<std::string, Entry> entries;
  bool isCertain = true;
  for (const auto& [name, value] : links.entries()) {
    isCertain &= entries.emplace(name, readEntry(links, name)).first->second.namesAreSound;
  }

  // The order: each name of `chain` once, and every entry.
  const Value* chain = top.find("chain");
  const Value::List* order = chain ? chain->list() : nullptr;
  if (!order || order->empty()) {
    top.fault("chain", "a list of link names, from the ground pin outwards");
    return std::nullopt;
  }
  std::vector<const Entry*> inOrder;
  std::set<std::string> listed;
  long long total = 0;
  for (std::size_t i = 0; i < order->size(); ++i) {
    const Value& name = (*order)[i];
    const auto entry = name.text() ? entries.find(*name.text()) : entries.end();
    const char* fault = entry == entries.end()                ? "the name of an entry in links"
                        : !listed.insert(entry->first).second ? "each link only once"
                                                              : nullptr;
    if (fault) {
      top.fault("chain/" + std::to_string(i), fault, describe(name));
      isCertain = false;
    } else {
      inOrder.push_back(&entry->second);
      total += entry->second.repeat;
    }
  }
  for (const auto& entry : entries) {
    if (listed.count(entry.first) == 0) {
      links.fault(entry.first, "a link listed in chain", quoted(entry.first));
    }
  }
  if (total > mostLinks) {
    top.fault("chain", "at most " + std::to_string(mostLinks) + " links, with repeated ones counted",
              std::to_string(total));
    isCertain = false;
  }

  // The chain.
  if (!isCertain) return std::nullopt;
  Expanded expanded;
  for (const Entry* entry : inOrder) append(*entry, expanded);
  return expanded;
}

/// The links of the URDF in `robot_description`. `links` adds what URDF cannot express.
/// @returns nothing if there is a fault in the URDF
std::optional<Expanded> readRobot(const Section& top, std::vector<Fault>& faults) {
  // The URDF.
  if (top.has("chain")) top.fault("chain", "no chain beside robot_description, which gives the order");
  const std::string* text = top.find("robot_description")->text();
  if (!text) {
    top.fault("robot_description", "the text of a URDF");
    return std::nullopt;
  }
  std::optional<PlanarRobot> robot;
  try {
    robot = findRobot(*text, faults);
  } catch (const Refused& refused) {
    faults.insert(faults.end(), refused.faults().begin(), refused.faults().end());
  }
  // A URDF within a scene counts its lines from its own first one.
  if (top.find("robot_description")->line > 0) {
    for (Fault& fault : faults) fault.line = 0;
  }
  if (!robot) return std::nullopt;

  // Springs, stops and initial state from `links`.
  Expanded expanded;
  expanded.gravity = robot->gravity;
  const Section links = top.section("links");
  for (std::size_t i = 0; i < robot->links.size(); ++i) {
    const std::string name = robot->links[i].name;
    Entry entry{std::move(robot->links[i]), std::move(robot->joints[i])};
    takeMotion(links.section(name, {"joint", "initial"}), true, entry);
    append(entry, expanded);
  }
  for (const auto& entry : links.entries()) {
    if (expanded.names.links.count(entry.first) != 0) continue;
    links.fault(entry.first, "a moving link of robot_description", quoted(entry.first));
  }
  return expanded;
}

/// Gives each stop without a stiffness k = J / τ², so that a joint goes at most q̇ τ into it. J is the moment
/// of inertia about the joint of all links from there outwards, stretched. With M = Σ m and S = Σ m ρ of the
/// links outwards, at the distances ρ from their inner pin, a pin p further in:
///
///     J ← J + 2 |p| S + |p|² M        S ← S + |p| M
void setDefaultStops(const std::vector<Link>& links, std::vector<Joint>& joints) {
  constexpr double tau = 0.005;  // s
  double M = 0, S = 0, J = 0;
  for (std::size_t i = links.size(); i-- > 0;) {
    const Link& link = links[i];
    const double p = length(link.pin), r = length(link.com);
    J += 2 * p * S + p * p * M + link.mass * r * r + link.inertia;
    S += p * M + link.mass * r;
    M += link.mass;
    Joint& joint = joints[i];
    if (joint.isLimited() && joint.stopStiffness == 0) joint.stopStiffness = J / (tau * tau);
  }
}

/// Makes the chain. Its faults are reported at the keys of the scene, those of repeated links only once.
std::optional<Chain> makeChain(const Expanded& from, Vec2d gravity, std::vector<Fault>& faults) {
  try {
    return Chain(from.links, from.joints, gravity);
  } catch (const Refused& refused) {
    const std::string links = "links/";
    std::set<std::pair<std::string, std::string>> reported;
    for (Fault fault : refused.faults()) {
      const std::size_t end = fault.path.find('/', links.size());
      const std::string name = fault.path.substr(links.size(), end - links.size());
      const std::string rest = end == std::string::npos ? "" : fault.path.substr(end);
      fault.path = links + from.entryOf.at(name) + rest;
      if (reported.emplace(fault.path, fault.expected).second) faults.push_back(std::move(fault));
    }
    return std::nullopt;
  }
}

/// Records a fault if the initial energy overflows, which finite values do not exclude.
void requireFiniteEnergy(const Chain& chain, const Expanded& from, std::vector<Fault>& faults) {
  std::vector<double> theta(from.q.size()), omega(from.qd.size());
  toAbsolute(from.q.data(), chain.size(), theta.data());
  toAbsolute(from.qd.data(), chain.size(), omega.data());
  const double energy = energyOf(chain, theta.data(), omega.data()).total();
  if (!std::isfinite(energy)) {
    faults.push_back({"links", "a chain and initial rates of finite energy", toText(energy) + " J"});
  }
}

/// Puts the scene at rest in its equilibrium at t = 0.
void startAtRest(Scene& scene, const Section& top) {
  try {
    scene.q = equilibriumOf(scene, 0, scene.q);
  } catch (const std::domain_error& none) {
    top.fault("start", "initial, as there is no equilibrium", none.what());
  }
  std::fill(scene.qd.begin(), scene.qd.end(), 0.0);
  for (const Drive& drive : scene.drives) scene.qd[index(drive.joint)] = drive.law.at(0).rate;
}

}  // namespace

// ---- The scene -------------------------------------------------------------------------------

Scene readScene(const Value& value) {
  std::vector<Fault> faults;
  std::vector<const char*> keys{"chain", "gravity", "links"};
  for (const EffectKind* kind : effectKinds()) {
    if (kind->sceneKey()) keys.push_back(kind->sceneKey());
  }
  for (const char* key : {"base", "start", "integrator", "publish", "command_timeout", "real_time_factor",
                          "robot_description"}) {
    keys.push_back(key);
  }
  const Section top(&value, "", keys, faults);

  // The chain.
  std::optional<Expanded> expanded = top.has("robot_description") ? readRobot(top, faults) : readLinks(top);
  const ChainNames* names = expanded ? &expanded->names : nullptr;
  std::optional<Chain> chain;
  Vec2d gravity = expanded ? expanded->gravity : Vec2d{};
  top.take("gravity", "m/s²", gravity);
  if (expanded) setDefaultStops(expanded->links, expanded->joints);
  if (expanded) chain = makeChain(*expanded, gravity, faults);

  // All other keys.
  std::vector<Load> loads;
  for (const EffectKind* kind : effectKinds()) kind->takeScene(top, names, loads);
  const IntegratorSettings integrator =
      readIntegrator(top.section("integrator", {"method", "tolerance", "step", "plain_kernel"}));
  PublishSettings publish =
      readPublish(top.section("publish", {"rate", "tf_rate", "status_rate", "tf", "link_states",
                                          "frame_every", "frame_prefix", "world_frame", "base_frame"}),
                  names);
  std::string start = "initial";
  const auto isStart = [](const std::string& text) { return text == "initial" || text == "rest"; };
  top.takeText("start", isStart, "initial or rest", start);
  std::optional<BaseLaws> base;
  if (top.has("base")) base = readBase(top.section("base", {"x", "y", "angle"}));
  double commandTimeout = 0;
  top.take("command_timeout", NumberRule::from(0, "s"), commandTimeout);
  std::optional<double> realTimeFactor;
  if (top.has("real_time_factor")) {
    const std::string range = " >= 0 and <= " + toText(highestFactor);
    top.take("real_time_factor",
             {range + " (simulated time per wall time; 0: as fast as possible)", 0, highestFactor, true},
             realTimeFactor.emplace());
  }

  const auto throwFaults = [&] {
    for (Fault& fault : faults) {
      if (fault.line == 0) fault.line = lineAt(value, fault.path);
    }
    if (!faults.empty()) throw Refused(std::move(faults));
  };
  throwFaults();
  requireFiniteEnergy(*chain, *expanded, faults);
  Scene scene{std::move(*chain),
              std::move(expanded->q),
              std::move(expanded->qd),
              std::move(loads),
              integrator,
              std::move(publish),
              commandTimeout,
              realTimeFactor,
              std::move(expanded->drives),
              std::move(base)};
  if (start == "rest") startAtRest(scene, top);
  throwFaults();
  return scene;
}

Scene readSceneText(const std::string& yaml) {
  return readScene(parseYaml(yaml));
}

}  // namespace planar_chain
