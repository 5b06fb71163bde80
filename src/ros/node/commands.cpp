#include "ros/node/commands.h"

#include <ros/console.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "ros/messages/incoming.h"
#include "ros/node/trajectories.h"

namespace planar_chain {

namespace {

constexpr std::uint32_t queueSize = 20000;  // until the next serve() or collect(), at 100,000 Hz
constexpr std::size_t mostWaitingBytes = std::size_t{64} << 20;
constexpr std::size_t bytesOfACommand = 250;     // in memory, beside its lists
constexpr std::uint32_t logSize = 10000;         // a lost message would make the others useless
constexpr double stampResolution = 1e-9;         // s
constexpr std::size_t mostSteps = 10000;         // of one call
constexpr std::size_t mostStepValues = 1000000;  // joints × ticks of one answer

using Faults = std::vector<Fault>;

}  // namespace

void Commands::moveTo(Simulation& simulation) {
  if (simulation_) ++accepted_;
  simulation_ = &simulation;
  joints_.clear();
  links_.clear();
  const Chain& chain = simulation.scene().chain;
  for (int i = 0; i < chain.size(); ++i) {
    joints_[chain.joints()[index(i)].name] = i;
    links_[chain.links()[index(i)].name] = i;
  }
  isDriven_.assign(index(chain.size()), false);
  for (const Drive& drive : simulation.scene().drives) isDriven_[index(drive.joint)] = true;
}

// ---- From topics -------------------------------------------------------------------------------

void Commands::listen(ros::NodeHandle node) {
  node.setCallbackQueue(&queue_);
  log_ = node.advertise<CommandTaken>("commands_taken", logSize);
  const auto hints = ros::TransportHints().tcpNoDelay();
  // Subscribes `take` to what can be read. What cannot is refused.
  const auto subscribe = [&](auto type, const char* topic, auto take) {
    using In = Received<decltype(type)>;
    const boost::function<void(const In&)> onMessage = [this, topic, take](const In& in) {
      if (!in.message) return refuse(toString(Fault{topic, in.expected, in.found}));
      if (!isCollecting_) return take(*in.message);
      const std::size_t bytes = bytesOfACommand + in.length;
      if (waitingBytes_ + bytes > mostWaitingBytes) {
        return refuse(toString(Fault{topic, "at most 64 MiB of messages that wait", "more"}));
      }
      waitingBytes_ += bytes;
      waiting_.push_back({bytes, [take, message = *in.message] { take(message); }});
    };
    subscribers_.push_back(node.subscribe<In, const In&>(topic, queueSize, onMessage, {}, hints));
  };
  using Few = Bounded<void>;
  subscribe(std_msgs::Float64MultiArray_<Few>(), "joint_torques",
            [this](const auto& in) { onJointTorques(plain(in.data)); });
  subscribe(trajectory_msgs::JointTrajectory_<Few>(), "joint_trajectory",
            [this](const auto& in) { onJointTrajectory(plainOf<JointTrajectory>(in)); });
  subscribe(trajectory_msgs::MultiDOFJointTrajectory_<Few>(), "base_trajectory",
            [this](const auto& in) { onBaseTrajectory(plainOf<MultiDOFJointTrajectory>(in)); });
  subscribe(JointTorque(), "joint_torque", [this](const auto& in) { onJointTorque(in); });
  subscribe(LinkForce(), "link_force", [this](const auto& in) { onLinkForce(in); });
}

void Commands::serve() {
  while (haveWaiting()) takeNext();
  queue_.callAvailable();
}

void Commands::serveAtItsPace() {
  if (!areRecorded()) return serve();
  collect();
  while (haveWaiting() && rests_.allowOne()) takeNext();
}

void Commands::takeNext() {
  const Waiting next = std::move(waiting_.front());
  waiting_.pop_front();
  waitingBytes_ -= next.bytes;
  next.take();
}

void Commands::collect() {
  isCollecting_ = true;
  queue_.callAvailable();
  isCollecting_ = false;
}

void Commands::dropWaiting() {
  queue_.clear();
  waiting_.clear();
  waitingBytes_ = 0;
}

void Commands::onJointTorques(const std::vector<double>& torques) {
  CommandTaken input = inputOf(CommandTaken::JOINT_TORQUES);
  input.joint_torques = torques;
  takeOrWarn(input);
}

void Commands::onJointTorque(const JointTorque& message) {
  CommandTaken input = inputOf(CommandTaken::JOINT_TORQUE);
  input.joint_torque.push_back(message);
  input.start = sceneTimeOf(message.start);
  takeOrWarn(input);
}

void Commands::onLinkForce(const LinkForce& message) {
  CommandTaken input = inputOf(CommandTaken::LINK_FORCE);
  input.link_force.push_back(message);
  input.start = sceneTimeOf(message.start);
  takeOrWarn(input);
}

void Commands::onJointTrajectory(const JointTrajectory& message) {
  CommandTaken input = inputOf(CommandTaken::JOINT_TRAJECTORY);
  input.joint_trajectory.push_back(message);
  input.start = sceneTimeOf(message.header.stamp);
  takeOrWarn(input);
}

void Commands::onBaseTrajectory(const MultiDOFJointTrajectory& message) {
  CommandTaken input = inputOf(CommandTaken::BASE_TRAJECTORY);
  input.base_trajectory.push_back(message);
  input.start = sceneTimeOf(message.header.stamp);
  takeOrWarn(input);
}

/// The start in a message: 0 is now.
double Commands::sceneTimeOf(ros::Time start) const {
  return start.isZero() ? simulation_->time() : sceneTime_(start);
}

std::string Commands::takeOrWarn(const CommandTaken& input) {
  const std::string& fault = simulation_->fault();
  std::string refusal = fault.empty() ? take(input) : fault + "; call ~reset, ~settle or ~set_state";
  if (!refusal.empty()) refuse(refusal);
  return refusal;
}

void Commands::refuse(const std::string& reason) {
  ++rejected_;
  lastRejection_ = reason;
  warnOfRefusals();
}

void Commands::warnOfRefusals() {
  // Throttle by wall time, as simulation time may be halted.
  if (rejected_ == warned_ || !warnings_.isDue()) return;
  const auto others = rejected_ - std::exchange(warned_, rejected_) - 1;
  const std::string more = others > 0 ? " (and " + std::to_string(others) + " more)" : "";
  ROS_WARN("command refused: %s%s", lastRejection_.c_str(), more.c_str());
}

// ---- Accepting ---------------------------------------------------------------------------------

std::string Commands::take(CommandTaken input) {
  try {
    const Faults faults = apply(input);
    if (!faults.empty()) return toString(faults);
  } catch (const std::logic_error& refusal) {
    return refusal.what();
  }
  input.number = ++accepted_;
  if (areRecorded()) {
    input.tick = static_cast<std::uint64_t>(ticks_.next);
    input.scene_time = simulation_->time();
    log_.publish(input);
  }
  return "";
}

/// Returns the faults. Without any, the input acts.
/// @throws std::logic_error for a state of infinite energy, and where there is no equilibrium
Faults Commands::apply(const CommandTaken& input) {
  Faults faults;
  switch (input.kind) {
    case CommandTaken::JOINT_TORQUES:
      faults = faultsOf(input.joint_torques, "joint_torques/data");
      if (faults.empty()) hold(input.joint_torques);
      return faults;
    case CommandTaken::JOINT_TORQUE:
      return applyTorque(input);
    case CommandTaken::LINK_FORCE:
      return applyForce(input);
    case CommandTaken::JOINT_TRAJECTORY:
      return applyTrajectory(input);
    case CommandTaken::BASE_TRAJECTORY:
      return applyBaseTrajectory(input);
    case CommandTaken::CLEAR_COMMANDS:
      simulation_->clearCommands();
      return {};
    case CommandTaken::SET_STATE:
      checkValues(faults, "q", "angles", "rad", input.q, simulation_->q().size());
      checkValues(faults, "qd", "rates", "rad/s", input.qd, simulation_->qd().size());
      if (faults.empty()) simulation_->setState(input.q, input.qd);
      return faults;
    case CommandTaken::STEP:
      return applyStep(input);
    case CommandTaken::SETTLE:
      simulation_->settle([this] {
        collect();
        return true;
      });
      // The next tick shows the state, at the present time. It does so anyway if it already shows one.
      if (simulation_->time() == ticks_.sceneTime(ticks_.next - 1)) ++ticks_.origin;
      if (simulation_->time() == ticks_.sceneTime(ticks_.next)) ticks_.set = ticks_.next;
      return {};
    case CommandTaken::TOLERANCE:
      simulation_->setTolerance(input.tolerance);
      return {};
    default:  // RESET
      simulation_->reset();
      taken_.clear();
      ticks_.origin = ticks_.set = ticks_.next;
      return {};
  }
}

/// Starts a timed or a held command: now, or at the start that the message has. Adds a fault if the command
/// would never act.
template <class Message, class Add, class Hold>
Faults Commands::start(Faults faults, const std::string& topic, const CommandTaken& input,
                       const Message& command, Add add, Hold hold) {
  const double now = simulation_->time();
  const double start = command.start.isZero() ? now : input.start;
  const double duration = command.duration, end = duration > 0 ? start + duration : heldUntil(start);
  if (!(start - now <= farthestStart)) {
    faults.push_back(
        {topic + "/start", "0 for now, or the node's time, at most a day ahead",
         std::isfinite(start) ? toText(start - now) + " s ahead" : "a time before /clock has begun"});
  } else if (!(std::isfinite(duration) && duration >= 0 && (duration == 0 || end > start))) {
    faults.push_back(
        {topic + "/duration", "0, or a finite number of s that its start resolves", toText(duration)});
  } else if (!(end > std::max(start, now)) || (start < now && end - now < stampResolution)) {
    faults.push_back({topic + "/start", "a command that has not expired",
                      toText(now - start) + " s ago, for " + toText(end - start) + " s"});
  }
  if (!faults.empty()) return faults;
  if (!(duration > 0 ? add(duration, start) : hold(end, start))) {
    return {{topic, "at most " + std::to_string(capacity) + " timed or waiting commands", "one more"}};
  }
  taken_[input.kind] = now;
  return {};
}

Faults Commands::applyTorque(const CommandTaken& input) {
  const JointTorque& command = input.joint_torque.at(0);
  Faults faults;
  const int joint = find(faults, "joint_torque/joint", "joint", command.joint, joints_, &links_);
  if (joint >= 0 && isDriven_[index(joint)]) {
    faults.push_back({"joint_torque/joint", "a joint that is not driven", quoted(command.joint)});
  }
  checkFactor(faults, "joint_torque/torque", "N m", command.torque);
  return start(
      faults, "joint_torque", input, command,
      [&](double duration, double at) { return simulation_->addTorque(joint, command.torque, duration, at); },
      [&](double until, double at) { return simulation_->holdTorque(joint, command.torque, until, at); });
}

Faults Commands::applyForce(const CommandTaken& input) {
  const LinkForce& command = input.link_force.at(0);
  Faults faults;
  const int link = find(faults, "link_force/link", "link", command.link, links_, &joints_);
  checkFactor(faults, "link_force/point/x", "m", command.point.x);
  checkFactor(faults, "link_force/point/y", "m", command.point.y);
  checkZero(faults, "link_force/point/z", command.point.z);
  checkFactor(faults, "link_force/force/x", "N", command.force.x);
  checkFactor(faults, "link_force/force/y", "N", command.force.y);
  checkZero(faults, "link_force/force/z", command.force.z);
  checkFactor(faults, "link_force/moment", "N m", command.moment);
  const Vec2d point{command.point.x, command.point.y}, force{command.force.x, command.force.y};
  return start(
      faults, "link_force", input, command,
      [&](double duration, double at) {
        return simulation_->addForce(link, point, force, command.moment, duration, at);
      },
      [&](double until, double at) {
        return simulation_->holdForce(link, point, force, command.moment, until, at);
      });
}

Faults Commands::applyTrajectory(const CommandTaken& input) {
  const JointTrajectory& message = input.joint_trajectory.at(0);
  const double start = message.header.stamp.isZero() ? simulation_->time() : input.start;
  Faults faults;
  std::vector<Drive> laws = lawsOf(message, start, *simulation_, joints_, faults);
  if (!faults.empty()) return faults;
  for (Drive& drive : laws) simulation_->follow(drive.joint, std::move(drive.law));
  taken_[input.kind] = simulation_->time();
  return {};
}

Faults Commands::applyBaseTrajectory(const CommandTaken& input) {
  const MultiDOFJointTrajectory& message = input.base_trajectory.at(0);
  const double start = message.header.stamp.isZero() ? simulation_->time() : input.start;
  Faults faults;
  BaseLaws laws = lawsOf(message, start, *simulation_, faults);
  if (!faults.empty()) return faults;
  simulation_->followBase(std::move(laws));
  taken_[input.kind] = simulation_->time();
  return {};
}

/// The ticks of the step follow.
Faults Commands::applyStep(const CommandTaken& input) {
  Faults faults = faultsOf(input, true);
  if (!faults.empty()) return faults;
  if (!input.base_pose.empty()) {
    simulation_->followBase(baseLawsOf(input));
    taken_[CommandTaken::BASE_TRAJECTORY] = simulation_->time();
  }
  if (!input.joint_torques.empty()) hold(input.joint_torques);
  // If the state of a reset or ~settle has not been published, it belongs to the tick before.
  if (ticks_.next == ticks_.set) --ticks_.set, --ticks_.origin;
  return {};
}

/// The motion of the base to the end of the step.
BaseLaws Commands::baseLawsOf(const CommandTaken& step) const {
  const long long first = ticks_.next + (ticks_.next == ticks_.set ? 1 : 0);
  const double end = ticks_.sceneTime(first + static_cast<long long>(step.n) - 1);
  return lawsTo(step.base_pose[0], step.base_twist[0], end, *simulation_);
}

void Commands::hold(const std::vector<double>& torques) {
  const double until = heldUntil(simulation_->time());
  for (std::size_t i = 0; i < torques.size(); ++i) {
    if (!isDriven_[i]) simulation_->holdTorque(static_cast<int>(i), torques[i], until);
  }
  taken_[CommandTaken::JOINT_TORQUES] = simulation_->time();
}

double Commands::heldUntil(double start) const {
  const double timeout = simulation_->scene().commandTimeout;
  return timeout > 0 ? start + timeout : std::numeric_limits<double>::infinity();
}

Faults Commands::faultsOf(const CommandTaken& step, bool isRecorded) const {
  Faults faults;
  if (!step.joint_torques.empty()) faults = faultsOf(step.joint_torques, "torques");
  const std::size_t joints = simulation_->q().size();
  const std::size_t most = std::min(mostSteps, std::max<std::size_t>(1, mostStepValues / joints));
  // Recordings of earlier versions have no n, and no pose.
  if ((step.n < 1 && !(isRecorded && step.base_pose.empty())) || step.n > most) {
    faults.push_back({"n", "from 1 to " + std::to_string(most) + " ticks", std::to_string(step.n)});
  }
  checkBase(step.base_pose, step.base_twist, *simulation_, faults);
  if (!faults.empty() || step.base_pose.empty()) return faults;
  const auto [x, y, angle] = baseLawsOf(step);
  constexpr double farthest = 1e9;  // rad, as MotionLaw::moderate() says
  const bool isModerate = x.isModerate() && y.isModerate() && angle.isModerate();
  if (!isModerate || std::abs(step.base_pose[0].theta) > farthest) {
    faults.push_back({"base_pose", MotionLaw::moderate("m or rad"), "a faster motion"});
  }
  return faults;
}

Faults Commands::faultsOf(const std::vector<double>& torques, const std::string& path) const {
  Faults faults;
  checkValues(faults, path, "torques", "N m", torques, simulation_->q().size(), checkFactor);
  for (std::size_t i = 0; i < std::min(torques.size(), isDriven_.size()); ++i) {
    if (!isDriven_[i] || torques[i] == 0) continue;
    faults.push_back({path + "[" + std::to_string(i) + "]", "0 N m in a driven joint", toText(torques[i])});
  }
  if (!(heldUntil(simulation_->time()) > simulation_->time())) {
    faults.push_back({"command_timeout", "a timeout that the simulation time can resolve",
                      toText(simulation_->scene().commandTimeout)});
  }
  return faults;
}

void Commands::describe(SimStatus& status) const {
  const auto age = [&](std::uint8_t kind) {
    const auto taken = taken_.find(kind);
    return taken == taken_.end() ? -1 : simulation_->time() - taken->second;
  };
  status.joint_torques_age = age(CommandTaken::JOINT_TORQUES);
  status.joint_torque_age = age(CommandTaken::JOINT_TORQUE);
  status.link_force_age = age(CommandTaken::LINK_FORCE);
  status.joint_trajectory_age = age(CommandTaken::JOINT_TRAJECTORY);
  status.base_trajectory_age = age(CommandTaken::BASE_TRAJECTORY);
  status.rejected_commands = rejected_;
  status.last_rejection = lastRejection_;
}

}  // namespace planar_chain
