#pragma once

/// The node: a simulation kept in step with a clock, its publishers and its commands.

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <sensor_msgs/JointState.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "planar_chain/simulation.h"
#include "ros/messages/frames.h"
#include "ros/messages/messages.h"
#include "ros/messages/pace.h"
#include "ros/node/clock.h"
#include "ros/node/command_log.h"
#include "ros/node/commands.h"
#include "ros/node/diagnostics.h"
#include "ros/node/master_watch.h"
#include "ros/node/queries.h"
#include "ros/view/views.h"

namespace planar_chain {

/// Tick k brings the simulation to scene time (k − origin)/rate, exactly, whatever the clock; clock.h says
/// when, and how it is stamped. origin: the tick of the start, or of the last reset. Ticks stand still while
/// the node is paused, after a fault, and with their clock. A message is made when somebody listens to it,
/// and only then. A tick that takes long does not keep it from telling how it fares, nor from being asked:
/// what would change the motion has to wait, or is refused; ~reset gives the tick up.
class Node {
 public:
  /// Sets robot_description, advertises and subscribes.
  /// @throws Refused what is wrong with the scene's frames.
  explicit Node(const Scene& scene);

  /// When the services are advertised, too. Ticks and serves while goesOn says so, which is asked in the
  /// middle of long ticks, too.
  void run(bool (*goesOn)());

  // What may be asked of it, between two ticks. Where the answer is no success, nothing has changed.
  struct Answer {
    bool success;
    std::string message;
  };
  Answer pause();
  Answer resume();
  /// The scene's first state at scene time 0, without commands and faults.
  Answer reset();
  Answer clearCommands();
  Answer setState(const std::vector<double>& q, const std::vector<double>& qd);
  /// `ticks` ticks, after which it is paused, with these torques held if there are any. Adds the state after
  /// each to `states`. No success, but all changed so far, when the integration fails on the way.
  Answer step(const std::vector<double>& torques, std::uint32_t ticks,
              std::vector<sensor_msgs::JointState>& states);

 private:
  double serve();
  void tellOfItself(double now);
  void serveTicks(double now);
  bool tick();
  bool bear(double began);
  void publishState();
  void publishStatus(double now);
  void lookAtNode();
  void publishDiagnostics();
  void goOn();

  double sceneTime(long long tick) const { return pace_.timeOf(tick - origin_); }
  double simTime() const { return pace_.timeOf(origin_) + simulation_.time(); }
  double sceneTimeOf(ros::Time stamp) const;
  double elapsed() const;  ///< wall time since the start, s

  ros::CallbackQueue commandQueue_;  ///< they wait for the end of a tick
  ros::NodeHandle outer_;            ///< the node's namespace
  ros::NodeHandle inner_{"~"};       ///< below the node's name
  PublishSettings settings_;
  Frames frames_;
  Simulation simulation_;
  std::unique_ptr<Clock> clock_;
  CommandLog log_;
  Commands commands_;
  Queries queries_;
  Messages messages_;
  Views views_;
  SimStatus status_;
  Diagnostics diagnostics_;

  ros::Publisher jointStatesOut_, linkStatesOut_, tfOut_, statusOut_;
  std::optional<tf2_ros::StaticTransformBroadcaster> staticTf_;
  std::optional<MasterWatch> master_;  ///< from run() on

  Pace pace_;
  long long next_;        ///< the first tick that has not happened yet
  long long origin_ = 0;  ///< the tick of scene time 0
  bool paused_ = false;
  bool inTick_ = false;
  long long resets_ = 0;
  bool (*goesOn_)() = nullptr;  ///< from run() on
  double breathUntil_ = 0;      ///< s of wall time
  std::uint64_t overruns_ = 0;
  RealTimeFactor factor_;
  Every statuses_, warnings_, reminders_, diagnoses_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace planar_chain
