#include "planar_chain/chain.h"

#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "model/require.h"

namespace planar_chain {

namespace {

std::string toText(Vec2d a) {
  return "[" + planar_chain::toText(a.x) + ", " + planar_chain::toText(a.y) + "]";
}

void requireFinite(std::vector<Fault>& faults, const char* path, Vec2d given, const char* unit) {
  if (isFinite(given)) return;
  faults.push_back({path, std::string("two finite numbers [x, y], in ") + unit, toText(given)});
}

/// An offset whose moment of inertia is no number of the machine any more.
void requireMoment(std::vector<Fault>& faults, const char* path, const Link& link, Vec2d offset) {
  const double moment = link.mass * dot(offset, offset) + link.inertia;
  if (std::isfinite(moment)) return;
  faults.push_back({path, "an offset in m whose moment of inertia is finite", toText(offset)});
}

}  // namespace

std::vector<Fault> faultsOf(const Link& link) {
  std::vector<Fault> faults;
  requireNumber(faults, "mass", link.mass, link.mass > 0, " > 0 kg");
  requireNumber(faults, "inertia", link.inertia, link.inertia >= 0, " >= 0 kg m²");
  requireFinite(faults, "com", link.com, "m");
  requireFinite(faults, "pin", link.pin, "m");
  if (!faults.empty()) return faults;
  requireMoment(faults, "com", link, link.com);
  requireMoment(faults, "pin", link, link.pin);
  return faults;
}

// ---- Singular mass matrices ------------------------------------------------------------------

namespace {

/// I = 0 and r = 0, to the machine: about its inner pin the link has no moment of inertia.
bool isPointOnPin(const Link& link) {
  return link.inertia + link.mass * dot(link.com, link.com) == 0;
}

/// Why no mass moves when link j turns in some configuration, if there is one.
std::optional<std::string> motionWithoutMass(const std::vector<Link>& links, std::size_t j) {
  if (!isPointOnPin(links[j])) return std::nullopt;
  const std::string itself = "a point mass on its inner pin";
  if (j + 1 == links.size()) return itself + " at the end of the chain";
  if (links[j].pin == Vec2d{}) return itself + " with the outer pin on it too";

  // Its outer pin does move. A link carried along stands still in its centre of mass only if that is
  // off the pin and, in some configuration, in line; it must turn, so I = 0. Its own outer pin moves
  // on, unless it is in the centre of mass.
  for (std::size_t k = j + 1; k < links.size(); ++k) {
    const Link& link = links[k];
    if (link.inertia > 0 || isPointOnPin(link)) return std::nullopt;
    if (k + 1 == links.size() || link.pin == link.com) {
      return itself + ", which turns freely when the links out to " + link.name +
             ", point masses all, are in line";
    }
  }
  return std::nullopt;
}

void requireRegular(std::vector<Fault>& faults, const std::vector<Link>& links) {
  for (std::size_t j = 0; j < links.size(); ++j) {
    if (const auto why = motionWithoutMass(links, j)) {
      faults.push_back({"links/" + links[j].name,
                        "inertia > 0 kg m² or a centre of mass off the inner pin (or the mass "
                        "matrix is singular)",
                        *why});
    }
  }
}

}  // namespace

// ---- Chain -----------------------------------------------------------------------------------

namespace {

void requireName(std::vector<Fault>& faults, std::set<std::string>& taken, const std::string& path,
                 const std::string& name) {
  if (name.empty()) {
    faults.push_back({path, "a name", "nothing"});
  } else if (!taken.insert(name).second) {
    faults.push_back({path, "a name that no other has", quoted(name)});
  }
}

}  // namespace

Chain::Chain(std::vector<Link> links, std::vector<Joint> joints, Vec2d gravity)
    : links_(std::move(links)), joints_(std::move(joints)), gravity_(gravity) {
  if (links_.empty()) throw Refused({{"chain", "one link at least", "none"}});
  if (joints_.size() != links_.size()) {
    throw Refused(
        {{"chain", std::to_string(links_.size()) + " joints, one a link", std::to_string(joints_.size())}});
  }

  std::vector<Fault> faults;
  requireFinite(faults, "gravity", gravity_, "m/s²");
  std::set<std::string> linkNames;
  std::set<std::string> jointNames;
  bool isSound = true;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const std::string path = "links/" + links_[i].name;
    requireName(faults, linkNames, path, links_[i].name);
    requireName(faults, jointNames, path + "/joint/name", joints_[i].name);
    for (const auto& own : {faultsOf(links_[i]), faultsOf(joints_[i])}) {
      for (const Fault& fault : own) {
        faults.push_back({path + "/" + fault.path, fault.expected, fault.found});
        isSound = false;
      }
    }
  }
  if (isSound) requireRegular(faults, links_);
  if (!faults.empty()) throw Refused(std::move(faults));
}

}  // namespace planar_chain
