#include "planar_chain/ros/commands.h"

#include <ros/console.h>

#include <cmath>
#include <limits>

#include "planar_chain/value.h"

namespace planar_chain {

namespace {

constexpr std::uint32_t queueSize = 2000;  // two seconds of commands at 1000 Hz

using Faults = std::vector<Fault>;

void checkFinite(Faults& faults, const std::string& path, const char* unit, double value) {
  if (std::isfinite(value)) return;
  faults.push_back({path, std::string("a finite number, ") + unit, toText(value)});
}

void checkZero(Faults& faults, const std::string& path, double value) {
  if (value == 0) return;
  faults.push_back({path, "0: the motion is plane", toText(value)});
}

/// Finite, not negative, and not too short for the clock to tell its end from its start.
void checkDuration(Faults& faults, const std::string& path, double now, double duration) {
  const bool lasts = duration == 0 || now + duration > now;
  if (std::isfinite(duration) && duration >= 0 && lasts) return;
  faults.push_back({path, "a finite number >= 0 s", toText(duration)});
}

/// The index of `name`, or −1 and a fault.
int find(Faults& faults, const std::string& path, const std::map<std::string, int>& index,
         const std::string& name) {
  const auto found = index.find(name);
  if (found != index.end()) return found->second;
  std::string known;
  for (const auto& entry : index) known += (known.empty() ? "" : ", ") + entry.first;
  faults.push_back({path, "one of " + known, describe(Value(name))});
  return -1;
}

void checkRoom(Faults& faults, const std::string& topic, bool taken) {
  if (taken) return;
  faults.push_back(
      {topic, "at most " + std::to_string(Commands::capacity) + " timed commands in force", "one more"});
}

double age(double now, double taken) {
  return taken < 0 ? taken : now - taken;
}

}  // namespace

Commands::Commands(Simulation& simulation) : simulation_(simulation) {
  const Chain& chain = simulation.scene().chain;
  for (int i = 0; i < chain.size(); ++i) {
    joints_[chain.joints()[static_cast<std::size_t>(i)].name] = i;
    links_[chain.links()[static_cast<std::size_t>(i)].name] = i;
  }
}

Commands::Commands(ros::NodeHandle& node, Simulation& simulation, CommandLog& log) : Commands(simulation) {
  log_ = &log;
  subscribers_ = {node.subscribe("joint_torques", queueSize, &Commands::takeJointTorques, this),
                  node.subscribe("joint_torque", queueSize, &Commands::takeJointTorque, this),
                  node.subscribe("link_force", queueSize, &Commands::takeLinkForce, this)};
}

void Commands::takeJointTorques(const std_msgs::Float64MultiArray& message) {
  const auto& joints = simulation_.scene().chain.joints();
  Faults faults;
  if (message.data.size() != joints.size()) {
    faults.push_back({"joint_torques/data",
                      std::to_string(joints.size()) + " torques, one per joint in chain order",
                      std::to_string(message.data.size())});
  } else {
    for (std::size_t i = 0; i < joints.size(); ++i) {
      checkFinite(faults, "joint_torques/data[" + std::to_string(i) + "]", "N m", message.data[i]);
    }
  }
  if (refused(faults)) return;

  for (std::size_t i = 0; i < joints.size(); ++i) {
    simulation_.holdTorque(static_cast<int>(i), message.data[i], heldUntil());
  }
  jointTorquesTaken_ = simulation_.time();
  log([&](CommandTaken& taken) { taken.joint_torques = message.data; });
}

void Commands::takeJointTorque(const JointTorque& message) {
  Faults faults;
  const int joint = find(faults, "joint_torque/joint", joints_, message.joint);
  checkFinite(faults, "joint_torque/torque", "N m", message.torque);
  checkDuration(faults, "joint_torque/duration", simulation_.time(), message.duration);
  if (refused(faults)) return;

  if (message.duration > 0) {
    checkRoom(faults, "joint_torque", simulation_.addTorque(joint, message.torque, message.duration));
    if (refused(faults)) return;
  } else {
    simulation_.holdTorque(joint, message.torque, heldUntil());
  }
  jointTorqueTaken_ = simulation_.time();
  log([&](CommandTaken& taken) { taken.joint_torque.push_back(message); });
}

void Commands::takeLinkForce(const LinkForce& message) {
  Faults faults;
  const int link = find(faults, "link_force/link", links_, message.link);
  checkFinite(faults, "link_force/point/x", "m", message.point.x);
  checkFinite(faults, "link_force/point/y", "m", message.point.y);
  checkZero(faults, "link_force/point/z", message.point.z);
  checkFinite(faults, "link_force/force/x", "N", message.force.x);
  checkFinite(faults, "link_force/force/y", "N", message.force.y);
  checkZero(faults, "link_force/force/z", message.force.z);
  checkFinite(faults, "link_force/moment", "N m", message.moment);
  checkDuration(faults, "link_force/duration", simulation_.time(), message.duration);
  if (refused(faults)) return;

  const Vec2d point{message.point.x, message.point.y};
  const Vec2d force{message.force.x, message.force.y};
  if (message.duration > 0) {
    checkRoom(faults, "link_force",
              simulation_.addForce(link, point, force, message.moment, message.duration));
    if (refused(faults)) return;
  } else {
    simulation_.holdForce(link, point, force, message.moment, heldUntil());
  }
  linkForceTaken_ = simulation_.time();
  log([&](CommandTaken& taken) { taken.link_force.push_back(message); });
}

bool Commands::refused(const std::vector<Fault>& faults) {
  if (faults.empty()) return false;
  ++rejected_;
  lastRejection_.clear();
  for (const Fault& fault : faults) {
    if (!lastRejection_.empty()) lastRejection_ += "; ";
    lastRejection_ += toString(fault);
  }
  ROS_WARN_THROTTLE(1.0, "command refused: %s", lastRejection_.c_str());
  return true;
}

template <class Fill>
void Commands::log(Fill&& fill) {
  if (log_) log_->add(fill);
}

bool Commands::take(const CommandTaken& recorded) {
  const std::uint64_t rejectedBefore = rejected_;
  for (const JointTorque& torque : recorded.joint_torque) takeJointTorque(torque);
  for (const LinkForce& force : recorded.link_force) takeLinkForce(force);
  if (recorded.joint_torque.empty() && recorded.link_force.empty()) {
    std_msgs::Float64MultiArray torques;
    torques.data = recorded.joint_torques;
    takeJointTorques(torques);
  }
  return rejected_ == rejectedBefore;
}

double Commands::heldUntil() const {
  const double timeout = simulation_.scene().commandTimeout;
  return timeout > 0 ? simulation_.time() + timeout : std::numeric_limits<double>::infinity();
}

void Commands::describe(SimStatus& status) const {
  const double now = simulation_.time();
  status.joint_torques_age = age(now, jointTorquesTaken_);
  status.joint_torque_age = age(now, jointTorqueTaken_);
  status.link_force_age = age(now, linkForceTaken_);
  status.rejected_commands = rejected_;
  status.last_rejection = lastRejection_;
}

}  // namespace planar_chain
