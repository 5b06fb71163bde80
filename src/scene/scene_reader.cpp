#include "planar_chain/scene_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>
#include <utility>

#include "ode/methods.h"
#include "planar_chain/energy.h"
#include "planar_chain/urdf_reader.h"
#include "reading/names.h"
#include "reading/section.h"
#include "scene/accuracy.h"
#include "scene/default_stops.h"
#include "scene/frames_reader.h"
#include "scene/joint_types.h"
#include "scene/link_reader.h"
#include "scene/scene_numbers.h"
#include "scene/sensors_reader.h"
#include "scene/settings_reader.h"
#include "scene/tip_reader.h"

namespace planar_chain {

namespace {

// ---- chain -----------------------------------------------------------------------------------

/// The links in chain order, with `repeat` expanded.
struct Expanded {
  std::vector<Link> links;
  std::vector<Joint> joints;
  std::vector<double> q;
  std::vector<double> qd;
  std::vector<Drive> drives;
  std::set<std::size_t> withStopDamping;  ///< the joints to which the scene gives it
  ChainNames names;
  std::map<std::string, std::string> entryOf;  ///< the key in `links`, by link name
  Vec2d gravity{0, -9.81};                     ///< m/s², unless the scene sets it
  Appearance appearance;
  std::vector<Note> notes;
  bool isFloating = false;
  bool isOrdered = true;  ///< else there are faults in `chain` or in names, and the links are in any order
};

/// Adds the two prismatic joints below a floating link, which have no names for others.
void appendFreeAxes(const Entry& entry, Expanded& to) {
  to.isFloating = true;
  for (int axis = 0; axis < 2; ++axis) {
    FreeAxis free = freeAxis(entry.link.name, entry.joint.name, axis);
    to.names.joints.emplace(free.joint.name, static_cast<int>(to.links.size()));
    to.names.com.push_back({});
    to.entryOf.emplace(free.link.name, entry.link.name);
    to.links.push_back(std::move(free.link));
    to.joints.push_back(std::move(free.joint));
    to.q.push_back(axis == 0 ? entry.position.x : entry.position.y);
    to.qd.push_back(axis == 0 ? entry.linearVelocity.x : entry.linearVelocity.y);
  }
}

/// Adds the links of an entry, numbered if there are several.
void append(const Entry& entry, Expanded& to) {
  if (entry.floats) appendFreeAxes(entry, to);
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
    if (entry.hasStopDamping) to.withStopDamping.insert(to.joints.size());
    to.links.push_back(std::move(link));
    to.joints.push_back(std::move(joint));
    to.q.push_back(entry.q);
    to.qd.push_back(entry.qd);
    if (entry.drive) to.drives.push_back({at, *entry.drive});
  }
}

/// Notes angles of many turns, which may be degrees.
void noteDegrees(const Section& links, const Entry& entry, std::vector<Note>& notes) {
  constexpr double most = 2;  // turns
  const Joint& joint = entry.joint;
  const double initial = entry.drive ? 0 : entry.q;
  for (const auto& [key, angle] : {std::pair("/initial/angle", initial),
                                   {"/joint/rest_angle", joint.restAngle},
                                   {"/joint/lower", joint.lower},
                                   {"/joint/upper", joint.upper}}) {
    const double turns = std::abs(angle) / (2 * pi);
    if (joint.isPrismatic || !(turns > most && std::isfinite(turns))) continue;
    std::array<char, 80> text{};
    std::snprintf(text.data(), text.size(), "%g rad are %.3g turns (angles are in rad, not in degrees)",
                  angle, turns);
    notes.push_back({links.pathOf(entry.link.name) + key, text.data()});
  }
}

/// The links from `chain` and `links`.
/// @returns nothing if their names are not known
std::optional<Expanded> readLinks(const Section& top) {
  // All entries, whether listed in `chain` or not.
  const Section links = top.section("links");
  if (links.entries().empty() && (!top.has("links") || top.find("links")->map())) {
    top.fault("links", "a map with at least one link");
  }
  std::map<std::string, Entry> entries;
  std::vector<std::string> names;
  bool areSound = true, areCounted = !links.entries().empty();
  for (const auto& [name, value] : links.entries()) {
    const Entry& entry = entries.emplace(name, readEntry(links, name)).first->second;
    areSound &= entry.isSound;
    areCounted &= entry.isCounted;
    names.push_back(name);
  }

  // The order: each name of `chain` once, and every entry.
  Expanded expanded;
  const Value* chain = top.find("chain");
  const Value::List order = chain && chain->list() ? *chain->list() : Value::List();
  expanded.isOrdered = areSound && !order.empty();
  if (order.empty()) top.fault("chain", "a list of link names, from the ground pin outwards");
  std::set<std::string> listed;
  long long total = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::string* name = order[i].text();
    const auto entry = name ? entries.find(*name) : entries.end();
    if (entry == entries.end() || !listed.insert(*name).second) {
      top.fault("chain/" + std::to_string(i),
                entry != entries.end() ? "each link only once"
                                       : orClosest("the name of an entry in links", name ? *name : "", names),
                describe(order[i]));
      expanded.isOrdered = false;
      continue;
    }
    total += entry->second.repeat;
    if (entry->second.floats && i > 0) {
      links.fault(entry->first + "/joint/type", "floating of the first link only", "\"floating\"");
      entry->second.floats = false;
    }
    noteDegrees(links, entry->second, expanded.notes);
    if (total <= mostLinks) append(entry->second, expanded);
  }
  if (total > mostLinks) {
    top.fault("chain", "at most " + std::to_string(mostLinks) + " links, with repeated ones counted",
              std::to_string(total));
  }
  for (const auto& [name, entry] : entries) {
    if (listed.count(name) != 0) continue;
    if (!order.empty()) {
      links.fault(name, orClosest("a link listed in chain", name, {listed.begin(), listed.end()}),
                  quoted(name));
    }
    expanded.isOrdered = false;
    total += entry.repeat;
    if (total <= mostLinks) append(entry, expanded);  // others may name it
  }
  return areCounted && total <= mostLinks ? std::optional(std::move(expanded)) : std::nullopt;
}

