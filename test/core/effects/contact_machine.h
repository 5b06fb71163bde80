#pragma once

/// Random machines that hit their stops: rods of about a metre and a kilogram, pinned, on a cart or on two
/// slides, some with a held tip, dry friction, drives, rotors, springs or dampers.

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "support/random_scene.h"

namespace planar_chain::test {

/// 10^x, with x even between the logarithms.
inline double sizeBetween(Random& random, double least, double most) {
  return std::pow(10, random.between(std::log10(least), std::log10(most)));
}

/// Writes the keys of a stop beside a joint that starts at q with v, which it may change.
inline void addStop(std::ostream& out, Random& random, double& q, double& v, bool conserves) {
  // Wide, narrow, far below what a step is, and one spacing of the numbers at q.
  const double widths[] = {random.between(0.1, 0.6), sizeBetween(random, 1e-3, 0.1),
                           sizeBetween(random, 1e-9, 1e-3), 0};
  const double width = widths[random.index(4)];
  const double lower = q - random.between(-0.1, 1.1) * width;  // some begin beyond
  const double upper = std::max(lower + width, std::nextafter(lower, 10));
  if (random.index(3) == 0) q = lower;
  if (width < 0.01) v /= 10;
  out << "lower: " << lower << ", upper: " << upper << ", ";
  const int hardness = random.index(4);  // 0: the default
  if (hardness > 0) out << "stop_stiffness: " << sizeBetween(random, 10, hardness == 1 ? 1e3 : 1e7) << ", ";
  if (!conserves && random.index(2) == 0) out << "stop_damping: " << sizeBetween(random, 0.01, 100) << ", ";
}

/// A scene without its `integrator`. conserves: nothing takes or supplies power.
inline std::string contactMachine(unsigned seed, bool conserves) {
  Random random(seed);
  std::ostringstream out, chain;
  out.precision(17);
  const bool isHeld = random.index(4) == 0, rubs = !conserves && random.index(2) == 0;
  const int slides = std::max(0, random.index(6) - 3), n = slides + (isHeld ? 4 : 1) + random.index(3);
  // A tip is held by two joints that turn or slide freely.
  const int free = random.index(n - 1);
  for (int i = 0; i < n; ++i) {
    chain << (i > 0 ? ", l" : "l") << i;
    const double l = random.between(0.2, 1), m = sizeBetween(random, 0.1, 5);
    double q = random.between(-1, 1), v = random.between(-4, 4);
    out << "  l" << i << ": {mass: " << m;
    if (i < slides) {
      out << ", joint: {type: prismatic, axis: " << (i > 0 ? "[0.2, 1], " : "[1, 0], ");
    } else {
      out << ", inertia: " << m * l * l / 12 << ", com: [" << l / 2 << ", 0], pin: [" << l
          << ", 0], joint: {";
      if (random.index(4) == 0) out << "rotor_inertia: " << sizeBetween(random, 1e-3, 1) << ", ";
    }
    if (!conserves && !isHeld && random.index(8) == 0) {
      out << "drive: {amplitude: " << random.between(0.1, 1) << ", frequency: " << random.between(1, 4)
          << "}}}\n";
      continue;
    }
    if (random.index(3) > 0) addStop(out, random, q, v, conserves);
    if (random.index(4) == 0) out << "stiffness: " << sizeBetween(random, 1, 1e3) << ", ";
    if (!conserves && random.index(4) == 0) out << "damping: " << sizeBetween(random, 0.01, 1) << ", ";
    const bool mayStick = !isHeld || (i != free && i != free + 1);
    if (rubs && mayStick && random.index(isHeld ? 8 : 2) != 1)
      out << "friction: " << sizeBetween(random, 1e-3, 3) << ", ";
    out << "}, initial: {" << (i < slides ? "position: " : "angle: ") << q << ", velocity: " << v << "}}\n";
  }
  std::ostringstream text;
  text << "chain: [" << chain.str() << "]\nlinks:\n" << out.str();
  if (isHeld) {
    const bool isOnLine = random.index(2) == 0;
    text << (isOnLine ? "tip: {line: {direction: [1, 0.3], point: [" : "tip: {pin: [")
         << random.between(0.2, 0.6) << ", " << random.between(-0.4, 0.4) << (isOnLine ? "]}}\n" : "]}\n");
  }
  return text.str();
}

}  // namespace planar_chain::test
