#pragma once

/// Sensors on a chain: encoders in joints and IMUs on links.
///
/// A sensor takes measurement k = 0, 1, 2, … at t = k/rate exactly and delivers it `delay` later. The motion
/// does not depend on it. With bias b, noise n and a bias w that wanders:
///
///     encoder         resolution · round((q + b + n)/resolution)
///     gyroscope       (0, 0, θ̇) + b + w + n
///     accelerometer   R⊤ (a_P − g) + b + w + n,   at rest +g, upwards
///     w_0 = 0         w_k = w_{k−1} + walk · √(1/rate) · n'
///
/// R has the axes of the IMU, a_P is the acceleration of its point. x and y are in the plane of motion, z is
/// along the joint axes. Where the acceleration jumps, the value before the jump is measured.
///
/// n and n' are normal numbers, independent for every k, joint and axis. Each depends only on the seed, the
/// sensor's name, k and its component (src/sensors/random.h), and is the same on every machine.

#include <string>
#include <variant>
#include <vector>

#include "planar_chain/planar.h"

namespace planar_chain {

/// Measures positions of joints. rad; of prismatic joints m.
struct Encoder {
  std::vector<int> joints;  ///< indices
  double resolution = 0;    ///< 0: none
  double noise = 0;         ///< standard deviation
  double bias = 0;
};

/// Errors of three axes, each with its own random numbers.
struct AxesErrors {
  double noise = 0;  ///< standard deviation of a measurement
  double bias = 0;   ///< in each axis
  double walk = 0;   ///< the bias wanders by this standard deviation in a second
};

/// Measures angular velocity (rad/s) and specific force (m/s²) of a link.
struct Imu {
  int link = 0;         ///< index
  Vec2d point;          ///< m, link frame
  double angle = 0;     ///< of its x axis, from that of the link, rad
  AxesErrors gyro;      ///< rad/s
  AxesErrors specific;  ///< of the accelerometer, m/s²
};

struct Sensor {
  std::string name;
  double rate = 100;  ///< Hz
  double delay = 0;   ///< s
  std::variant<Encoder, Imu> kind;
};

struct Measurement {
  int sensor = 0;        ///< index in Scene::sensors
  long long number = 0;  ///< k
  double time = 0;       ///< k/rate, when it was taken, s
  double delivered = 0;  ///< time + delay, s
  std::vector<double>
      values{};  ///< positions; or of an IMU the angular velocity x, y, z and the specific force x, y, z
};

}  // namespace planar_chain
