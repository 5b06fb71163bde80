#include "ros/node/commands.h"

#include <ros/console.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "ros/messages/incoming.h"

namespace planar_chain {

namespace {

constexpr std::uint32_t queueSize = 2000;  // two seconds of commands at 1000 Hz
constexpr std::size_t longestList = 200;   // characters of the names listed in a fault
constexpr double farthestStart = 86400;    // s: a start farther ahead is a time of another clock
constexpr double stampResolution = 1e-9;   // s

using Faults = std::vector<Fault>;

void checkZero(Faults& faults, const std::string& path, double value) {
  if (value == 0) return;
  faults.push_back({path, "0 (the motion is planar)", toText(value)});
}

/// Returns the index of `name`. Without one, adds a fault and returns −1.
int find(Faults& faults, const std::string& path, const std::map<std::string, int>& indices,
         const std::string& name) {
  const auto found = indices.find(name);
  if (found != indices.end()) return found->second;
  std::string known;
  for (auto entry = indices.begin(); entry != indices.end() && known.size() < longestList; ++entry) {
    known += (known.empty() ? "" : ", ") + entry->first;
  }
  if (known.size() >= longestList) known += ", …";
  faults.push_back({path, "one of " + known, quoted(name)});
  return -1;
}

double age(double now, double taken) {
  return taken < 0 ? taken : now - taken;
}

}  // namespace

CommandTopics::CommandTopics(Simulation& simulation, SceneTime sceneTime)
    : simulation_(simulation), sceneTime_(std::move(sceneTime)) {
  const Chain& chain = simulation.scene().chain;
  for (int i = 0; i < chain.size(); ++i) {
    joints_[chain.joints()[index(i)].name] = i;
    links_[chain.links()[index(i)].name] = i;
  }
}

void CommandTopics::listen(ros::NodeHandle& node, CommandLog& log) {
  log_ = &log;
  const auto hints = ros::TransportHints().tcpNoDelay();
  using TorquesIn = std_msgs::Float64MultiArray_<Bounded<void>>;
  const boost::function<void(const TorquesIn&)> takeTorques = [this](const TorquesIn& in) {
    std_msgs::Float64MultiArray message;
    message.data = plain(in.data);
    takeJointTorques(message);
  };
  subscribers_ = {
      node.subscribe<TorquesIn, const TorquesIn&>("joint_torques", queueSize, takeTorques, {}, hints),
      node.subscribe("joint_torque", queueSize, &CommandTopics::takeJointTorque, this, hints),
      node.subscribe("link_force", queueSize, &CommandTopics::takeLinkForce, this, hints)};
}

// ---- Accepting -----------------------------------------------------------------------------------

void CommandTopics::takeJointTorques(const std_msgs::Float64MultiArray& message) {
  if (refused(faultsOf(message.data, "joint_torques/data"))) return;
  hold(message.data);
  log(CommandTaken::JOINT_TORQUES, [&](CommandTaken& entry) { entry.joint_torques = message.data; });
}

void CommandTopics::takeJointTorque(const JointTorque& message) {
  Faults faults;
  const int joint = find(faults, "joint_torque/joint", joints_, message.joint);
  checkFinite(faults, "joint_torque/torque", "N m", message.torque);
  const double start = startOf(faults, "joint_torque", message);
  if (refused(faults)) return;

  const bool isAccepted = message.duration > 0
                              ? simulation_.addTorque(joint, message.torque, message.duration, start)
                              : simulation_.holdTorque(joint, message.torque, heldUntil(start), start);
  if (refusedFull("joint_torque", isAccepted)) return;
  jointTorqueTaken_ = simulation_.time();
  log(CommandTaken::JOINT_TORQUE, [&](CommandTaken& entry) {
    entry.joint_torque.push_back(message);
    entry.start = start;
  });
}

void CommandTopics::takeLinkForce(const LinkForce& message) {
  Faults faults;
  const int link = find(faults, "link_force/link", links_, message.link);
  checkFinite(faults, "link_force/point/x", "m", message.point.x);
  checkFinite(faults, "link_force/point/y", "m", message.point.y);
  checkZero(faults, "link_force/point/z", message.point.z);
  checkFinite(faults, "link_force/force/x", "N", message.force.x);
  checkFinite(faults, "link_force/force/y", "N", message.force.y);
  checkZero(faults, "link_force/force/z", message.force.z);
  checkFinite(faults, "link_force/moment", "N m", message.moment);
  const double start = startOf(faults, "link_force", message);
  if (refused(faults)) return;

  const Vec2d point{message.point.x, message.point.y}, force{message.force.x, message.force.y};
  const bool isAccepted =
      message.duration > 0
          ? simulation_.addForce(link, point, force, message.moment, message.duration, start)
          : simulation_.holdForce(link, point, force, message.moment, heldUntil(start), start);
  if (refusedFull("link_force", isAccepted)) return;
  linkForceTaken_ = simulation_.time();
  log(CommandTaken::LINK_FORCE, [&](CommandTaken& entry) {
    entry.link_force.push_back(message);
    entry.start = start;
  });
}

bool CommandTopics::take(const CommandTaken& recorded) {
  const std::uint64_t rejectedBefore = rejected_;
  if (recorded.kind == CommandTaken::JOINT_TORQUES) {
    std_msgs::Float64MultiArray torques;
    torques.data = recorded.joint_torques;
    takeJointTorques(torques);
  }
  for (const JointTorque& torque : recorded.joint_torque) takeJointTorque(torque);
  for (const LinkForce& force : recorded.link_force) takeLinkForce(force);
  return rejected_ == rejectedBefore;
}

void CommandTopics::hold(const std::vector<double>& torques) {
  const double until = heldUntil(simulation_.time());
  for (std::size_t i = 0; i < torques.size(); ++i) {
    simulation_.holdTorque(static_cast<int>(i), torques[i], until);
  }
  jointTorquesTaken_ = simulation_.time();
}

double CommandTopics::heldUntil(double start) const {
  const double timeout = simulation_.scene().commandTimeout;
  return timeout > 0 ? start + timeout : std::numeric_limits<double>::infinity();
}

template <class Fill>
void CommandTopics::log(std::uint8_t kind, Fill&& fill) {
  if (log_) log_->add(kind, fill);
}

void CommandTopics::forget() {
  jointTorquesTaken_ = jointTorqueTaken_ = linkForceTaken_ = never;
}

// ---- Refusing ------------------------------------------------------------------------------------

std::vector<Fault> CommandTopics::faultsOf(const std::vector<double>& torques,
                                           const std::string& path) const {
  Faults faults;
  checkValues(faults, path, "torques", "N m", torques, simulation_.q().size());
  if (!(heldUntil(simulation_.time()) > simulation_.time())) {
    faults.push_back({"command_timeout", "a timeout that the simulation time can resolve",
                      toText(simulation_.scene().commandTimeout)});
  }
  return faults;
}

/// Returns the simulation time at which a command starts. Adds a fault if it would never act.
template <class Message>
double CommandTopics::startOf(Faults& faults, const std::string& topic, const Message& message) const {
  // Convert the start.
  const double now = simulation_.time();
  const double start = message.start.isZero() ? now : sceneTime_(message.start);
  if (!(start - now <= farthestStart)) {
    faults.push_back(
        {topic + "/start", "0 for now, or the node's time, at most a day ahead",
         std::isfinite(start) ? toText(start - now) + " s ahead" : "a time before /clock has begun"});
    return now;
  }

  // Check the duration and the end.
  const double duration = message.duration;
  if (!(std::isfinite(duration) && duration >= 0 && (duration == 0 || start + duration > start))) {
    faults.push_back({topic + "/duration", "a finite number >= 0 s", toText(duration)});
    return now;
  }
  const double end = duration > 0 ? start + duration : heldUntil(start);
  if (!(end > std::max(start, now)) || (start < now && end - now < stampResolution)) {
    faults.push_back({topic + "/start", "a command that has not expired",
                      toText(now - start) + " s ago, for " + toText(end - start) + " s"});
  }
  return start;
}

bool CommandTopics::refused(const Faults& faults) {
  if (faults.empty()) return false;
  ++rejected_;
  lastRejection_ = toString(faults);
  // Throttle by wall time, as simulation time may be halted.
  if (warnings_.isDue(ros::WallTime::now().toSec())) ROS_WARN("command refused: %s", lastRejection_.c_str());
  return true;
}

/// isAccepted: what the simulation returned.
bool CommandTopics::refusedFull(const std::string& topic, bool isAccepted) {
  return !isAccepted &&
         refused({{topic, "at most " + std::to_string(capacity) + " timed or waiting commands", "one more"}});
}

void CommandTopics::describe(SimStatus& status) const {
  const double now = simulation_.time();
  status.joint_torques_age = age(now, jointTorquesTaken_);
  status.joint_torque_age = age(now, jointTorqueTaken_);
  status.link_force_age = age(now, linkForceTaken_);
  status.rejected_commands = rejected_;
  status.last_rejection = lastRejection_;
}

}  // namespace planar_chain
