#pragma once

/// The measurements of a scene's sensors as ROS messages, on topics below the node's name.

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>

#include <deque>
#include <string>
#include <variant>
#include <vector>

#include "planar_chain/simulation.h"
#include "ros/messages/frames.h"
#include "ros/messages/ticks.h"

namespace planar_chain {

/// A message is stamped with the time at which it was measured, from the stamp of the next tick that had not
/// jumped since: after a pause, the last before it. If that is not after 0, a jump back leads to the stamp
/// from the tick before it; without one, the message is not sent.
class Measurements {
 public:
  /// node: the full name of the publishing node. The simulation must outlive this.
  Measurements(Simulation& simulation, const std::string& node, const Frames& frames);

  /// Calls visit(topic, rate, message) for each sensor; the message is an example.
  template <class Visit>
  void forEachTopic(Visit visit) const {
    for (std::size_t i = 0; i < messages_.size(); ++i) {
      const double rate = simulation_.scene().sensors[i].rate;
      std::visit([&](const auto& message) { visit(topics_[i], rate, message); }, messages_[i]);
    }
  }

  /// Calls visit(topic, message) for each measurement that was delivered up to a tick, which has this stamp.
  /// The message is valid during the call, which may set header.seq.
  template <class Visit>
  void forEach(const Ticks& ticks, long long tick, ros::Time stamp, Visit visit) {
    if (messages_.empty()) return;
    follow({ticks.sceneTime(tick), stamp});
    for (const Measurement& measurement : simulation_.measure()) {
      const auto i = index(measurement.sensor);
      const ros::Time measured = stampOf(measurement.time);
      if (measured.isZero()) continue;
      write(measurement, measured, messages_[i]);
      std::visit([&](auto& message) { visit(topics_[i], message); }, messages_[i]);
    }
  }

 private:
  using Message = std::variant<sensor_msgs::JointState, sensor_msgs::Imu>;

  struct Stamped {
    double time;  ///< of the scene, s
    ros::Time stamp;
  };
  /// Takes what a tick is stamped with.
  void follow(const Stamped& tick);
  static ros::Time stampOf(double measured, const Stamped& tick);
  ros::Time stampOf(double measured) const;
  static void write(const Measurement& measurement, ros::Time stamp, Message& to);

  Simulation& simulation_;
  std::vector<std::string> topics_;
  std::vector<Message> messages_;  ///< of each sensor
  double longestDelay_ = 0;        ///< s
  std::deque<Stamped> ticks_;      ///< those before jumps of the stamps, and the last
};

}  // namespace planar_chain
