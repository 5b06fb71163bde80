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
#include <vector>

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

bool isHeard(const ros::Publisher& topic) {
  return topic.getNumSubscribers() > 0;  // none where the scene does not want it advertised
}

std::string count(int number, const std::string& one) {
  return std::to_string(number) + " " + one + (number == 1 ? "" : "s");
}

/// "a, b, c"; "nothing".
std::string listed(const std::vector<std::string>& items) {
  std::string list;
  for (const std::string& item : items) list += (list.empty() ? "" : ", ") + item;
  return list.empty() ? "nothing" : list;
}

}  // namespace

Node::Node(const Scene& scene)
    : settings_(onWallTime(scene).publish),
      frames_(framesOf(scene, ros::this_node::getNamespace())),
      simulation_(scene, Commands::capacity),
      log_(inner_,
           [this] {
             return CommandLog::Instant{next_, simulation_.time()};
           }),
      commands_(inner_, simulation_, log_),
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
  sayWhatIsPublished();

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
  if (simulation_.fault().empty() && simulation_.advanceTo(pace_.timeOf(k))) {
    publishState(k, stamp);
  } else if (!faultSaid_) {
    ROS_ERROR("%s", simulation_.fault().c_str());
    faultSaid_ = true;
  }
  if (pace_.falls(k, settings_.statusRate)) publishStatus(stamp);
}

void Node::publishState(long long k, ros::Time stamp) {
  if (isHeard(jointStatesOut_)) jointStatesOut_.publish(messages_.jointStates(simulation_, stamp));
  if (isHeard(tfOut_) && pace_.falls(k, settings_.tfRate)) {
    tfOut_.publish(messages_.transforms(simulation_, stamp));
  }
  if (isHeard(linkStatesOut_)) linkStatesOut_.publish(messages_.linkStates(simulation_, stamp));
}

void Node::publishStatus(ros::Time stamp) {
  const double now = elapsed();
  // Sampled whoever listens: it looks back to before the listener came.
  status_.real_time_factor = factor_.sample(simulation_.time(), now);
  if (!isHeard(statusOut_)) return;
  status_.header.stamp = stamp;
  describe(simulation_, status_);
  commands_.describe(status_);
  status_.overruns = overruns_;
  status_.lag = now - simulation_.time();
  statusOut_.publish(status_);
}

void Node::sayWhatRuns() const {
  const Scene& scene = simulation_.scene();
  int springs = 0, dampers = 0, limits = 0;
  for (const Joint& joint : scene.chain.joints()) {
    springs += joint.stiffness > 0;
    dampers += joint.damping > 0;
    limits += std::isfinite(joint.lower) + std::isfinite(joint.upper);
  }
  std::ostringstream held;
  held << "commands that ";
  if (scene.commandTimeout > 0) {
    held << "lapse after " << scene.commandTimeout << " s";
  } else {
    held << "hold until replaced";
  }

  std::vector<std::string> runs, leftOut;
  const auto tell = [&](int number, const std::string& one) {
    (number > 0 ? runs : leftOut).push_back(number > 0 ? count(number, one) : one + "s");
  };
  if (scene.chain.gravity() == Vec2d{}) {
    leftOut.push_back("gravity");
  } else {
    runs.push_back("gravity");
  }
  // With dampers, the springs that are missing run along at 0 N m/rad: not left out.
  if (springs > 0 || dampers == 0) tell(springs, "spring");
  tell(dampers, "damper");
  tell(static_cast<int>(scene.loads.size()), "load");
  tell(limits, "limit");
  runs.push_back("energy guard");
  runs.push_back(held.str());

  const IntegratorSettings& integrator = scene.integrator;
  const bool hasFixedStep = ode::hasFixedStep(integrator.method);
  std::ostringstream line;
  line << count(scene.chain.size(), "link") << " (" << simulation_.recursion() << ") by " << integrator.method
       << (hasFixedStep ? ", step " : ", tolerance ")
       << (hasFixedStep ? integrator.step : integrator.tolerance) << "; runs: " << listed(runs)
       << "; left out: " << listed(leftOut);
  ROS_INFO("%s", line.str().c_str());
}

void Node::sayWhatIsPublished() const {
  std::ostringstream line;
  line << "made while somebody listens: joint_states";
  if (settings_.linkStates) line << " and link_states";
  line << " at " << settings_.rate << " Hz, ";
  if (settings_.tf) line << "tf at " << settings_.tfRate << " Hz below " << frames_.base << ", ";
  line << "status at " << settings_.statusRate << " Hz";

  std::vector<std::string> never;
  if (!settings_.linkStates) never.push_back("link_states");
  if (!settings_.tf) never.push_back("tf");
  if (!never.empty()) line << "; never: " << listed(never);
  ROS_INFO("%s", line.str().c_str());
}

ros::Time Node::stampOf(long long k) const {
  return start_ + ros::Duration().fromNSec(pace_.nanosecondsOf(k));
}

double Node::elapsed() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - steadyStart_).count();
}

}  // namespace planar_chain
