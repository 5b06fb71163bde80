#include <algorithm>
#include <utility>

#include "effects/air_drag.h"
#include "effects/commands.h"
#include "effects/drags.h"
#include "effects/drives.h"
#include "effects/effect_kind.h"
#include "effects/friction.h"
#include "effects/ground_springs.h"
#include "effects/loads.h"
#include "effects/motors.h"
#include "effects/springs.h"
#include "effects/stops.h"
#include "model/prismatic.h"
#include "ode/methods.h"

namespace planar_chain {

namespace {

std::vector<const EffectKind*>& listed() {
  static std::vector<const EffectKind*> kinds{
      &springKind(),   &loadKind(),   &stopKind(),  &rotorKind(), &driveKind(),   &baseKind(),
      &tipKind(),      &effortKind(), &motorKind(), &dragKind(),  &airDragKind(), &groundSpringKind(),
      &frictionKind(),  // acts last, when it is known what else acts
  };
  return kinds;
}
std::vector<const EffectKind*> listedAfter(const EffectKind& more) {
  std::vector<const EffectKind*> kinds{&more};
  kinds.insert(kinds.end(), listed().begin(), listed().end());
  return kinds;
}

template <class Of>
double sumOverKinds(Of of) {
  double sum = 0;
  for (const EffectKind* kind : effectKinds()) sum += of(*kind);
  return sum;
}

}  // namespace

const std::vector<const EffectKind*>& effectKinds() {
  return listed();
}

OtherEffectKinds::OtherEffectKinds(std::vector<const EffectKind*> kinds)
    : before_(std::exchange(listed(), std::move(kinds))) {}
OtherEffectKinds::OtherEffectKinds(const EffectKind& more) : OtherEffectKinds(listedAfter(more)) {}
OtherEffectKinds::~OtherEffectKinds() {
  listed() = std::move(before_);
}

double inertiaIn(const Joint& joint) {
  return sumOverKinds([&](const EffectKind& kind) { return kind.inertiaIn(joint); });
}
double dryFrictionIn(const Joint& joint) {
  return sumOverKinds([&](const EffectKind& kind) { return kind.dryFrictionIn(joint); });
}
double stiffnessOf(const Joint& joint) {
  return sumOverKinds([&](const EffectKind& kind) { return kind.stiffnessOf(joint); });
}
double stiffnessOf(const Link& link) {
  return sumOverKinds([&](const EffectKind& kind) { return kind.stiffnessOf(link); });
}
double momentOf(const Joint& joint) {
  return sumOverKinds([&](const EffectKind& kind) { return kind.momentOf(joint); });
}

double toleranceOfRates(const IntegratorSettings& settings) {
  return ode::hasFixedStep(settings.method) ? 0 : settings.rateTolerance.value_or(settings.tolerance);
}

bool hasSymbol(const Joint& joint, Symbol symbol) {
  const auto draws = [&](const EffectKind* kind) { return kind->symbolOf(joint) == symbol; };
  return std::any_of(effectKinds().begin(), effectKinds().end(), draws);
}

bool storesEnergy(const Joint& joint) {
  return stiffnessOf(joint) > 0;
}

double largestAngle(const Joint& joint) {
  constexpr double mostTurns = 9007199254740992;  // 2^53: of more, doubles do not count each one
  constexpr double farthest = 1e6;                // rad or m: the rounding of q is 1e-10 there
  return joint.isPrismatic || storesEnergy(joint) ? farthest : 2 * pi * mostTurns;
}
const char* anglesInWords(const Joint& joint) {
  if (joint.isPrismatic) return "a number from -1e6 to 1e6 m";
  return storesEnergy(joint) ? "a number from -1e6 to 1e6 rad (the joint has a spring or a limit)"
                             : "a number from -5e16 to 5e16 rad (2^53 turns)";
}

void SceneWords::count(int number, const std::string& one) {
  if (number > 0) {
    runs.push_back(std::to_string(number) + " " + one + (number == 1 ? "" : "s"));
  } else {
    leftOut.push_back(one + "s");
  }
}

void SceneWords::countJoints(const Chain& chain, bool (*are)(const Joint&), const std::string& one) {
  const auto number = std::count_if(chain.joints().begin(), chain.joints().end(), are);
  if (number > 0) count(static_cast<int>(number), one);
}

SceneWords wordsOf(const Scene& scene) {
  SceneWords words;
  (scene.chain.gravity() == Vec2d{} ? words.leftOut : words.runs).push_back("gravity");
  for (const EffectKind* kind : effectKinds()) kind->summarize(scene, words);
  return words;
}

const std::vector<JointKey>& EffectKind::jointKeys() const {
  static const std::vector<JointKey> none;
  return none;
}

void EffectKind::judge(const Joint& joint, std::vector<Fault>& faults) const {
  for (const JointKey& key : jointKeys()) {
    if (key.member || joint.has(key.name))
      key.range.check(faults, std::string("joint/") + key.name, key.of(joint));
  }
}

/// Declared by chain.h.
std::vector<Fault> faultsOfEffects(const Link& link) {
  std::vector<Fault> faults;
  for (const EffectKind* kind : effectKinds()) kind->judge(link, faults);
  return faults;
}
std::vector<Fault> faultsOf(const Joint& joint) {
  std::vector<Fault> faults;
  for (const EffectKind* kind : effectKinds()) kind->judge(joint, faults);
  if (!joint.isPrismatic) return faults;
  for (Fault& fault : faults) fault.expected = inUnitsOfPrismatic(fault.expected);
  return faults;
}

}  // namespace planar_chain
