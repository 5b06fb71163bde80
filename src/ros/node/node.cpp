#include "ros/node/node.h"

#include <ros/callback_queue.h>
#include <ros/console.h>
#include <ros/init.h>
#include <ros/this_node.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "ros/messages/checks.h"
#include "ros/node/summary.h"
#include "ros/view/urdf.h"

namespace planar_chain {

namespace {

using Steady = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr double queueSeconds = 2;      // what a publisher keeps for a slow subscriber
constexpr long long fewTicks = 4;       // done at a stretch when behind,
constexpr long long catchUpShare = 50;  // or this part of what is missing,
constexpr double catchUpTime = 0.05;    // s of wall time at most
constexpr double factorSeconds = 5;     // over which the real-time factor is measured
constexpr double warningPeriod = 5;     // s
constexpr double longestWait = 0.1;     // s, so that shutdowns and standstills are noticed

constexpr auto longestPart = std::chrono::milliseconds(100);  // of a tick, between two looks around

constexpr std::uint32_t mostSteps = 10000;       // of one call,
constexpr std::size_t mostStepValues = 1000000;  // and joints × ticks of its answer

std::uint32_t queueFor(double rate) {
  return static_cast<std::uint32_t>(std::max(10.0, std::ceil(queueSeconds * rate)));
}

/// A part of a tick: Simulation::advanceTo asks a plain function whether to go on.
struct {
  bool (*nodeGoesOn)();
  Steady::time_point end;
} part;

bool partGoesOn() {
  return part.nodeGoesOn() && Steady::now() < part.end;
}

constexpr const char* longTick = "a tick is under way that takes long; ~reset gives it up";

bool isHeard(const ros::Publisher& topic) {
  return topic.getNumSubscribers() > 0;  // none where the scene does not want it advertised
}

}  // namespace

Node::Node(const Scene& scene)
    : settings_(scene.publish),
      frames_(framesOf(scene, ros::this_node::getNamespace())),
      simulation_(scene, Commands::capacity),
      clock_(makeClock(scene)),
      log_(inner_,
           [this] {
             return CommandLog::Instant{next_, simulation_.time()};
           }),
      commands_(simulation_, [this](ros::Time stamp) { return sceneTimeOf(stamp); }),
      queries_(inner_, simulation_),
      messages_(scene, frames_),
      views_(inner_, scene, frames_),
      diagnostics_(status_, clock_->name()),
      pace_(settings_.rate),
      next_(clock_->firstTick()),
      factor_(1 + static_cast<int>(std::ceil(factorSeconds * settings_.statusRate))),
      statuses_(1 / settings_.statusRate),
      warnings_(warningPeriod),
      reminders_(longestWait),
      diagnoses_(1) {
  outer_.setParam("robot_description", urdfOf(scene, frames_));

  jointStatesOut_ = outer_.advertise<sensor_msgs::JointState>("joint_states", queueFor(settings_.rate));
  statusOut_ = inner_.advertise<SimStatus>("status", queueFor(settings_.statusRate));
  if (settings_.linkStates) {
    linkStatesOut_ = inner_.advertise<LinkStates>("link_states", queueFor(settings_.rate));
  }
  if (settings_.tf) {
    tfOut_ = outer_.advertise<tf2_msgs::TFMessage>("/tf", queueFor(settings_.tfRate));
    staticTf_.emplace();
  }
  ros::NodeHandle commandsHandle("~");
  commandsHandle.setCallbackQueue(&commandQueue_);
  commands_.listen(commandsHandle, log_);
  status_.header.frame_id = frames_.base;
  ROS_INFO("%s", whatRuns(simulation_).c_str());
  ROS_INFO("%s; time: %s", whatIsPublished(settings_, frames_).c_str(), clock_->name().c_str());
}

// ---- The run -----------------------------------------------------------------------------------

void Node::run(bool (*goesOn)()) {
  goesOn_ = goesOn;
  master_.emplace(std::vector{ros::this_node::getName(), outer_.resolveName("robot_description"),
                              std::string("/use_sim_time")});
  clock_->begin(next_);
  while (goesOn_()) {
    const double wait = serve();
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(std::clamp(wait, 0.0, longestWait)));
    commandQueue_.callAvailable();
  }
}

/// @returns how long there is nothing to do, s of wall time.
double Node::serve() {
  const double now = elapsed();
  const auto goes = [this] { return !paused_ && simulation_.fault().empty(); };
  if (goes() && now >= breathUntil_) serveTicks(now);
  tellOfItself(now);
  const double untilStatus = statuses_.next() - now;
  return goes() ? std::min(untilStatus, std::max(clock_->untilDue(next_), breathUntil_ - now)) : untilStatus;
}

