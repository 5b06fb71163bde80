#include "ros/view/measurements.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

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
    : simulation_(simulation), frames_(frames) {
  for (const Sensor& sensor : simulation.scene().sensors) {
    topics_.push_back(node + "/" + sensor.name);
    if (const auto* encoder = std::get_if<Encoder>(&sensor.kind)) {
      messages_.emplace_back(messageOf(*encoder, simulation.scene().chain));
    } else {
      messages_.emplace_back(messageOf(std::get<Imu>(sensor.kind), frames.sensor(sensor.name)));
    }
  }
}

ros::Time Measurements::stampOf(double measured, double now, ros::Time stamp) {
  const auto ns = static_cast<std::int64_t>(stamp.toNSec()) - std::llround((now - measured) * 1e9);
  return timeOf(std::max<std::int64_t>(ns, 0));
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

std::vector<geometry_msgs::TransformStamped> Measurements::transforms(ros::Time stamp) const {
  std::vector<geometry_msgs::TransformStamped> transforms;
  for (const Sensor& sensor : simulation_.scene().sensors) {
    const Imu* imu = std::get_if<Imu>(&sensor.kind);
    if (!imu) continue;
    geometry_msgs::TransformStamped& to = transforms.emplace_back();
    to.header.stamp = stamp;
    to.header.frame_id = frames_.links[index(imu->link)];
    to.child_frame_id = frames_.sensor(sensor.name);
    to.transform.translation.x = imu->point.x;
    to.transform.translation.y = imu->point.y;
    to.transform.rotation.z = std::sin(imu->angle / 2);
    to.transform.rotation.w = std::cos(imu->angle / 2);
  }
  return transforms;
}

}  // namespace planar_chain
