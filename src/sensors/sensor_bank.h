#pragma once

/// The sensors of a scene: when they measure, with which errors, and what they have delivered.
///
/// Values are taken along the way, and may be dropped if the simulation returns to an earlier state.
/// confirm() adds the errors, in the order of k. Each sensor keeps the measurements with its newest
/// mostValues numbers, and those whose delay is not over.

#include <deque>
#include <limits>
#include <vector>

#include "planar_chain/motion.h"
#include "planar_chain/scene.h"
#include "sensors/random.h"
#include "simd/snapshot.h"

namespace planar_chain {

class SensorBank {
 public:
  static constexpr double mostValues = 1e6;

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
  /// How many measurements newer ones have replaced before they were delivered.
  long long lost() const { return lost_; }
  void saveOrRestore(Snapshot& snapshot) {
    for (Unit& unit : units_) snapshot(unit.oldest, unit.made, unit.next, unit.values, unit.wander);
    snapshot(lost_);
  }

 private:
  struct Unit {
    const Sensor* sensor;
    RandomKey key;
    std::size_t width;                         ///< values of a measurement
    long long oldest = 0, made = 0, next = 0;  ///< k: the first that is stored, without errors, not taken
    std::deque<double> values{};               ///< from `oldest` to before `next`
    std::vector<double> wander{};              ///< w

    double timeOf(long long k) const { return static_cast<double>(k) / sensor->rate; }
    std::size_t offsetOf(long long k) const { return static_cast<std::size_t>(k - oldest) * width; }
    void dropOldest();
  };

  /// To the values of measurement unit.made.
  static void addErrors(Unit& unit);

  const Chain& chain_;
  std::vector<Unit> units_;
  long long lost_ = 0;
  void (*rotations_)(const double* theta, double* e, int n);
};

}  // namespace planar_chain