/// The links of the URDF in `robot_description`. `links` adds what URDF cannot express.
/// @returns nothing if there is a fault in the URDF
std::optional<Expanded> readRobot(const Section& top, std::vector<Fault>& faults) {
  // The URDF.
  if (top.has("chain")) top.fault("chain", "no chain beside robot_description, which gives the order");
  const Value& urdf = *top.find("robot_description");
  const Section links = top.section("links");
  std::optional<PlanarRobot> robot;
  if (!urdf.text()) top.fault("robot_description", "the text of a URDF");
  try {
    if (urdf.text()) robot = findRobot(*urdf.text(), faults, limitedIn(links));
  } catch (const Refused& refused) {
    faults.insert(faults.end(), refused.faults().begin(), refused.faults().end());
  }
  // A URDF within a scene counts its lines from its own first one.
  for (Fault& fault : faults) fault.line = urdf.line > 0 ? 0 : fault.line;
  if (!robot) return std::nullopt;

  // Springs, stops and initial state from `links`.
  Expanded expanded;
  expanded.gravity = robot->gravity;
  expanded.appearance = std::move(robot->appearance);
  expanded.notes = std::move(robot->notes);
  for (Note& note : expanded.notes) note.line = urdf.line > 0 ? 0 : note.line;
  for (std::size_t i = robot->floats ? 2 : 0; i < robot->links.size(); ++i) {
    Entry entry{std::move(robot->links[i]), std::move(robot->joints[i])};
    entry.floats = robot->floats && i == 2;  // append() adds its two prismatic joints
    takeBeside(links, entry);
    append(entry, expanded);
  }
  for (const auto& [name, value] : links.entries()) {
    const bool isKnown = expanded.names.links.count(name) != 0;
    if (!isKnown) links.fault(name, "a moving link of robot_description", quoted(name));
  }
  return expanded;
}

/// Makes the chain. Its faults are reported at the keys of the scene, those of repeated links only once.
std::optional<Chain> makeChain(Expanded& from, std::vector<Fault>& faults) {
  setDefaultStops(from.links, from.withStopDamping, from.joints);
  try {
    return Chain(from.links, from.joints, from.gravity);
  } catch (const Refused& refused) {
    const std::string links = "links/";
    std::set<std::pair<std::string, std::string>> reported;
    for (Fault fault : refused.faults()) {
      if (from.isFloating && fault.path == links + from.links[1].name + "/mass") {  // no key of a free chain
        fault = {links + from.links[1].name + "/inertia",
                 "a number > 0 kg m² (else a motion of the free chain moves no mass)", "0"};
      }
      const std::size_t end = std::min(fault.path.find('/', links.size()), fault.path.size());
      const std::string name = fault.path.substr(links.size(), end - links.size());
      fault.path.replace(links.size(), name.size(), from.entryOf.at(name));
      if (reported.emplace(fault.path, fault.expected).second) faults.push_back(std::move(fault));
    }
    return std::nullopt;
  }
}

/// Records a fault if the initial energy overflows, which finite values do not exclude.
void requireFiniteEnergy(const Chain& chain, const Expanded& from, std::vector<Fault>& faults) {
  std::vector<double> theta(from.q.size()), omega(from.qd.size());
  chain.coordinates().toAbsolute(from.q.data(), theta.data());
  chain.coordinates().toAbsolute(from.qd.data(), omega.data());
  const double energy = energyOf(chain, theta.data(), omega.data()).total();
  if (!std::isfinite(energy)) {
    faults.push_back({"links", "a chain and initial rates of finite energy", toText(energy) + " J"});
  }
}

std::vector<const char*> sceneKeys() {
  std::vector<const char*> keys{"chain", "gravity", "links"};
  for (const EffectKind* kind : effectKinds()) {
    if (kind->sceneKey()) keys.push_back(kind->sceneKey());
  }
  for (const char* key : {"base", "tip", "start", "integrator", "publish", "sensors", "seed", "frames",
                          "command_timeout", "real_time_factor", "robot_description"}) {
    keys.push_back(key);
  }
  return keys;
}

