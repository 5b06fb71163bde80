#pragma once

/// The node: a simulation that follows a clock, its publishers, its commands and its services.

#include <diagnostic_updater/diagnostic_updater.h>
#include <planar_chain/Step.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/service_server.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <boost/circular_buffer.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_chain/simulation.h"
#include "ros/messages/incoming.h"
#include "ros/messages/rests.h"
#include "ros/messages/ticks.h"
#include "ros/node/clock.h"
#include "ros/node/commands.h"
#include "ros/node/tolerance_control.h"
#include "ros/view/messages.h"

namespace planar_chain {

/// Tick k advances the simulation to scene time (k − origin)/rate exactly, with any clock. The origin is the
/// tick of the start or of the last reset. clock.h determines when a tick is due and how it is stamped. There
/// are no ticks while the node is paused, after a fault, and while the clock is halted. A message is computed
/// only if it has subscribers.
///
/// During a long tick, and between the ticks of a long ~step, the node still publishes its status and answers
/// services. Commands wait. Services that change the motion are refused, except ~reset, which aborts the
/// tick.
class Node {
 public:
  /// Sets robot_description, advertises topics and services, and subscribes. changedScene: returns another
  /// scene for ~reset, or nothing; may throw Refused.
  /// @throws Refused for frame names that collide.
  explicit Node(const Scene& scene, std::function<std::optional<Scene>()> changedScene = {});

  /// Waits until each topic has a subscriber, while keepGoing() is true: at most 15 s, then with a warning.
  /// Commands and requests that arrive meanwhile are served later.
  void waitForRecorder(bool (*keepGoing)());

  /// Ticks and serves while keepGoing() is true; it is polled during long ticks too.
  void run(bool (*keepGoing)());

  // The services. Each acts between two ticks. If `success` is false, nothing has changed.
  Answer pause();
  Answer resume();
  /// Restores the scene's initial state at scene time 0, without commands and faults. If the parameters have
  /// changed, it is that of the new scene.
  Answer reset();
  Answer clearCommands();
  /// Sets the stable equilibrium that is reached from the present angles, at rest, as a tick of its own.
  Answer settle();
  Answer setState(const std::vector<double>& q, const std::vector<double>& qd);
  /// Pauses, holds torques and moves the base where given, and makes n ticks. Appends the state after each.
  /// If the integration fails, the ticks before the failure remain.
  Answer step(const StepRequest& request, StepResponse& response);

 private:
  void load(const Scene& scene);
  void advertiseServices();
  double runDueTicks();
  void allowYielding();
  void controlTolerance(double work);
  void showSetState();
  bool tick();
  bool serveDuringTicks();
  /// Call it before a tick.
  void restForRecorder() {
    if (commands_.areRecorded()) rests_.waitForOne();
  }
  void sampleTimes();
  void setPaused(bool paused);
  void publishStatus();
  void publishDiagnostics();
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& out);
  void updateStatus();

  Answer take(const CommandTaken& input, const char* done);
  double sceneTimeOf(ros::Time stamp) const;

  ros::NodeHandle outer_;       ///< in the node's namespace
  ros::NodeHandle inner_{"~"};  ///< below the node's name
  const PublishSettings settings_;
  std::function<std::optional<Scene>()> changedScene_;
  std::unique_ptr<Simulation> simulation_;
  std::unique_ptr<Messages> messages_;
  std::unique_ptr<Clock> clock_;
  Ticks ticks_;
  Commands commands_;
  SimStatus status_;
  diagnostic_updater::Updater diagnostics_;

  std::map<std::string, ros::Publisher> statesOut_;  ///< by topic
  tf2_ros::StaticTransformBroadcaster staticTf_;
  ros::Publisher statusOut_, sceneOut_;
  std::vector<ros::ServiceServer> servers_;

  bool paused_ = false;
  bool isClockRunning_ = false;  ///< since the last halt, begin() has been called
  bool isWaiting_ = false;       ///< for a recorder
  bool inTick_ = false;          ///< while services are served during a tick
  bool severalClocks_ = false;   ///< publish /clock, by the last check
  long long resets_ = 0;
  bool (*keepGoing_)() = nullptr;  ///< from run() on
  double began_ = 0;               ///< steadyTime() at which ticks began that nothing else has followed
  double served_ = 0;              ///< steadyTime() at which the queues were last served
  double resting_ = 0;             ///< no tick before this steadyTime()
  std::uint64_t overruns_ = 0;
  std::uint64_t jumpsTold_ = 0;                              ///< jumps of the clock, on /diagnostics
  boost::circular_buffer<std::pair<double, double>> times_;  ///< simulated and steady time, lately
  std::pair<double, double> sampledAt_, skipped_;  ///< the same at the last sample, and while paused
  double motionEnd_ = 0;                           ///< s, of the scene's drives and base
  Every warnings_, advice_, clockWarnings_;
  Rests rests_;                                       ///< of ticks that are recorded
  std::optional<ToleranceControl> toleranceControl_;  ///< if the tolerance may yield
  double load_ = 0, stepsOfTick_ = 0;                 ///< of a tick, in the mean of about the last twenty
  double stepsBefore_ = 0;                            ///< all steps before the next tick
};

}  // namespace planar_chain
