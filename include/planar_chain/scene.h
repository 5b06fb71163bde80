#pragma once

/// A scene: everything that a simulation needs, as plain values. Fill it in C++ or read it with
/// scene_reader.h. config/README.md explains every key.

#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "planar_chain/chain.h"
#include "planar_chain/fault.h"
#include "planar_chain/motion_law.h"
#include "planar_chain/sensors.h"

namespace planar_chain {

// The factor of a load as a function of time.
struct Constant {};
/// sin(2π frequency t + phase)
struct Sine {
  double frequency = 0;  ///< Hz
  double phase = 0;      ///< rad
};
/// Straight lines through (times, values). The first value holds before, the last one after.
struct Ramp {
  std::vector<double> times;  ///< s, strictly increasing, at least two
  std::vector<double> values;
};
using TimeLaw = std::variant<Constant, Sine, Ramp>;

/// A load acts on a link (force at a point, moment), in a joint (torque), or both. One time law multiplies
/// all of them. It acts in start ≤ t < stop.
struct Load {
  static constexpr int none = -1;

  std::string name;
  int link = none;    ///< index
  Vec2d force;        ///< N, base frame
  Vec2d point;        ///< m, link frame, from the inner pin
  double moment = 0;  ///< N m, on the link
  int joint = none;   ///< index
  double torque = 0;  ///< N m: + on the joint's link, − on the previous link
  TimeLaw law = Constant{};
  double start = 0;  ///< s
  double stop = std::numeric_limits<double>::infinity();
};

/// The factor of a load at time t (s): its time law inside start ≤ t < stop, 0 outside.
double factorAt(const Load& load, double t);

/// A joint whose angle is a function of time; the torque follows.
struct Drive {
  int joint = 0;  ///< index
  MotionLaw law;  ///< of q, rad
};

struct IntegratorSettings {
  std::string method = "auto";  ///< one of methodNames()
  /// A finer tolerance is a few roundings of the state: they decide every error estimate.
  static constexpr double finest = 1e-15, coarsest = 1;
  double tolerance = 1e-8;                   ///< relative and absolute, for adaptive methods
  double step = 1e-3;                        ///< s, for methods of fixed step
  bool plainKernel = false;                  ///< the same digits on every x86-64 CPU, at the cost of speed
  std::optional<double> rateTolerance{};     ///< of rates; nothing: as errors of the angles that they cause
  std::optional<double> loosestTolerance{};  ///< of the node while it is late
};

/// What the node publishes and `simulate --bag` writes. Other tools only check it.
struct PublishSettings {
  double rate = 200;       ///< Hz of joint_states, link_states and the node's ticks
  double tfRate = 50;      ///< Hz of /tf, at most rate
  double statusRate = 10;  ///< Hz of status, at most rate
  bool tf = true;
  bool linkStates = true;
  std::optional<std::string> framePrefix;  ///< default: the node's namespace, if it has one
  std::optional<int> frameEvery;  ///< frames of every k-th link; default: above 200 links, 50 frames at most
  std::string worldFrame = "world";
  std::string baseFrame = "base_link";
  Vec2d offset;  ///< m: the origin of the base frame in the world, x to the right and y up
};

/// The frame at the ground pin of a base that moves.
inline constexpr const char* movingFrame = "ground_pin";

/// How a URDF draws its robot: elements of URDF, placed in the frames of this scene.
struct Appearance {
  std::string materials;
  std::vector<std::string> visuals;  ///< of the base, then of each link. Empty: not from a URDF, or none
};

/// A frame on a link, by name.
struct Frame {
  std::string name;
  int link = 0;      ///< index
  Vec2d point;       ///< m, link frame
  double angle = 0;  ///< of its x axis, from that of the link, rad
};

struct Scene {
  Chain chain;
  std::vector<double> q;   ///< initial relative angles, rad
  std::vector<double> qd;  ///< initial rates, rad/s
  std::vector<Load> loads;
  IntegratorSettings integrator;
  PublishSettings publish;
  double commandTimeout = 0;  ///< s of simulated time after which a held command ends; 0: never
  /// Simulated time per wall time; 0: as fast as possible. If given, the node publishes /clock. Tools ignore
  /// it.
  std::optional<double> realTimeFactor = std::nullopt;
  std::vector<Drive> drives{};                  ///< at most one per joint
  std::optional<BaseLaws> base = std::nullopt;  ///< the motion of the ground pin; nothing: at rest
  Appearance appearance{};
  std::vector<Note> notes{};  ///< for the user; the simulation does not use them
  std::vector<Sensor> sensors{};
  long long seed = 0;                         ///< of the sensors' noise
  std::optional<TipLaws> tip = std::nullopt;  ///< of a held tip; nothing: it is free
  std::vector<Frame> frames{};
  /// The scene as YAML, for recordings; empty unless a tool or the node sets it.
  std::string text{};
};

}  // namespace planar_chain
