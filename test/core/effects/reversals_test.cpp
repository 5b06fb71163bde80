/// Joints that rub under torques that begin and end at instants that coincide, or nearly: random ones by
/// every method, against closed formulas.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <sstream>
#include <string>
#include <vector>

#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

/// A coordinate that rubs, on a spring, under torques that are constant piece by piece:
/// m q̈ = τ(t) − k q − c sign(q̇). At rest it starts when |τ − k q| exceeds its breakaway. Between two instants
/// of rest, ends and starts of torques, the motion is one of sines, or of parabolas if k = 0.
struct Rubbing {
  struct Pulse {
    double torque, start, duration;
  };
  double mass, stiffness, friction, breakaway, position, rate;
  std::vector<Pulse> pulses;

  double torqueAt(double t) const {
    double sum = 0;
    for (const Pulse& pulse : pulses)
      if (pulse.start <= t && t < pulse.start + pulse.duration) sum += pulse.torque;
    return sum;
  }

  void advance(double from, double to) {
    std::vector<double> instants{from, to};
    for (const Pulse& pulse : pulses) {
      for (const double t : {pulse.start, pulse.start + pulse.duration})
        if (from < t && t < to) instants.push_back(t);
    }
    std::sort(instants.begin(), instants.end());
    for (std::size_t k = 0; k + 1 < instants.size(); ++k) {
      advanceUnder(torqueAt(instants[k]), instants[k + 1] - instants[k]);
    }
  }

  void advanceUnder(double torque, double time) {
    const double load = torque - stiffness * position;
    if (rate == 0 && std::abs(load) <= breakaway) return;
    const double force = torque - std::copysign(friction, rate != 0 ? rate : load);
    const double toRest = timeToRest(force);
    if (toRest < time) {
      move(force, toRest);
      rate = 0;
      advanceUnder(torque, time - toRest);
    } else {
      move(force, time);
    }
  }

  double timeToRest(double force) const {
    const double acceleration = (force - stiffness * position) / mass;
    if (stiffness == 0) return rate * acceleration < 0 ? -rate / acceleration : HUGE_VAL;
    // q̇ cos ωt + q̈/ω sin ωt = 0
    const double omega = std::sqrt(stiffness / mass);
    const double phase = rate != 0 ? std::atan2(-omega * rate, acceleration) : M_PI;
    return (phase > 0 ? phase : phase + M_PI) / omega;
  }

  void move(double force, double time) {
    const double acceleration = (force - stiffness * position) / mass;
    if (stiffness == 0) {
      position += time * (rate + time * acceleration / 2);
      rate += time * acceleration;
    } else {
      const double omega = std::sqrt(stiffness / mass), c = std::cos(omega * time),
                   s = std::sin(omega * time);
      position += rate / omega * s + acceleration / (omega * omega) * (1 - c);
      rate = rate * c + acceleration / omega * s;
    }
  }
};

/// An instant that is often one of a few, or beside it by one bit or by little.
double instant(test::Random& random) {
  const double grid = 0.1 * random.index(10);
  switch (random.index(5)) {
    case 0:
      return grid;
    case 1:
      return std::nextafter(grid, 1);
    case 2:
      return grid + std::pow(10, random.between(-12, -3));
    default:
      return random.between(0, 0.9);
  }
}

Rubbing randomRubbing(test::Random& random) {
  Rubbing one{};
  one.mass = random.between(0.1, 2);
  one.stiffness = random.index(2) * std::pow(10, random.between(0, 4));
  one.friction = random.between(0.5, 5);
  one.breakaway = one.friction * (random.index(2) == 0 ? 1 : random.between(1, 1.5));
  one.rate = random.index(2) * random.between(-2, 2);
  for (int k = 0; k < 5; ++k) {
    const double start = instant(random);
    const double duration = random.index(2) == 0 ? 0.1 : std::pow(10, random.between(-6, -0.5));
    one.pulses.push_back({random.between(-20, 20), start, duration});
  }
  return one;
}

