#include "ros/node/commands.h"

#include <ros/console.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "planar_chain/value.h"
#include "ros/messages/bounded.h"
#include "ros/messages/checks.h"

namespace planar_chain {

namespace {

constexpr std::uint32_t queueSize = 2000;  // two seconds of commands at 1000 Hz
constexpr std::size_t longestList = 200;   // letters of names that are told
constexpr double farthestStart = 86400;    // s: what is farther was meant by another clock
constexpr double stampResolution = 1e-9;   // s

using Faults = std::vector<Fault>;

void checkZero(Faults& faults, const std::string& path, double value) {
  if (value == 0) return;
  faults.push_back({path, "0: the motion is plane", toText(value)});
}

/// The index of `name`, or −1 and a fault.
int find(Faults& faults, const std::string& path, const std::map<std::string, int>& index,
         const std::string& name) {
  const auto found = index.find(name);
  if (found != index.end()) return found->second;
  std::string known;
  for (auto entry = index.begin(); entry != index.end() && known.size() < longestList; ++entry) {
    known += (known.empty() ? "" : ", ") + entry->first;
  }
  if (known.size() >= longestList) known += ", …";
  faults.push_back({path, "one of " + known, describe(Value(name))});
  return -1;
}

std::vector<Fault> faultsOfRoom(const std::string& topic, bool taken) {
  if (taken) return {};
  return {{topic, "at most " + std::to_string(Commands::capacity) + " commands that are timed or wait",
           "one more"}};
}

double age(double now, double taken) {
  return taken < 0 ? taken : now - taken;
}

}  // namespace

Commands::Commands(Simulation& simulation, SceneTime sceneTime)
    : simulation_(simulation), sceneTime_(std::move(sceneTime)) {
  const Chain& chain = simulation.scene().chain;
  for (int i = 0; i < chain.size(); ++i) {
    joints_[chain.joints()[static_cast<std::size_t>(i)].name] = i;
    links_[chain.links()[static_cast<std::size_t>(i)].name] = i;
  }
}

void Commands::listen(ros::NodeHandle& node, CommandLog& log) {
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
      node.subscribe("joint_torque", queueSize, &Commands::takeJointTorque, this, hints),
      node.subscribe("link_force", queueSize, &Commands::takeLinkForce, this, hints)};
}

std::vector<Fault> Commands::faultsOf(const std::vector<double>& torques, const std::string& path) const {
  Faults faults;
  checkValues(faults, path, "torques", "N m", torques, simulation_.q().size());
  if (!(heldFrom(simulation_.time()) > simulation_.time())) {
    faults.push_back({"command_timeout", "a time that passes", toText(simulation_.scene().commandTimeout)});
  }
  return faults;
}

void Commands::hold(const std::vector<double>& torques) {
  const double until = heldFrom(simulation_.time());
  for (std::size_t i = 0; i < torques.size(); ++i) {
    simulation_.holdTorque(static_cast<int>(i), torques[i], until);
  }
  jointTorquesTaken_ = simulation_.time();
}

void Commands::forget() {
  jointTorquesTaken_ = jointTorqueTaken_ = linkForceTaken_ = never;
}

void Commands::takeJointTorques(const std_msgs::Float64MultiArray& message) {
  if (refused(faultsOf(message.data, "joint_torques/data"))) return;
  hold(message.data);
  log(CommandTaken::JOINT_TORQUES, [&](CommandTaken& entry) { entry.joint_torques = message.data; });
}

void Commands::takeJointTorque(const JointTorque& message) {
  Faults faults;
  const int joint = find(faults, "joint_torque/joint", joints_, message.joint);
  checkFinite(faults, "joint_torque/torque", "N m", message.torque);
  const Window window = windowOf(faults, "joint_torque", message.start, message.duration);
  if (refused(faults)) return;

  const bool taken =
      message.duration > 0
          ? simulation_.addTorque(joint, message.torque, window.duration, window.start)
          : simulation_.holdTorque(joint, message.torque, heldFrom(window.start), window.start);
  if (refused(faultsOfRoom("joint_torque", taken))) return;
  jointTorqueTaken_ = simulation_.time();
  log(CommandTaken::JOINT_TORQUE, [&](CommandTaken& entry) {
    entry.joint_torque.push_back(message);
    entry.start = window.start;
  });
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
  const Window window = windowOf(faults, "link_force", message.start, message.duration);
  if (refused(faults)) return;

  const Vec2d point{message.point.x, message.point.y};
  const Vec2d force{message.force.x, message.force.y};
  const bool taken =
      message.duration > 0
          ? simulation_.addForce(link, point, force, message.moment, window.duration, window.start)
          : simulation_.holdForce(link, point, force, message.moment, heldFrom(window.start), window.start);
  if (refused(faultsOfRoom("link_force", taken))) return;
  linkForceTaken_ = simulation_.time();
  log(CommandTaken::LINK_FORCE, [&](CommandTaken& entry) {
    entry.link_force.push_back(message);
    entry.start = window.start;
  });
}

/// When a command acts, in the simulation's time; a fault where it never would.
Commands::Window Commands::windowOf(Faults& faults, const std::string& topic, ros::Time start,
                                    double duration) const {
  const double now = simulation_.time();
  const double begin = start.isZero() ? now : sceneTime_(start);
  if (!(begin - now <= farthestStart)) {
    faults.push_back(
        {topic + "/start", "0 for now, or the node's time, at most a day ahead",
         std::isfinite(begin) ? toText(begin - now) + " s ahead" : "a time before /clock has begun"});
    return {};
  }
  if (!(std::isfinite(duration) && duration >= 0 && (duration == 0 || begin + duration > begin))) {
    faults.push_back({topic + "/duration", "a finite number >= 0 s", toText(duration)});
    return {};
  }
  const double end = duration > 0 ? begin + duration : heldFrom(begin);
  if (!(end > std::max(begin, now)) || (begin < now && end - now < stampResolution)) {
    faults.push_back({topic + "/start", "a command that is not over",
                      toText(now - begin) + " s ago, for " + toText(end - begin) + " s"});
  }
  return {begin, duration};
}

bool Commands::refused(const std::vector<Fault>& faults) {
  if (faults.empty()) return false;
  ++rejected_;
  lastRejection_ = toString(faults);
  // By the wall: sim time may stand still.
  if (warnings_.falls(ros::WallTime::now().toSec())) ROS_WARN("command refused: %s", lastRejection_.c_str());
  return true;
}

template <class Fill>
void Commands::log(std::uint8_t kind, Fill&& fill) {
  if (log_) log_->add(kind, fill);
}

bool Commands::take(const CommandTaken& recorded) {
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

double Commands::heldFrom(double start) const {
  const double timeout = simulation_.scene().commandTimeout;
  return timeout > 0 ? start + timeout : std::numeric_limits<double>::infinity();
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
