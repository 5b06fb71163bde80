#pragma once

/// Machines in which everything happens at once, and random calls that change their motion.

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "support/random_scene.h"

namespace planar_chain::test {

/// A moving base, a cart with all that a joint may have, a driven joint, motors, sensors.
inline const std::string robot = R"(
chain: [cart, a, b, c]
base: {x: {amplitude: 0.1, frequency: 0.7}, angle: {offset: 0.1}}
links:
  cart: {mass: 1, pin: [0, 0.1], initial: {position: 0.1}, joint: {type: prismatic, axis: [1, 0.2], damping: 0.3,
    friction: 0.5, lower: -0.2, upper: 0.2, stop_stiffness: 2.0e+4, stop_damping: 20, effort_limit: 30,
    motor: {time_constant: 0.05, no_load_speed: 5}, command_delay: 0.013}}
  a: {mass: 0.5, inertia: 0.02, com: [0.25, 0], pin: [0.5, 0], initial: {angle: -1.2},
    joint: {damping: 0.05, rotor_inertia: 0.01, effort_limit: 5, motor: {time_constant: 0.02}}}
  b: {mass: 0.4, inertia: 0.01, com: [0.2, 0.05], pin: [0.4, 0], joint: {drive: {amplitude: 0.3, frequency: 0.5}}}
  c: {mass: 0.3, inertia: 0.006, com: [0.2, 0], pin: [0.4, 0], joint: {friction: 0.05, breakaway: 0.08, drag: 0.01,
    lower: -2.5, upper: 2.5, stop_stiffness: 500, stop_damping: 0.5}}
loads: {w: {joint: a_joint, torque: 0.5, frequency: 1.3}}
sensors:
  imu: {link: c, rate: 90}
  angles: {joints: [a_joint, c_joint], rate: 70}
)";
/// A driven joint between a cart and a link; a rope that goes slack.
inline const std::string driven = R"(
chain: [cart, a, b, c]
links:
  cart: {mass: 1, pin: [0, 0.1], joint: {type: prismatic, axis: [1, 0.2], lower: -0.8}}
  a: {mass: 0.5, inertia: 0.02, com: [0.25, 0], pin: [0.5, 0]}
  b: {mass: 0.4, inertia: 0.01, com: [0.2, 0.05], pin: [0.4, 0], joint: {drive: {amplitude: 0.3, frequency: 0.5}}}
  c: {mass: 0.3, inertia: 0.006, com: [0.2, 0], pin: [0.4, 0]}
springs: {rope: {link: c, point: [0.4, 0], ground: [0.5, 0.8], stiffness: 80, damping: 0.5, rest_length: 0.9, slack: true}}
)";
/// A tip at a moving place, friction.
inline const std::string loop = R"(
chain: [crank, coupler, rocker, last]
tip: {pin: {x: {offset: 1.1, amplitude: 0.1, frequency: 0.9}, y: {offset: 0.1}}}
links:
  crank: {mass: 2, inertia: 0.05, com: [0, 0], pin: [0.3, 0], initial: {angle: 1, velocity: 9},
    joint: {effort_limit: 20, motor: {time_constant: 0.03}}}
  coupler: {mass: 0.5, inertia: 0.0417, com: [0.5, 0], pin: [1, 0], initial: {angle: -0.5}, joint: {friction: 0.1}}
  rocker: {mass: 0.4, inertia: 0.0213, com: [0.4, 0], pin: [0.8, 0], initial: {angle: -1.6}, joint: {damping: 0.01}}
  last: {mass: 0.2, inertia: 0.01, com: [0.1, 0], pin: [0.2, 0], joint: {stiffness: 3, drag: 0.02}}
)";
/// Nothing couples the joints.
inline const std::string sprung = R"(
chain: [a, b, c]
links:
  a: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {stiffness: 20, damping: 1}}
  b: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {lower: -0.3, stop_stiffness: 5.0e+3, stop_damping: 3}}
  c: {mass: 0.1, inertia: 0.001, com: [0.1, 0], pin: [0.2, 0], joint: {drag: 0.05, effort_limit: 2}}
