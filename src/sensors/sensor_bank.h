#pragma once

/// The sensors of a scene: when they measure, with which errors, and what they have delivered.
///
/// Values are taken along the way, and may be dropped if the simulation returns to an earlier state.
/// confirm() adds the errors, in the order of k.

#include <deque>
#include <limits>
#include <vector>

#include "planar_chain/motion.h"
#include "planar_chain/scene.h"
#include "sensors/random.h"

namespace planar_chain {

class SensorBank {
 public:
  /// The scene must outlive this object.
  explicit SensorBank(const Scene& scene);

  /// The time of the next measurement, s. Infinite without sensors.
  double next() const;
  /// The shortest time in which some sensor measures so often, s. Infinite without sensors.
  double timeOf(double measurements) const;
  /// True if the next measurement needs the motions of the links.
  bool nextNeedsMotions() const;
  /// Takes the values of all sensors that measure at next(). q: relative positions. motions: those of the
  /// links, or nullptr if they are not needed.
  void take(const std::vector<double>& q, const LinkMotion* motions);
  /// Drops the values after t that are not confirmed.
  void dropAfter(double t);
  /// Makes measurements of all values.
  void confirm();
  /// Returns the measurements delivered up to t, in the order of delivery, then of the sensors. Each is
  /// returned once. A nanosecond after t counts as t.
  std::vector<Measurement> deliver(double t);

 private:
  struct Unit {
    const Sensor* sensor;
    RandomKey key;
    long long next = 0;                       ///< k of the next measurement
    std::vector<double> wander{};             ///< w
    std::deque<Measurement> taken{}, made{};  ///< without and with errors

    double nextTime() const { return static_cast<double>(next) / sensor->rate; }
  };

  static void addErrors(Unit& unit, Measurement& to);

  const Chain& chain_;
  std::vector<Unit> units_;
  void (*rotations_)(const double* theta, double* e, int n);
};

}  // namespace planar_chain
