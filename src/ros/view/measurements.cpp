#include "ros/view/measurements.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>

namespace planar_chain {

namespace {

sensor_msgs::JointState messageOf(const Encoder& encoder, const Chain& chain) {
  sensor_msgs::JointState message;
  for (const int joint : encoder.joints) message.name.push_back(chain.joints()[index(joint)].name);
  return message;
}

/// Has no estimate of the orientation: the first covariance is -1, as sensor_msgs/Imu requires.
sensor_msgs::Imu messageOf(const Imu& imu, const std::string& frame) {
  sensor_msgs::Imu message;
  message.header.frame_id = frame;
  message.orientation.w = 1;
  message.orientation_covariance[0] = -1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    message.angular_velocity_covariance[4 * axis] = imu.gyro.noise * imu.gyro.noise;
    message.linear_acceleration_covariance[4 * axis] = imu.specific.noise * imu.specific.noise;
  }
  return message;
}

void copy(const double* from, geometry_msgs::Vector3& to) {
  to.x = from[0];
  to.y = from[1];
  to.z = from[2];
}

}  // namespace

Measurements::Measurements(Simulation& simulation, const std::string& node, const Frames& frames)
    : simulation_(simulation) {
  for (const Sensor& sensor : simulation.scene().sensors) {
    longestDelay_ = std::max(longestDelay_, sensor.delay);
    topics_.push_back(node + "/" + sensor.name);
    if (const auto* encoder = std::get_if<Encoder>(&sensor.kind)) {
      messages_.emplace_back(messageOf(*encoder, simulation.scene().chain));
    } else {
      messages_.emplace_back(messageOf(std::get<Imu>(sensor.kind), frames.prefix + sensor.name));
    }
  }
}

void Measurements::follow(const Stamped& tick) {
  constexpr std::int64_t jump = 1000;                                     // ns; less is rounding
  if (!ticks_.empty() && tick.time < ticks_.back().time) ticks_.clear();  // a reset
  const Stamped before = ticks_.empty() ? tick : ticks_.back();
  if (!ticks_.empty()) {
    const auto ns = static_cast<std::int64_t>(stampOf(before.time, tick).toNSec());
    if (std::abs(ns - static_cast<std::int64_t>(before.stamp.toNSec())) <= jump) ticks_.pop_back();
  }
  ticks_.push_back(tick);
  while (ticks_.front().time < before.time - longestDelay_) ticks_.pop_front();
}

ros::Time Measurements::stampOf(double measured, const Stamped& tick) {
  const auto ns = static_cast<std::int64_t>(tick.stamp.toNSec()) - std::llround((tick.time - measured) * 1e9);
  return timeOf(std::max<std::int64_t>(ns, 0));
}

ros::Time Measurements::stampOf(double measured) const {
  auto tick = std::find_if(ticks_.begin(), ticks_.end(),
                           [measured](const Stamped& one) { return one.time >= measured; });
  if (tick == ticks_.end()) --tick;
  const ros::Time stamp = stampOf(measured, *tick);
  return stamp.isZero() && tick != ticks_.begin() ? stampOf(measured, *std::prev(tick)) : stamp;
}

void Measurements::write(const Measurement& measurement, ros::Time stamp, Message& to) {
  if (auto* states = std::get_if<sensor_msgs::JointState>(&to)) {
    states->header.stamp = stamp;
    states->position = measurement.values;
    return;
  }
  auto& imu = std::get<sensor_msgs::Imu>(to);
  imu.header.stamp = stamp;
  copy(measurement.values.data(), imu.angular_velocity);
  copy(measurement.values.data() + 3, imu.linear_acceleration);
}

}  // namespace planar_chain
