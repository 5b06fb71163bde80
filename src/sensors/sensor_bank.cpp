#include "sensors/sensor_bank.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "lanes/kernel.h"

namespace planar_chain {

namespace {

constexpr std::size_t axes = 3;
constexpr double nanosecond = 1e-9;

// The use of a random number.
constexpr std::uint32_t forNoise = 0, forWalk = 1;

/// Angular velocity and specific force. e: exp(i θ) of the link and of the IMU.
std::array<double, 2 * axes> motionAt(const Imu& imu, const LinkMotion& link, Vec2d com,
                                      const Rotation<double>* e, Vec2d gravity) {
  const Vec2d arm = e[0] * (imu.point - com);
  const Vec2d a = link.acceleration + link.alpha * perp(arm) - (link.omega * link.omega) * arm;
  const Vec2d specific = Rotation<double>{e[1].c, -e[1].s} * (a - gravity);
  return {0, 0, link.omega, specific.x, specific.y, 0};
}

}  // namespace

SensorBank::SensorBank(const Scene& scene)
    : chain_(scene.chain), rotations_(simd::kernels({scene.integrator.plainKernel}).front()->rotations) {
  for (const Sensor& sensor : scene.sensors) {
    const auto* encoder = std::get_if<Encoder>(&sensor.kind);
    units_.push_back({&sensor, keyOf(scene.seed, sensor.name), encoder ? encoder->joints.size() : 2 * axes});
    if (!encoder) units_.back().wander.assign(2 * axes, 0.0);
  }
}

void SensorBank::Unit::dropOldest() {
  const auto first = values.begin();
  values.erase(first, first + static_cast<std::ptrdiff_t>(width));
  ++oldest;
}

double SensorBank::next() const {
  double t = std::numeric_limits<double>::infinity();
  for (const Unit& unit : units_) t = std::min(t, unit.timeOf(unit.next));
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
    return unit.timeOf(unit.next) == t && std::holds_alternative<Imu>(unit.sensor->kind);
  });
}

void SensorBank::take(const std::vector<double>& q, const LinkMotion* motions) {
  const double t = next();
  for (Unit& unit : units_) {
    if (unit.timeOf(unit.next) != t) continue;
    ++unit.next;
    if (const auto* encoder = std::get_if<Encoder>(&unit.sensor->kind)) {
      for (const int joint : encoder->joints) unit.values.push_back(q[index(joint)]);
    } else {
      const Imu& imu = std::get<Imu>(unit.sensor->kind);
      const LinkMotion& link = motions[imu.link];
      const double angles[] = {link.angle, link.angle + imu.angle};
      Rotation<double> e[2];
      rotations_(angles, &e[0].c, 2);
      const Vec2d com = chain_.links()[index(imu.link)].com;
      for (const double value : motionAt(imu, link, com, e, chain_.gravity())) unit.values.push_back(value);
    }
  }
}

void SensorBank::dropAfter(double t) {
  for (Unit& unit : units_) {
    while (unit.next > unit.made && unit.timeOf(unit.next - 1) > t) --unit.next;
    unit.values.resize(unit.offsetOf(unit.next));
  }
}

void SensorBank::confirm() {
  for (Unit& unit : units_) {
    const double most =
        std::max(mostValues / static_cast<double>(unit.width), 1.0) + unit.sensor->delay * unit.sensor->rate;
    for (; unit.made < unit.next; ++unit.made) {
      addErrors(unit);
      if (static_cast<double>(unit.made + 1 - unit.oldest) <= most) continue;
      unit.dropOldest();
      ++lost_;
    }
  }
}

void SensorBank::addErrors(Unit& unit) {
  auto value = unit.values.begin() + static_cast<std::ptrdiff_t>(unit.offsetOf(unit.made));
  const auto random = [&](std::size_t component, std::uint32_t use) {
    return normal(unit.key, unit.made, static_cast<std::uint32_t>(component), use);
  };
  if (const auto* encoder = std::get_if<Encoder>(&unit.sensor->kind)) {
    for (std::size_t i = 0; i < unit.width; ++i, ++value) {
      *value += encoder->bias;
      if (encoder->noise > 0) *value += encoder->noise * random(i, forNoise);
      if (encoder->resolution > 0) *value = std::round(*value / encoder->resolution) * encoder->resolution;
    }
    return;
  }
  const Imu& imu = std::get<Imu>(unit.sensor->kind);
  for (std::size_t i = 0; i < unit.width; ++i, ++value) {
    const AxesErrors& errors = i < axes ? imu.gyro : imu.specific;
    double& wander = unit.wander[i];
    if (errors.walk > 0 && unit.made > 0) {
      wander += errors.walk * std::sqrt(1 / unit.sensor->rate) * random(i, forWalk);
    }
    *value += errors.bias + wander;
    if (errors.noise > 0) *value += errors.noise * random(i, forNoise);
  }
}

std::vector<Measurement> SensorBank::deliver(double t) {
  std::vector<Measurement> delivered;
  for (std::size_t i = 0; i < units_.size(); ++i) {
    Unit& unit = units_[i];
    for (; unit.oldest < unit.made; unit.dropOldest()) {
      const double time = unit.timeOf(unit.oldest), at = time + unit.sensor->delay;
      if (at > t + nanosecond) break;
      const auto first = unit.values.begin();
      delivered.push_back({static_cast<int>(i),
                           unit.oldest,
                           time,
                           at,
                           {first, first + static_cast<std::ptrdiff_t>(unit.width)}});
    }
  }
  std::stable_sort(delivered.begin(), delivered.end(),
                   [](const Measurement& a, const Measurement& b) { return a.delivered < b.delivered; });
  return delivered;
}

}  // namespace planar_chain
