/// States that are saved: what they contain, and to which simulations they belong.

#include <cstdint>
#include <utility>
#include <variant>

#include "run/simulation_parts.h"
#include "simd/snapshot.h"

namespace planar_chain {

namespace {

/// Increase it when a class saves other members.
constexpr int format = 3;
const std::string firstWords = "planar_chain state " + std::to_string(format) + "\n";

/// FNV-1a.
std::uint64_t hashOf(const std::string& bytes) {
  std::uint64_t hash = 0xCBF29CE484222325;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3;
  return hash;
}

// ---- The values of a scene that a motion depends on ----------------------------------------------------

void write(Snapshot& to, Link link) {
  to(link.name, link.mass, link.inertia, link.com, link.pin, link.others);
  for (GroundSpring& spring : link.springs) {
    to(spring.point, spring.ground, spring.stiffness, spring.damping, spring.restLength, spring.goesSlack);
  }
}

void write(Snapshot& to, Joint joint) {
  to(joint.name, joint.stiffness, joint.damping, joint.restAngle, joint.lower, joint.upper,
     joint.stopStiffness, joint.stopDamping, joint.others, joint.isPrismatic, joint.axis);
}

void write(Snapshot& to, TimeLaw& law) {
  std::size_t kind = law.index();
  to(kind);
  if (auto* sine = std::get_if<Sine>(&law)) to(sine->frequency, sine->phase);
  if (auto* ramp = std::get_if<Ramp>(&law)) to(ramp->times, ramp->values);
}

void write(Snapshot& to, Load load) {
  to(load.link, load.force, load.point, load.moment, load.joint, load.torque, load.start, load.stop);
  write(to, load.law);
}

void write(Snapshot& to, Sensor sensor) {
  to(sensor.name, sensor.rate, sensor.delay);
  if (auto* encoder = std::get_if<Encoder>(&sensor.kind))
    to(encoder->joints, encoder->resolution, encoder->noise, encoder->bias);
  if (auto* imu = std::get_if<Imu>(&sensor.kind))
    to(imu->link, imu->point, imu->angle, imu->gyro, imu->specific);
}

/// Writes all of them. The drives' and the base's laws are those of the start.
void write(Snapshot& to, Scene scene) {
  Vec2d gravity = scene.chain.gravity();
  to(gravity, scene.q, scene.qd, scene.seed);
  for (const Link& link : scene.chain.links()) write(to, link);
  for (const Joint& joint : scene.chain.joints()) write(to, joint);
  for (const Load& load : scene.loads) write(to, load);
  for (const Sensor& sensor : scene.sensors) write(to, sensor);
  for (Drive& drive : scene.drives) to(drive.joint, drive.law);
  if (scene.base) to(scene.base->x, scene.base->y, scene.base->angle);
  if (scene.tip) to(scene.tip->x, scene.tip->y, scene.tip->line);
  IntegratorSettings& by = scene.integrator;
  to(by.method, by.tolerance, by.step, by.plainKernel, by.rateTolerance);
}

}  // namespace

// ---- What decides the future -----------------------------------------------------------------------------

void Simulation::Parts::saveOrRestore(Snapshot& snapshot) {
  if (snapshot.isReading()) {
    isTried = false;
    derivatives.reset();
    useTolerance();
  }
  snapshot(dynamics, guard, windings, velocities);
  saveOrRestoreFallbacks(snapshot);
  snapshot(fallback, goodChecks, rescueLength, meanStep, rescues, unchecked, switchedSince);
  snapshot(state, y, q, qd, energyAtStart, actsOtherwise, fault);
  snapshot(watchedTo, nearEvents);
  if (sampler) snapshot(*sampler);
}

/// A method keeps what it is made for beside the tolerance in force: `auto` its choice of methods, taylor its
/// order.
void Simulation::Parts::saveOrRestoreFallbacks(Snapshot& snapshot) {
  for (std::size_t k = 0; k < fallbackCount; ++k) {
    double tolerance = fallbacks[k] ? madeFor[k] : 0;
    snapshot(tolerance);
    if (tolerance == 0) {
      fallbacks[k].reset();
      continue;
    }
    if (!fallbacks[k] || madeFor[k] != tolerance) {
      Scene then = scene;
      if (then.integrator.rateTolerance)
        *then.integrator.rateTolerance *= tolerance / then.integrator.tolerance;
      then.integrator.tolerance = tolerance;
      make(k, then);
      fallbacks[k]->setTolerance(toleranceOf(scene, k, dynamics).inLaneOrder(dynamics));
    }
    fallbacks[k]->saveOrRestore(snapshot);
  }
}

void Simulation::saveOrRestore(Snapshot& snapshot) {
  for (Drive& drive : scene_.drives) snapshot(drive.law);
  if (scene_.base) snapshot(scene_.base->x, scene_.base->y, scene_.base->angle);
  snapshot(scene_.integrator.tolerance, scene_.integrator.rateTolerance);
  parts_->saveOrRestore(snapshot);
}

// ---- Simulation
// --------------------------------------------------------------------------------------------

Scene Simulation::sceneOfTheStart() const {
  Scene scene = scene_;
  scene.drives = drives_;
  scene.base = base_;
  scene.integrator = integrator_;
  return scene;
}

/// A hash of all that two simulations must have in common to share states.
const std::string& Simulation::kind() {
  if (!kind_.empty()) return kind_;
  std::string bytes, recursion = this->recursion();
  Snapshot to = Snapshot::writer(bytes);
  write(to, sceneOfTheStart());
  int commands = commandCapacity_;
  bool measures = measures_;
  to(commands, measures, recursion);
  return kind_ = std::to_string(hashOf(bytes));
}

SavedState Simulation::save() {
  parts_->undoTrial();
  std::string content;
  Snapshot to = Snapshot::writer(content);
  int commands = commandCapacity_;
  bool measures = measures_;
  to(commands, measures);
  saveOrRestore(to);
  std::string bytes = firstWords, own = kind();
  std::uint64_t hash = hashOf(content);
  Snapshot::writer(bytes)(own, hash, content);
  return SavedState(std::move(bytes));
}

namespace {

/// A state whose bytes are as they were saved.
struct Opened {
  explicit Opened(const SavedState& saved);

