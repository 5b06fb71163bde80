#include "sensors/sensor_bank.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "lanes/kernel.h"

namespace planar_chain {

namespace {

constexpr std::size_t axes = 3;
constexpr double nanosecond = 1e-9;

// The use of a random number.
constexpr std::uint32_t forNoise = 0, forWalk = 1;

std::vector<double> positions(const Encoder& encoder, const std::vector<double>& q) {
  std::vector<double> values;
  for (const int joint : encoder.joints) values.push_back(q[index(joint)]);
  return values;
}

/// Angular velocity and specific force. e: exp(i θ) of the link and of the IMU.
std::vector<double> motionAt(const Imu& imu, const LinkMotion& link, Vec2d com, const Rotation<double>* e,
                             Vec2d gravity) {
  const Vec2d arm = e[0] * (imu.point - com);
  const Vec2d a = link.acceleration + link.alpha * perp(arm) - (link.omega * link.omega) * arm;
  const Vec2d specific = Rotation<double>{e[1].c, -e[1].s} * (a - gravity);
  return {0, 0, link.omega, specific.x, specific.y, 0};
}

}  // namespace

SensorBank::SensorBank(const Scene& scene)
    : chain_(scene.chain), rotations_(simd::kernels().front()->rotations) {
  for (const Sensor& sensor : scene.sensors) {
    Unit unit{&sensor, keyOf(scene.seed, sensor.name)};
    if (std::holds_alternative<Imu>(sensor.kind)) unit.wander.assign(2 * axes, 0.0);
    units_.push_back(std::move(unit));
  }
}

double SensorBank::next() const {
  double t = std::numeric_limits<double>::infinity();
  for (const Unit& unit : units_) t = std::min(t, unit.nextTime());
  return t;
}

double SensorBank::timeOf(double measurements) const {
  double t = std::numeric_limits<double>::infinity();
  for (const Unit& unit : units_) t = std::min(t, measurements / unit.sensor->rate);
  return t;
}

bool SensorBank::nextNeedsMotions() const {
  const double t = next();
  return std::any_of(units_.begin(), units_.end(), [t](const Unit& unit) {
    return unit.nextTime() == t && std::holds_alternative<Imu>(unit.sensor->kind);
  });
}

void SensorBank::take(const std::vector<double>& q, const LinkMotion* motions) {
  const double t = next();
  for (std::size_t i = 0; i < units_.size(); ++i) {
    Unit& unit = units_[i];
    if (unit.nextTime() != t) continue;
    Measurement measurement{static_cast<int>(i), unit.next++, t, t + unit.sensor->delay};
    if (const auto* encoder = std::get_if<Encoder>(&unit.sensor->kind)) {
      measurement.values = positions(*encoder, q);
    } else {
      const Imu& imu = std::get<Imu>(unit.sensor->kind);
      const LinkMotion& link = motions[imu.link];
      const double angles[] = {link.angle, link.angle + imu.angle};
      Rotation<double> e[2];
      rotations_(angles, &e[0].c, 2);
      measurement.values = motionAt(imu, link, chain_.links()[index(imu.link)].com, e, chain_.gravity());
    }
    unit.taken.push_back(std::move(measurement));
  }
}

void SensorBank::dropAfter(double t) {
  for (Unit& unit : units_) {
    while (!unit.taken.empty() && unit.taken.back().time > t) {
      unit.next = unit.taken.back().number;
      unit.taken.pop_back();
    }
  }
}

void SensorBank::confirm() {
  for (Unit& unit : units_) {
    for (; !unit.taken.empty(); unit.taken.pop_front()) {
      addErrors(unit, unit.taken.front());
      unit.made.push_back(std::move(unit.taken.front()));
    }
  }
}

void SensorBank::addErrors(Unit& unit, Measurement& to) {
  const auto random = [&](std::size_t component, std::uint32_t use) {
    return normal(unit.key, to.number, static_cast<std::uint32_t>(component), use);
  };
  if (const auto* encoder = std::get_if<Encoder>(&unit.sensor->kind)) {
    for (std::size_t i = 0; i < to.values.size(); ++i) {
      double& value = to.values[i];
      value += encoder->bias;
      if (encoder->noise > 0) value += encoder->noise * random(i, forNoise);
      if (encoder->resolution > 0) value = std::round(value / encoder->resolution) * encoder->resolution;
    }
    return;
  }
  const Imu& imu = std::get<Imu>(unit.sensor->kind);
  for (std::size_t i = 0; i < to.values.size(); ++i) {
    const AxesErrors& errors = i < axes ? imu.gyro : imu.specific;
    double& wander = unit.wander[i];
    if (errors.walk > 0 && to.number > 0) {
      wander += errors.walk * std::sqrt(1 / unit.sensor->rate) * random(i, forWalk);
    }
    to.values[i] += errors.bias + wander;
    if (errors.noise > 0) to.values[i] += errors.noise * random(i, forNoise);
  }
}

std::vector<Measurement> SensorBank::deliver(double t) {
  std::vector<Measurement> delivered;
  for (Unit& unit : units_) {
    for (; !unit.made.empty() && unit.made.front().delivered <= t + nanosecond; unit.made.pop_front()) {
      delivered.push_back(std::move(unit.made.front()));
    }
  }
  std::stable_sort(delivered.begin(), delivered.end(),
                   [](const Measurement& a, const Measurement& b) { return a.delivered < b.delivered; });
  return delivered;
}

}  // namespace planar_chain