std::optional<BaseLaws> takeBase(const Section& top, const ChainNames* names) {
  if (!top.has("base")) return std::nullopt;
  if (top.find("base")->map() && top.find("base")->map()->empty()) {
    top.fault("base", "x, y or angle (ROS drops an empty map)");
  }
  if (names && names->links.count(movingFrame) != 0) {
    top.fault("base",
              std::string("no base that moves beside a link ") + movingFrame + ", as its frame has that name",
              "both");
  }
  return readBase(top.section("base", {"x", "y", "angle"}));
}

std::optional<double> takeRealTimeFactor(const Section& top) {
  if (!top.has("real_time_factor")) return std::nullopt;
  double factor = 0;
  const char* range = " >= 0 and <= 1000 (simulated time per wall time; 0: as fast as possible)";
  top.take("real_time_factor", {range, 0, 1000, true}, factor);
  return factor;
}

void refuseLoadsInDrives(const Section& top, const Expanded& chain, const std::vector<Load>& loads) {
  for (const Drive& drive : chain.drives) {
    for (const Load& load : loads) {
      if (load.joint != drive.joint) continue;
      top.fault("loads/" + load.name + "/joint", "a joint that is not driven",
                quoted(chain.joints[index(load.joint)].name));
    }
  }
}

}  // namespace

// ---- The scene -------------------------------------------------------------------------------

/// @throws Refused with all faults in the order of their lines, if there are any; those of a URDF, which may
/// be a file of its own, come first
static void throwAny(std::vector<Fault>& faults, const Value& value) {
  for (Fault& fault : faults) {
    if (fault.line == 0) fault.line = lineAt(value, fault.path);
  }
  const auto order = [](const Fault& fault) {
    return std::pair(fault.path.rfind("robot_description", 0) != 0, fault.line);
  };
  std::stable_sort(faults.begin(), faults.end(),
                   [&](const Fault& a, const Fault& b) { return order(a) < order(b); });
  if (!faults.empty()) throw Refused(std::move(faults));
}

Scene readSceneAndNote(const Value& value, std::set<std::string>* numbers) {
  std::vector<Fault> faults;
  const Section top(&value, "", sceneKeys(), faults, numbers, hintsAtTop);

  // The chain.
  std::optional<Expanded> expanded = top.has("robot_description") ? readRobot(top, faults) : readLinks(top);
  const ChainNames* names = expanded ? &expanded->names : nullptr;
  std::optional<Chain> chain;
  Vec2d unused;
  top.take("gravity", "m/s²", expanded ? expanded->gravity : unused);
  std::vector<Load> loads;
  std::vector<Link> none;
  for (const EffectKind* kind : effectKinds())
    kind->takeScene(top, names, expanded ? expanded->links : none, loads);
  if (expanded && expanded->isOrdered) chain = makeChain(*expanded, faults);
  // All other keys.
  const IntegratorSettings integrator = readIntegrator(top.section(
      "integrator", {"method", "tolerance", "rate_tolerance", "loosest_tolerance", "step", "plain_kernel"}));
  PublishSettings publish = readPublish(top, names);
  std::vector<Sensor> sensors = readSensors(top, publish, names);
  const long long seed = readSeed(top);
  std::vector<Frame> frames = readFrames(top, sensors, publish, names);
  const bool startsAtRest = readStart(top);
  std::optional<BaseLaws> base = takeBase(top, names);
  if (chain && chain->coordinates().leading() > 0) refuseBesideTypes(top, *chain, loads);
  std::optional<TipLaws> tip = chain ? takeTip(top, *chain, expanded->drives) : takeTip(top);
  double commandTimeout = 0;
  top.take("command_timeout", NumberRule::from(0, "s"), commandTimeout);
  const std::optional<double> realTimeFactor = takeRealTimeFactor(top);
  if (expanded) refuseLoadsInDrives(top, *expanded, loads);
  throwAny(faults, value);
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
              std::move(base),
              std::move(expanded->appearance),
              std::move(expanded->notes),
              std::move(sensors),
              seed,
              std::move(tip),
              std::move(frames)};
  requireSeries(scene, top);
  if (closeStart(scene, top) && startsAtRest) startAtRest(scene, top);
  throwAny(faults, value);
  boundRates(scene);
  addNotes(scene, startsAtRest);
  return scene;
}

Scene readScene(const Value& value) {
  return readSceneAndNote(value, nullptr);
}

Value parseScene(const std::string& text) {
  const std::size_t first = text.find_first_not_of("\xEF\xBB\xBF \t\r\n");  // a byte order mark, blanks
  if (text.compare(0, 7, "#ROSBAG") == 0) {
    const char* bag = "a bag (plot draws it, simulate --commands takes its commands)";
    throw Refused({{"scene", "YAML or a URDF", bag, 1}});
  }
  const bool isXml = first != std::string::npos && text[first] == '<' && text.compare(first, 2, "<<") != 0;
  return isXml ? Value::Map{{"robot_description", text}} : parseYaml(text);
}

Scene readSceneText(const std::string& text) {
  return readScene(parseScene(text));
}

}  // namespace planar_chain