loads: {push: {link: c, force: [1, 2], times: [0, 0.1, 0.3], values: [0, 1, 0]}}
sensors: {imu: {link: b, rate: 60}}
)";
/// Bodies that stick together; states in the order of lanes.
inline std::string rope(const std::string& joint) {
  return "chain: [rope]\nlinks: {rope: {mass: 0.1, inertia: 1.0e-4, com: [0.05, 0], pin: [0.1, 0], repeat: "
         "24, "
         "joint: {" +
         joint + "}}}\nloads: {push: {link: rope_24, force: [0.5, 0.2], frequency: 2}}\n";
}

struct Machine {
  const char* name;
  std::string scene;
  std::vector<const char*> methods;
};

inline const Machine machines[] = {
    {"robot", robot, {"auto", "dop853", "rodas5p", "radau13", "ros34pw2", "rk4"}},
    {"driven", driven, {"auto", "dopri5", "rodas5p", "radau13"}},
    {"loop", loop, {"auto", "dop853", "rodas5p", "radau13", "ros34pw2"}},
    {"sprung", sprung, {"auto", "dop853", "rodas5p", "radau13", "taylor", "rk4"}},
    {"sticky rope", rope("friction: 0.01"), {"auto", "rodas5p"}},
    {"damped rope", rope("damping: 0.01"), {"auto", "rodas5p", "taylor"}},
};

/// Calls f(scene, seed) for each machine, method and seed, with a trace.
template <class F>
void forEachMachine(unsigned seeds, const F& f) {
  for (const Machine& machine : machines) {
    Scene scene = readSceneText(machine.scene);
    scene.integrator.step = 1e-3;
    for (const char* method : machine.methods) {
      scene.integrator.method = method;
      for (unsigned seed = 0; seed < seeds; ++seed) {
        SCOPED_TRACE(std::string(machine.name) + ", " + method + ", seed " + std::to_string(seed));
        f(scene, seed);
      }
    }
  }
}

// ---- Calls that change the motion ------------------------------------------------------------------

using Call = std::function<void(Simulation&)>;

inline Call anyCall(const Scene& scene, Random& random) {
  const int joint = random.index(scene.chain.size());
  const double size = random.between(-20, 20), time = random.between(0.001, 0.06);
  switch (random.index(16)) {
    case 0:
      return [](Simulation& of) { of.setState(of.q(), of.qd()); };
    case 1:
      return [size](Simulation& of) {
        std::vector<double> rates = of.qd();
        for (double& rate : rates) rate *= 1 + size / 100;
        of.setState(of.q(), of.scene().drives.empty() ? rates : of.qd());
      };
    case 2:
      return [](Simulation& of) { of.settle(); };
    case 3:
      return [](Simulation& of) { of.reset(); };
    case 4:
      return [](Simulation& of) { of.clearCommands(); };
    case 5:
    case 10:
    case 11:
    case 12:
      return [=](Simulation& of) { of.holdTorque(joint, size, of.time() + 3 * time); };
    case 6:
      return [=](Simulation& of) { of.addTorque(joint, size, time, of.time() + time / 2); };
    case 7:
      return [=](Simulation& of) { of.holdForce(joint, {}, {size, 1}, 0, of.time() + time); };
    case 8:
      return [=](Simulation& of) { of.setTolerance(size > 0 ? 1e-6 : 1e-8); };
    case 9:
      return [=](Simulation& of) {
        if (of.scene().drives.empty()) return of.advanceTo(of.time() + time), void();
        const Drive& drive = of.scene().drives[0];
        of.follow(drive.joint, drive.law.to(of.time(), of.time() + 3 * time, size / 20, 0));
      };
    default:
      return [=](Simulation& of) { of.advanceTo(of.time() + time); };
  }
}

/// Returns why it refused, if it did.
inline std::string refusal(const Call& call, Simulation& of) {
  try {
    call(of);
  } catch (const std::exception& refused) {
    return refused.what();
  }
  return {};
}

inline bool areSame(const std::vector<double>& a, const std::vector<double>& b) {
  return std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

}  // namespace planar_chain::test
