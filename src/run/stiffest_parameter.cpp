#include "run/stiffest_parameter.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "effects/effect_kind.h"
#include "model/prismatic.h"

namespace planar_chain {

namespace {

struct Fastest {
  double rate = 0;  ///< 1/s
  std::string key, of, unit;
  double value = 0;

  void offer(double its, const std::string& itsKey, const std::string& itsOwner, double itsValue,
             const std::string& itsUnit) {
    if (its > rate) *this = {its, itsKey, itsOwner, itsUnit, itsValue};
  }
  void offerTimes(const std::vector<double>& times, const std::string& owner) {
    for (std::size_t i = 1; i < times.size(); ++i) {
      offer(1 / (times[i] - times[i - 1]), "times", owner, times[i] - times[i - 1], "s apart");
    }
  }
  void offerSine(double frequency, const std::string& owner) {
    offer(2 * pi * std::abs(frequency), "frequency", owner, frequency, "Hz");
  }
  void offerLaw(const MotionLaw& law, const std::string& owner) {
    if (law.amplitude() != 0) offerSine(law.frequency(), owner);
    std::vector<double> times;
    for (const MotionLaw::Piece& piece : law.pieces()) times.push_back(piece.start);
    offerTimes(times, owner);
  }
};

/// The inertia of each joint's own link about it; of a link without inertia, that of the next one.
std::vector<double> ownInertias(const Chain& chain) {
  std::vector<double> inertias(chain.joints().size());
  double inertia = 0;
  for (std::size_t i = inertias.size(); i-- > 0;) {
    const Link& link = chain.links()[i];
    const double r = length(link.com);
    const double own = chain.joints()[i].isPrismatic
                           ? link.mass
                           : link.mass * r * r + link.inertia + inertiaIn(chain.joints()[i]);
    inertias[i] = inertia = own > 0 ? own : inertia;
  }
  return inertias;
}

void offerJoints(const Chain& chain, Fastest& fastest) {
  const std::vector<double> inertias = ownInertias(chain);
  for (const EffectKind* kind : effectKinds()) {
    for (const JointKey& key : kind->jointKeys()) {
      for (const std::string unit : {"N m/rad", "N m s/rad", "N m s²/rad²"}) {
        if (key.range.which.find(unit) == std::string::npos) continue;
        for (std::size_t i = 0; i < inertias.size(); ++i) {
          const Joint& joint = chain.joints()[i];
          const double value = key.of(joint), rate = value / inertias[i];
          if (value == 0 || inertias[i] == 0) continue;
          fastest.offer(unit == "N m/rad" ? std::sqrt(rate) : rate, key.name, joint.name, value,
                        joint.isPrismatic ? inUnitsOfPrismatic(unit) : unit);
        }
      }
    }
  }
}

/// Springs to the ground, and air drag.
void offerLinks(const Chain& chain, Fastest& fastest) {
  for (const Link& link : chain.links()) {
    if (link.mass == 0) continue;
    fastest.offer(link.others.of("drag") / link.mass, "drag", link.name, link.others.of("drag"), "N s²/m²");
    for (const GroundSpring& spring : link.springs) {
      fastest.offer(std::sqrt(spring.stiffness / link.mass), "stiffness", spring.name, spring.stiffness,
                    "N/m");
      fastest.offer(spring.damping / link.mass, "damping", spring.name, spring.damping, "N s/m");
    }
  }
}

void offerLaws(const Scene& scene, double t, Fastest& fastest) {
  for (const Load& load : scene.loads) {
    if (t < load.start || t >= load.stop) continue;
    if (const Sine* sine = std::get_if<Sine>(&load.law))
      fastest.offerSine(sine->frequency, "load " + load.name);
    if (const Ramp* ramp = std::get_if<Ramp>(&load.law)) fastest.offerTimes(ramp->times, "load " + load.name);
  }
  for (const Drive& drive : scene.drives) {
    fastest.offerLaw(drive.law, "drive of " + scene.chain.joints()[index(drive.joint)].name);
  }
  if (scene.base) {
    fastest.offerLaw(scene.base->x, "base/x");
    fastest.offerLaw(scene.base->y, "base/y");
    fastest.offerLaw(scene.base->angle, "base/angle");
  }
  if (scene.tip) {
    fastest.offerLaw(scene.tip->x, "tip/pin/x");
    fastest.offerLaw(scene.tip->y, "tip/pin/y");
  }
}

}  // namespace

std::string stiffestParameter(const Scene& scene, double t, double step) {
  constexpr double shortest = 1e-9;  // s: no shorter step makes more of a key
  constexpr double little = 1e-3;    // of its time, within a step
  Fastest fastest;
  offerJoints(scene.chain, fastest);
  offerLinks(scene.chain, fastest);
  offerLaws(scene, t, fastest);
  if (!(fastest.rate * std::max(step, shortest) > little)) return "";
  char value[40];
  std::snprintf(value, sizeof value, " (%.3g ", fastest.value);
  return "the fastest key is " + fastest.key + " of " + fastest.of + value + fastest.unit + "); ";
}

}  // namespace planar_chain