void Node::tellOfItself(double now) {
  if (statuses_.falls(now)) publishStatus(now);
  if (diagnoses_.falls(now)) publishDiagnostics();
  if (reminders_.falls(now)) clock_->tellAgain();
}

void Node::serveTicks(double now) {
  const double givenUp = clock_->givenUp();
  const long long due = clock_->due(next_);
  if (clock_->givenUp() > givenUp && warnings_.falls(now)) {
    ROS_WARN("sim time cannot follow %s at %g Hz: another %.3f s are given up", clock_->name().c_str(),
             settings_.rate, clock_->givenUp() - givenUp);
  }

  // Catches up a little at a time: a flood would overrun the queues of those who listen (rosbag keeps
  // 100 messages a topic), and commands are to be served in between.
  const double breather = clock_->breather();
  const long long stretch = breather > 0 ? std::max(fewTicks, (due - next_) / catchUpShare) : due - next_ + 1;
  const long long last = std::min(due, next_ + stretch - 1);
  while (next_ <= last && elapsed() - now <= catchUpTime && tick()) {
  }
  if (next_ > due) return;
  ++overruns_;
  breathUntil_ = now + breather;
}

/// @returns false when the integration failed, the tick was given up, or the node ends: nothing is published
/// then.
bool Node::tick() {
  const double began = elapsed();
  part = {goesOn_, Steady::now() + longestPart};
  while (!simulation_.advanceTo(sceneTime(next_), partGoesOn)) {
    if (!simulation_.fault().empty()) {
      ROS_ERROR("%s", simulation_.fault().c_str());
      publishStatus(elapsed());
      publishDiagnostics();
      return false;
    }
    if (!goesOn_() || !bear(began)) return false;
    part.end = Steady::now() + longestPart;
  }
  publishState();
  ++next_;
  return true;
}

/// What cannot wait for the end of a tick that began then. @returns false when the tick was given up.
bool Node::bear(double began) {
  const long long resets = resets_;
  const double now = elapsed();
  if (now - began > warningPeriod && warnings_.falls(now)) {
    ROS_WARN(
        "a tick takes long: after %.0f s it has come to %.9g s, on its way from %.9g to %.9g s; commands "
        "wait",
        now - began, simulation_.time(), sceneTime(next_ - 1), sceneTime(next_));
  }
  tellOfItself(now);
  inTick_ = true;
  ros::getGlobalCallbackQueue()->callAvailable();
  inTick_ = false;
  return resets == resets_;
}

void Node::publishState() {
  clock_->tell(next_);
  const ros::Time stamp = clock_->stampOf(next_);
  if (staticTf_ && next_ == clock_->firstTick()) {
    staticTf_->sendTransform(Messages::baseInWorld(frames_, stamp));
  }
  if (isHeard(jointStatesOut_)) jointStatesOut_.publish(messages_.jointStates(simulation_, stamp));
  if (pace_.falls(next_, settings_.tfRate)) {
    if (isHeard(tfOut_)) tfOut_.publish(messages_.transforms(simulation_, stamp));
    views_.publish(simulation_, stamp);
  }
  if (isHeard(linkStatesOut_)) linkStatesOut_.publish(messages_.linkStates(simulation_, stamp));
}

void Node::publishStatus(double now) {
  // Sampled whoever listens: it looks back to before the listener came.
  status_.real_time_factor = factor_.sample(simTime(), now);
  status_.header.stamp = clock_->now();
  if (status_.header.stamp.isZero() || !isHeard(statusOut_)) return;
  describe(simulation_, status_);
  lookAtNode();
  statusOut_.publish(status_);
}

/// What the status says of the node itself.
void Node::lookAtNode() {
  status_.sim_time = simTime();
  if (next_ > clock_->firstTick()) {
    status_.tick = static_cast<std::uint64_t>(next_ - 1);
    status_.tick_stamp = clock_->stampOf(next_ - 1);
  }
  status_.paused = paused_;
  status_.fault = simulation_.fault();
  status_.standstill = !status_.fault.empty() ? standstillByFault : paused_ ? "paused" : clock_->standstill();
  status_.overruns = overruns_;
  status_.lag = status_.standstill.empty() ? std::max(0.0, clock_->lag(next_ - 1)) : 0;
  commands_.describe(status_);
}

void Node::publishDiagnostics() {
  lookAtNode();
  diagnostics_.publish(master_->faultOfClock());
}

// ---- What may be asked of it -------------------------------------------------------------------

void Node::goOn() {
  breathUntil_ = 0;
  clock_->begin(next_);
}