  std::string kind, content;
  int commands = 0;
  bool measures = false;
};

[[noreturn]] void refuse(const char* expected, const char* found) {
  throw Refused({{"saved", expected, found}});
}

Opened::Opened(const SavedState& saved) {
  const std::string& bytes = saved.bytes();
  const bool isOurs = bytes.compare(0, firstWords.size(), firstWords) == 0;
  if (!isOurs)
    refuse("a state that save() of this version made", "one of another version, or something else");
  std::string rest = bytes.substr(firstWords.size());
  std::uint64_t hash = 0;
  try {
    Snapshot::reader(rest)(kind, hash, content);
  } catch (const std::exception&) {
    refuse("a whole state", "a part of one");
  }
  if (hash != hashOf(content)) refuse("a state as it was saved", "one whose bytes have changed");
  Snapshot::reader(content)(commands, measures);
}

}  // namespace

void Simulation::restore(const SavedState& saved) {
  Opened state(saved);
  if (state.kind != kind()) {
    refuse("a state of the same scene, number of commands and kind of CPU",
           "one of another scene, number of commands or kind of CPU");
  }
  Snapshot from = Snapshot::reader(state.content);
  from(state.commands, state.measures);
  saveOrRestore(from);
  ++timesSet_;
}

std::unique_ptr<Simulation> Simulation::in(const SavedState& saved, const Scene& scene) {
  const Opened state(saved);
  auto made = std::make_unique<Simulation>(scene, state.commands, state.measures);
  made->restore(saved);
  return made;
}

std::unique_ptr<Simulation> Simulation::copy() {
  return in(save(), sceneOfTheStart());
}

}  // namespace planar_chain
