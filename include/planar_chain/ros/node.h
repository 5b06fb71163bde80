#pragma once

/// The node: a simulation kept in step with wall time, its publishers and its commands.

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/steady_timer.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "planar_chain/ros/command_log.h"
#include "planar_chain/ros/commands.h"
#include "planar_chain/ros/frames.h"
#include "planar_chain/ros/messages.h"
#include "planar_chain/ros/pace.h"
#include "planar_chain/simulation.h"

namespace planar_chain {

/// Runs on wall time. Tick k brings the simulation to time k/rate, exactly, and is stamped
/// start + k/rate, where start is the wall time of tick 0. So stamps are evenly spaced whatever the
/// machine does; when it cannot keep up, they fall behind the wall clock, and the status says so.
/// A message is made when somebody listens to it, and only then.
class Node {
 public:
  /// Sets robot_description, advertises, subscribes, and starts to run as soon as callbacks are served.
  /// @throws Refused what is wrong with the scene's frames, and use_sim_time.
  explicit Node(const Scene& scene);

 private:
  void serveTicks(const ros::SteadyTimerEvent& event);
  void tick(long long k);
  void publishState(long long k, ros::Time stamp);
  void publishStatus(ros::Time stamp);
  void sayWhatRuns() const;
  void sayWhatIsPublished() const;

  ros::Time stampOf(long long k) const;
  double elapsed() const;  ///< wall time since the start, s

  ros::NodeHandle outer_;       ///< the node's namespace
  ros::NodeHandle inner_{"~"};  ///< below the node's name
  PublishSettings settings_;
  Frames frames_;
  Simulation simulation_;
  CommandLog log_;
  Commands commands_;
  Messages messages_;
  SimStatus status_;

  ros::Publisher jointStatesOut_, linkStatesOut_, tfOut_, statusOut_;
  std::optional<tf2_ros::StaticTransformBroadcaster> staticTf_;

  Pace pace_;
  RealTimeFactor factor_;
  long long next_ = 0;  ///< the first tick that has not happened yet
  std::uint64_t overruns_ = 0;
  bool faultSaid_ = false;
  ros::Time start_;
  std::chrono::steady_clock::time_point steadyStart_;
  ros::SteadyTimer timer_;  ///< last: nothing ticks before all else stands
};

}  // namespace planar_chain