Node::Answer Node::pause() {
  if (paused_) return {true, "it was paused already"};
  paused_ = true;
  return {true, "paused"};
}

Node::Answer Node::resume() {
  if (!simulation_.fault().empty()) {
    return {false, simulation_.fault() + "; ~reset or ~set_state leads back"};
  }
  if (!paused_) return {true, "it was running already"};
  paused_ = false;
  goOn();
  return {true, "it goes on"};
}

Node::Answer Node::reset() {
  const bool hadFailed = !simulation_.fault().empty();
  if (inTick_) {
    commandQueue_.clear();
  } else {
    commandQueue_.callAvailable();
  }
  ++resets_;
  simulation_.reset();
  commands_.forget();
  log_.add(CommandTaken::RESET);
  origin_ = next_;
  if (hadFailed && !paused_) goOn();
  return {true, paused_ ? "back at the first state, paused" : "back at the first state"};
}

Node::Answer Node::clearCommands() {
  if (inTick_) return {false, longTick};
  commandQueue_.callAvailable();
  simulation_.clearCommands();
  log_.add(CommandTaken::CLEAR_COMMANDS);
  return {true, "no command is in force or waits"};
}

Node::Answer Node::setState(const std::vector<double>& q, const std::vector<double>& qd) {
  if (inTick_) return {false, longTick};
  std::vector<Fault> faults;
  checkValues(faults, "q", "angles", "rad", q, simulation_.q().size());
  checkValues(faults, "qd", "rates", "rad/s", qd, simulation_.qd().size());
  if (!faults.empty()) return {false, toString(faults)};
  commandQueue_.callAvailable();
  const bool hadFailed = !simulation_.fault().empty();
  try {
    simulation_.setState(q, qd);
  } catch (const std::invalid_argument& refusal) {
    return {false, refusal.what()};
  }
  log_.add(CommandTaken::SET_STATE, [&](CommandTaken& taken) {
    taken.q = q;
    taken.qd = qd;
  });
  if (hadFailed && !paused_) goOn();
  return {true, "the state is set"};
}

Node::Answer Node::step(const std::vector<double>& torques, std::uint32_t ticks,
                        std::vector<sensor_msgs::JointState>& states) {
  // As a whole or not at all.
  if (!simulation_.fault().empty()) {
    return {false, simulation_.fault() + "; ~reset or ~set_state leads back"};
  }
  if (inTick_) return {false, longTick};
  if (!clock_->hasBegun()) return {false, clock_->standstill()};
  commandQueue_.callAvailable();
  const std::size_t joints = simulation_.q().size();
  const auto most = std::min<std::size_t>(mostSteps, std::max<std::size_t>(1, mostStepValues / joints));
  std::vector<Fault> faults;
  if (!torques.empty()) faults = commands_.faultsOf(torques, "torques");
  if (ticks < 1 || ticks > most) {
    faults.push_back({"n", "from 1 to " + std::to_string(most) + " ticks", std::to_string(ticks)});
  }
  if (!faults.empty()) return {false, toString(faults)};

  const bool ran = !paused_;
  paused_ = true;
  if (!torques.empty()) commands_.hold(torques);
  log_.add(CommandTaken::STEP, [&](CommandTaken& taken) { taken.joint_torques = torques; });
  // Where the state of scene time 0 has not been shown, it is that of the tick before.
  if (next_ == origin_) --origin_;
  states.reserve(ticks);
  for (std::uint32_t k = 0; k < ticks; ++k) {
    if (!tick())
      return {false, !goesOn_()                    ? "the node ends"
                     : simulation_.fault().empty() ? "~reset gave the tick up"
                                                   : simulation_.fault()};
    states.push_back(messages_.jointStates(simulation_, clock_->stampOf(next_ - 1)));
  }
  return {true, ran ? "done; the run was paused, ~resume lets it go on" : "done; it is paused"};
}

// ---- Time --------------------------------------------------------------------------------------

/// The stamp of a tick is that tick's time to the bit; any other is so many ns from the last stamps'
/// beginning.
double Node::sceneTimeOf(ros::Time stamp) const {
  if (!clock_->hasBegun()) return std::numeric_limits<double>::infinity();
  const auto ns = static_cast<std::int64_t>(stamp.toNSec());
  const long long from = std::max(clock_->stampsBegan(), origin_);
  const double since = static_cast<double>(ns - clock_->ns(from)) / 1e9;
  const long long tick = from + std::llround(since * settings_.rate);
  return clock_->ns(tick) == ns ? sceneTime(tick) : sceneTime(from) + since;
}

double Node::elapsed() const {
  return Seconds(Steady::now() - start_).count();
}

}  // namespace planar_chain