/// Comes to rest where its torques end.
Rubbing randomStrokes(test::Random& random) {
  Rubbing one{};
  one.mass = random.between(0.1, 2);
  one.friction = one.breakaway = random.between(0.5, 5);
  for (const double start : {0.1, 0.4, 0.7}) {
    const double torque = one.friction + random.between(1, 20);
    one.pulses.push_back({torque, start, 0.1});
    one.pulses.push_back({2 * one.friction - torque, start + 0.1, 0.1});
  }
  return one;
}

std::string keysOf(const Rubbing& one) {
  std::ostringstream text;
  text.precision(17);
  text << "stiffness: " << one.stiffness << ", friction: " << one.friction << ", breakaway: " << one.breakaway
       << "}, initial: {velocity: " << one.rate << "}";
  return text.str();
}

/// What rubs is joint 0 and, if there is a second, joint 2; joint 1 moves on at 1 m/s.
void expectReversals(Scene scene, const std::vector<Rubbing>& rubbing,
                     std::initializer_list<const char*> methods) {
  scene.integrator.step = 1e-3;
  for (const char* method : methods) {
    for (const double tolerance : {1e-4, 1e-8, 1e-11}) {
      for (const int rows : {1, 10, 97}) {
        SCOPED_TRACE(std::string(method) + " to " + std::to_string(tolerance) + ", " + std::to_string(rows) +
                     " rows");
        scene.integrator.method = method;
        scene.integrator.tolerance = tolerance;
        Simulation simulation(scene, 20);
        for (std::size_t i = 0; i < rubbing.size(); ++i) {
          for (const Rubbing::Pulse& pulse : rubbing[i].pulses)
            ASSERT_TRUE(
                simulation.addTorque(static_cast<int>(2 * i), pulse.torque, pulse.duration, pulse.start));
        }
        const double bound = (std::string(method) == "rk4" ? 1e-6 : 1e-10) + tolerance;  // m, rad
        std::vector<Rubbing> exact = rubbing;
        for (int k = 1; k <= rows; ++k) {
          const double from = simulation.time(), to = 1.0 * k / rows;
          ASSERT_TRUE(simulation.advanceTo(to)) << simulation.fault();
          for (std::size_t i = 0; i < rubbing.size(); ++i) {
            exact[i].advance(from, to);
            ASSERT_NEAR(simulation.q()[2 * i], exact[i].position, bound)
                << "joint " << 2 * i << " at " << to << " s";
          }
          if (rubbing.size() > 1) {
            ASSERT_NEAR(simulation.q()[1], to, bound);
          }
        }
      }
    }
  }
}

TEST(Reversals, OfAWheelAreWhereTheyShouldBe) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    const Rubbing wheel = seed % 4 == 0 ? randomStrokes(random) : randomRubbing(random);
    std::ostringstream text;
    text.precision(17);
    text << "chain: [wheel]\ngravity: [0, 0]\nlinks:\n"
         << "  wheel: {mass: 1, inertia: " << wheel.mass << ", com: [0, 0], pin: [0.5, 0], joint: {"
         << keysOf(wheel) << "}\n";
    expectReversals(readSceneText(text.str()), {wheel},
                    {"auto", "taylor", "dop853", "dopri5", "rodas5p", "radau13", "rk4"});
  }
}

/// On the cart slides a mass without friction, across; on that turns the wheel. None of the three moves
/// another.
TEST(Reversals, OfACartAndAWheelAreWhereTheyShouldBe) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    const Rubbing cart = seed % 4 == 0 ? randomStrokes(random) : randomRubbing(random);
    const Rubbing wheel = randomRubbing(random);
    std::ostringstream text;
    text.precision(17);
    text << "chain: [cart, y, wheel]\ngravity: [0, 0]\nlinks:\n"
         << "  cart: {mass: 0, joint: {type: prismatic, " << keysOf(cart) << "}\n"
         << "  y: {mass: " << cart.mass / 2
         << ", joint: {type: prismatic, axis: [0, 1]}, initial: {velocity: 1}}\n"
         << "  wheel: {mass: " << cart.mass / 2 << ", inertia: " << wheel.mass
         << ", com: [0, 0], pin: [0.5, 0], joint: {" << keysOf(wheel) << "}\n";
    expectReversals(readSceneText(text.str()), {cart, wheel},
                    {"auto", "dop853", "dopri5", "rodas5p", "radau13", "rk4"});
  }
}

}  // namespace
}  // namespace planar_chain
