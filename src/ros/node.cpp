#include "planar_chain/ros/node.h"

#include <ros/console.h>
#include <ros/init.h>
#include <ros/param.h>
#include <ros/this_node.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

#include "planar_chain/ode/methods.h"
#include "planar_chain/ros/urdf.h"

namespace planar_chain {

namespace {

constexpr double queueSeconds = 2;      // what a publisher keeps for a slow subscriber
constexpr long long fewTicks = 4;       // done at a stretch when behind,
constexpr long long catchUpShare = 50;  // or this part of what is missing,
constexpr double catchUpTime = 0.05;    // s of wall time at most
constexpr double patience = 1;          // s of lag that are made up for
constexpr double factorSeconds = 5;     // over which the real-time factor is measured
constexpr double warningPeriod = 5.0;   // s

std::uint32_t queueFor(double rate) {
  return static_cast<std::uint32_t>(std::max(10.0, std::ceil(queueSeconds * rate)));
}

/// Stamps come from wall time; a clock that someone else drives would be a second opinion.
const Scene& onWallTime(const Scene& scene) {
  if (ros::param::param("/use_sim_time", false)) {
    throw Refused({{"/use_sim_time", "false: the node runs on wall time", "true"}});
  }
  return scene;
}

std::string count(int number, const char* what) {
  if (number == 0) return std::string("no ") + what + "s";
  return std::to_string(number) + " " + what + (number == 1 ? "" : "s");
}

}  // namespace

Node::Node(const Scene& scene)
    : settings_(onWallTime(scene).publish),
      frames_(framesOf(scene, ros::this_node::getNamespace())),
      simulation_(scene, Commands::capacity),
      commands_(inner_, simulation_),
      messages_(scene, frames_),
      pace_(settings_.rate),
      factor_(1 + static_cast<int>(std::ceil(factorSeconds * settings_.statusRate))) {
  outer_.setParam("robot_description", urdfOf(scene, frames_));

  jointStatesOut_ = outer_.advertise<sensor_msgs::JointState>("joint_states", queueFor(settings_.rate));
  statusOut_ = inner_.advertise<SimStatus>("status", queueFor(settings_.statusRate));
  if (settings_.linkStates) {
    linkStatesOut_ = inner_.advertise<LinkStates>("link_states", queueFor(settings_.rate));
  }
  start_ = ros::Time::now();
  if (settings_.tf) {
    tfOut_ = outer_.advertise<tf2_msgs::TFMessage>("/tf", queueFor(settings_.tfRate));
    staticTf_.emplace();
    staticTf_->sendTransform(Messages::baseInWorld(frames_, start_));
  }
  status_.header.frame_id = frames_.base;
  sayWhatRuns();

  steadyStart_ = std::chrono::steady_clock::now();
  timer_ = outer_.createSteadyTimer(ros::WallDuration(1 / settings_.rate), &Node::serveTicks, this);
}

void Node::serveTicks(const ros::SteadyTimerEvent&) {
  const double entered = elapsed();
  if (pace_.giveUp(entered, next_, patience) > 0) {
    ROS_WARN_THROTTLE(warningPeriod,
                      "this machine cannot run this scene in real time at %g Hz: sim time is %.3f s "
                      "behind the wall clock",
                      settings_.rate, pace_.givenUp());
  }

  // Catches up a little at a time: a flood would overrun the queues of those who listen (rosbag keeps
  // 100 messages a topic), and commands are to be served in between.
  const long long due = pace_.due(entered);
  const long long last = std::min(due, next_ + std::max(fewTicks, (due - next_) / catchUpShare) - 1);
  while (next_ <= last && elapsed() - entered <= catchUpTime) tick(next_++);
  if (next_ <= due) ++overruns_;
}

void Node::tick(long long k) {
  const ros::Time stamp = stampOf(k);
  // After a fault only the status goes on: no stamp is given to a state that does not move.
  const bool moves = simulation_.fault().empty() && simulation_.advanceTo(pace_.timeOf(k));
  if (moves) {
    jointStatesOut_.publish(messages_.jointStates(simulation_, stamp));
    if (settings_.tf && pace_.falls(k, settings_.tfRate)) {
      tfOut_.publish(messages_.transforms(simulation_, stamp));
    }
    if (settings_.linkStates && linkStatesOut_.getNumSubscribers() > 0) {
      linkStatesOut_.publish(messages_.linkStates(simulation_, stamp));
    }
  } else if (!faultSaid_) {
    ROS_ERROR("%s", simulation_.fault().c_str());
    faultSaid_ = true;
  }
  if (pace_.falls(k, settings_.statusRate)) publishStatus(stamp);
}

void Node::publishStatus(ros::Time stamp) {
  const double now = elapsed();
  status_.header.stamp = stamp;
  describe(simulation_, status_);
  commands_.describe(status_);
  status_.real_time_factor = factor_.sample(simulation_.time(), now);
  status_.overruns = overruns_;
  status_.lag = now - simulation_.time();
  statusOut_.publish(status_);
}

void Node::sayWhatRuns() const {
  const Scene& scene = simulation_.scene();
  int springs = 0;
  int dampers = 0;
  for (const Joint& joint : scene.chain.joints()) {
    springs += joint.stiffness > 0;
    dampers += joint.damping > 0;
  }
  std::ostringstream line;
  line << count(scene.chain.size(), "link") << " by " << scene.integrator.method
       << (ode::hasFixedStep(scene.integrator.method) ? ", step " : ", tolerance ")
       << (ode::hasFixedStep(scene.integrator.method) ? scene.integrator.step : scene.integrator.tolerance)
       << ", " << (scene.chain.gravity() == Vec2d{} ? "no gravity" : "gravity") << ", "
       << count(springs, "spring") << ", " << count(dampers, "damper") << ", "
       << count(static_cast<int>(scene.loads.size()), "load") << "; joint_states at " << settings_.rate
       << " Hz, " << (settings_.linkStates ? "link_states while someone listens, " : "no link_states, ");
  if (settings_.tf) {
    line << "tf at " << settings_.tfRate << " Hz below " << frames_.base;
  } else {
    line << "no tf";
  }
  line << ", status at " << settings_.statusRate << " Hz; commands ";
  if (scene.commandTimeout > 0) {
    line << "lapse after " << scene.commandTimeout << " s";
  } else {
    line << "hold until replaced";
  }
  ROS_INFO("%s", line.str().c_str());
}

ros::Time Node::stampOf(long long k) const {
  const long double ns = static_cast<long double>(k) * 1e9L / static_cast<long double>(settings_.rate);
  return start_ + ros::Duration().fromNSec(std::llround(ns));
}

double Node::elapsed() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - steadyStart_).count();
}

}  // namespace planar_chain
