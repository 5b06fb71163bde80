#include "planar_chain/chain.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "model/number_rule.h"
#include "model/prismatic.h"

namespace planar_chain {

namespace {

std::string toText(Vec2d a) {
  return "[" + planar_chain::toText(a.x) + ", " + planar_chain::toText(a.y) + "]";
}

void requireFinite(std::vector<Fault>& faults, const char* path, Vec2d given, const char* unit) {
  if (isFinite(given)) return;
  faults.push_back({path, std::string("two finite numbers [x, y], in ") + unit, toText(given)});
}

/// kg m². The determinant of two bodies is a product of two: larger ones overflow.
constexpr double largestMoment = 1e150;

/// Records a fault if the product of two moments of inertia such as that for this offset may overflow.
void requireMoment(std::vector<Fault>& faults, const char* path, const Link& link, Vec2d offset) {
  const double moment = link.mass * dot(offset, offset) + link.inertia;
  if (moment <= largestMoment) return;
  faults.push_back({path, "an offset in m whose moment of inertia is at most 1e150 kg m²", toText(offset)});
}

// ---- Singular mass matrices ------------------------------------------------------------------

/// True if the link has no moment of inertia about its inner pin, in machine numbers: I = 0 and r = 0.
bool isPointOnPin(const Link& link) {
  return link.inertia + link.mass * dot(link.com, link.com) == 0;
}

/// The reason why no mass moves when link j turns, if there is a configuration in which this is so.
std::optional<std::string> motionWithoutMass(const std::vector<Link>& links, const std::vector<Joint>& joints,
                                             std::size_t j) {
  if (!isPointOnPin(links[j])) return std::nullopt;
  const std::string itself = "a point mass on its inner pin";
  std::size_t last = j;  // of the links that turn with it
  while (last + 1 < links.size() && joints[last + 1].isPrismatic) {
    if (links[++last].inertia > 0) return std::nullopt;
  }
  if (last > j) return itself + ", and no link that slides on it has inertia > 0";
  if (j + 1 == links.size()) return itself + " at the end of the chain";
  if (links[j].pin == Vec2d{}) return itself + ", which is its outer pin too";

  // The outer pin of link j moves and carries the next link along. That link's centre of mass stands still in
  // some configuration only if it is off the pin. The link turns then, so I must be 0. Its own outer pin
  // moves in turn, unless the pin is the centre of mass.
  for (std::size_t k = j + 1; k < links.size(); ++k) {
    const Link& link = links[k];
    if (joints[k].isPrismatic) return link.inertia > 0 ? std::nullopt : std::make_optional(itself);
    if (link.inertia > 0 || isPointOnPin(link)) return std::nullopt;
    if (k + 1 == links.size() || link.pin == link.com) {
      return itself + ", which turns freely when the point masses out to " + link.name + " are in line";
    }
  }
  return std::nullopt;
}

void requireRegular(std::vector<Fault>& faults, const std::vector<Link>& links,
                    const std::vector<Joint>& joints) {
  for (std::size_t j = 0; j < links.size(); ++j) {
    if (joints[j].isPrismatic) continue;
    if (const auto why = motionWithoutMass(links, joints, j)) {
      faults.push_back({"links/" + links[j].name,
                        "inertia > 0 kg m² or a centre of mass off the inner pin (otherwise the mass "
                        "matrix is singular)",
                        *why});
    }
  }
}

// ---- Chain -----------------------------------------------------------------------------------

void requireName(std::vector<Fault>& faults, std::set<std::string>& taken, const std::string& path,
                 const std::string& name) {
  if (name.empty()) {
    faults.push_back({path, "a name", "nothing"});
  } else if (!taken.insert(name).second) {
    faults.push_back({path, "a unique name", quoted(name)});
  }
}

}  // namespace

Coordinates::Coordinates(const std::vector<Joint>& joints) : size_(static_cast<int>(joints.size())) {
  std::shared_ptr<int[]> numbers(new int[2 * joints.size()]);
  int turner = none;
  for (int i = 0; i < size_; ++i) {
    const bool isPrismatic = joints[index(i)].isPrismatic;
    numbers[i] = isPrismatic ? none : turner;
    if (isPrismatic) {
      anyIsPrismatic_ = true;
      turner == none ? void(++leading_) : void(anyIsInside_ = true);
    } else {
      turner = i;
    }
    numbers[size_ + i] = turner;
  }
  inner_ = numbers.get();
  turner_ = inner_ + size_;
  numbers_ = std::move(numbers);
}

std::vector<Fault> faultsOf(const Link& link, bool isPrismatic) {
  std::vector<Fault> faults;
  (isPrismatic ? NumberRule::from(0, "kg") : NumberRule::above(0, "kg")).check(faults, "mass", link.mass);
  NumberRule::from(0, "kg m²").check(faults, "inertia", link.inertia);
  requireFinite(faults, "com", link.com, "m");
  requireFinite(faults, "pin", link.pin, "m");
  if (!faults.empty()) return faults;
  requireMoment(faults, "com", link, link.com);
  requireMoment(faults, "pin", link, link.pin);
  const double moment = link.mass * dot(link.com, link.com) + link.inertia;
  if (moment > 0 && moment < 1e-150) {  // the product of two may underflow
    faults.push_back({"mass",
                      "a mass in kg whose moment of inertia about the inner pin is at least 1e-150 kg m²",
                      toText(link.mass)});
  }
  return faults;
}

Chain::Chain(std::vector<Link> links, std::vector<Joint> joints, Vec2d gravity) {
  if (links.empty()) throw Refused({{"chain", "at least one link", "none"}});
  if (joints.size() != links.size()) {
    throw Refused(
        {{"chain", std::to_string(links.size()) + " joints, one per link", std::to_string(joints.size())}});
  }

  // Every link and joint alone, and their names.
  std::vector<Fault> faults;
  requireFinite(faults, "gravity", gravity, "m/s²");
  std::set<std::string> linkNames;
  std::set<std::string> jointNames;
  bool isSound = true;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const std::string path = "links/" + links[i].name;
    requireName(faults, linkNames, path, links[i].name);
    requireName(faults, jointNames, path + "/joint/name", joints[i].name);
    for (const auto& own :
         {faultsOf(links[i], joints[i].isPrismatic), faultsOfEffects(links[i]), faultsOf(joints[i])}) {
      for (const Fault& fault : own) {
        faults.push_back({path + "/" + fault.path, fault.expected, fault.found});
        isSound = false;
      }
    }
  }

  // The links together.
  if (isSound) requirePrismatic(links, joints, faults);
  if (isSound && faults.empty()) requireRegular(faults, links, joints);
  if (!faults.empty()) throw Refused(std::move(faults));
  for (Joint& joint : joints) {
    if (joint.isPrismatic) joint.axis = 1 / length(joint.axis) * joint.axis;
  }
  Coordinates coordinates(joints);
  values_ = std::make_shared<const Values>(
      Values{std::move(links), std::move(joints), gravity, std::move(coordinates)});
}

double Chain::reach() const {
  double pins = 0, reach = 0;
  for (std::size_t j = index(coordinates().leading()); j < links().size(); ++j) {
    const Joint& joint = joints()[j];
    if (joint.isPrismatic && std::isfinite(joint.lower) && std::isfinite(joint.upper))
      pins += std::max(std::abs(joint.lower), std::abs(joint.upper));
    reach = std::max({reach, pins + length(links()[j].com), pins + length(links()[j].pin)});
    pins += length(links()[j].pin);
  }
  return reach > 0 ? reach : 1;
}

}  // namespace planar_chain
