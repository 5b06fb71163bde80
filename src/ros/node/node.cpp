#include "ros/node/node.h"

#include <ros/console.h>
#include <ros/this_node.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "effects/effect_kind.h"
#include "ode/methods.h"
#include "reading/section.h"
#include "ros/view/urdf.h"

namespace planar_chain {

namespace {

using Steady = std::chrono::steady_clock;

constexpr double queueSeconds = 2;      // of messages, kept for a slow subscriber
constexpr long long fewTicks = 4;       // in a burst that catches up,
constexpr long long catchUpShare = 50;  // or the missing ticks divided by this if more,
constexpr double catchUpTime = 0.05;    // s of wall time at most
constexpr double factorSeconds = 5;     // over which the real-time factor is measured
constexpr double warningPeriod = 5;     // s
constexpr double largestLag = 0.5;      // s, without a warning on /diagnostics
constexpr double longestWait = 0.1;     // s, to notice a shutdown or a halted clock

constexpr auto servePeriod = std::chrono::milliseconds(100);  // during a tick

std::uint32_t queueFor(double rate) {
  return static_cast<std::uint32_t>(std::max(10.0, std::ceil(queueSeconds * rate)));
}

/// When the present tick serves next. Simulation::advanceTo polls a plain function, which carries no state.
struct {
  bool (*keepGoing)();
  Steady::time_point end;
} part;

bool keepGoingInPart() {
  return part.keepGoing() && Steady::now() < part.end;
}

/// True also means that the scene publishes the topic.
bool hasSubscribers(const ros::Publisher& topic) {
  return topic.getNumSubscribers() > 0;
}

// ---- The log at the start ----------------------------------------------------------------------

/// "nothing" without items.
std::string listed(const std::vector<std::string>& items) {
  return items.empty() ? "nothing" : inCommas(items);
}

/// What the scene runs, and what it leaves out.
std::string whatRuns(const Simulation& simulation) {
  const Scene& scene = simulation.scene();
  SceneWords words;
  (scene.chain.gravity() == Vec2d{} ? words.leftOut : words.runs).push_back("gravity");
  for (const EffectKind* kind : effectKinds()) kind->summarize(scene, words);
  words.runs.push_back("energy guard");
  words.runs.push_back(scene.commandTimeout > 0
                           ? "commands that lapse after " + toText(scene.commandTimeout) + " s"
                           : "commands that hold until replaced");

  const IntegratorSettings& integrator = scene.integrator;
  const bool hasFixedStep = ode::hasFixedStep(integrator.method);
  std::ostringstream line;
  line << scene.chain.size() << (scene.chain.size() == 1 ? " link (" : " links (") << simulation.recursion()
       << ") by " << integrator.method << (hasFixedStep ? ", step " : ", tolerance ")
       << (hasFixedStep ? integrator.step : integrator.tolerance) << "; runs: " << listed(words.runs)
       << "; left out: " << listed(words.leftOut);
  return line.str();
}

/// Which topics are published, and which are disabled.
std::string whatIsPublished(const PublishSettings& settings, const Frames& frames) {
  std::ostringstream line;
  line << "publishes on demand: joint_states";
  if (settings.linkStates) line << " and link_states";
  line << " at " << settings.rate << " Hz, ";
  if (settings.tf) line << "tf at " << settings.tfRate << " Hz below " << frames.base << ", ";
  line << "status at " << settings.statusRate << " Hz, views at " << settings.tfRate << " Hz";

  std::vector<std::string> disabled;
  if (!settings.linkStates) disabled.push_back("link_states");
  if (!settings.tf) disabled.push_back("tf");
  if (!disabled.empty()) line << "; disabled: " << inCommas(disabled);
  return line.str();
}

}  // namespace

Node::Node(const Scene& scene)
    : settings_(scene.publish),
      frames_(framesOf(scene, ros::this_node::getNamespace())),
      simulation_(scene, CommandTopics::capacity),
      clock_(makeClock(scene)),
      log_(inner_,
           [this] {
             return CommandLog::Instant{next_, simulation_.time()};
           }),
      commands_(simulation_, [this](ros::Time stamp) { return sceneTimeOf(stamp); }),
      messages_(scene, frames_),
      views_(inner_, scene, frames_),
      pace_(settings_.rate),
      next_(clock_->firstTick()),
      factor_(static_cast<std::size_t>(1 + std::ceil(factorSeconds * settings_.statusRate))),
      statuses_(1 / settings_.statusRate),
      warnings_(warningPeriod),
      clockTimes_(longestWait),
      diagnoses_(1) {
  // Advertise what the scene publishes.
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
  status_.header.frame_id = frames_.base;

  // Subscribe to commands, on a queue of their own.
  ros::NodeHandle commandsHandle("~");
  commandsHandle.setCallbackQueue(&commandQueue_);
  commands_.listen(commandsHandle, log_);
  advertiseServices();
  diagnostics_.setHardwareID("none");
  diagnostics_.add("simulation", this, &Node::diagnose);

  ROS_INFO("%s", whatRuns(simulation_).c_str());
  ROS_INFO("%s; time: %s", whatIsPublished(settings_, frames_).c_str(), clock_->name().c_str());
}

// ---- The run -----------------------------------------------------------------------------------

void Node::run(bool (*keepGoing)()) {
  keepGoing_ = keepGoing;
  master_.emplace(std::vector{ros::this_node::getName(), outer_.resolveName("robot_description"),
                              std::string("/use_sim_time")});
  clock_->begin(next_);
  while (keepGoing_()) {
    const double wait = serve();
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(std::clamp(wait, 0.0, longestWait)));
    commandQueue_.callAvailable();
  }
}

/// Runs due ticks and publishes the health. Returns the wall time until the next of these, s.
double Node::serve() {
  const double now = elapsed();
  const auto isRunning = [this] { return !paused_ && simulation_.fault().empty(); };
  if (isRunning() && now >= resting_) runDueTicks(now);
  publishHealth(now);
  const double untilStatus = statuses_.next() - now;
  if (!isRunning()) return untilStatus;
  return std::min(untilStatus, std::max(clock_->untilDue(next_), resting_ - now));
}

/// Publishes the status, the diagnostics and the time, each if it is due.
void Node::publishHealth(double now) {
  if (statuses_.isDue(now)) publishStatus(now);
  if (diagnoses_.isDue(now)) publishDiagnostics();
  if (clockTimes_.isDue(now)) clock_->publishAgain();
}

void Node::runDueTicks(double now) {
  // Find the last tick that is due.
  const double dropped = clock_->dropped();
  const long long due = clock_->due(next_);
  if (clock_->dropped() > dropped && warnings_.isDue(now)) {
    ROS_WARN("simulation time cannot keep up with %s at %g Hz: dropped another %.3f s",
             clock_->name().c_str(), settings_.rate, clock_->dropped() - dropped);
  }

  // Catch up in bursts: more ticks at once would overrun the queues of subscribers (rosbag keeps 100 messages
  // of a topic), and commands are served in between.
  const double pause = clock_->catchUpPause();
  const long long burst = pause > 0 ? std::max(fewTicks, (due - next_) / catchUpShare) : due - next_ + 1;
  const long long last = std::min(due, next_ + burst - 1);
  while (next_ <= last && elapsed() - now <= catchUpTime && tick()) {
  }
  if (next_ > due) return;
  ++overruns_;
  resting_ = now + pause;
}

/// Returns false if the integration fails, the tick is aborted, or the node ends. Then publishes no state.
bool Node::tick() {
  const double began = elapsed();
  part = {keepGoing_, Steady::now() + servePeriod};
  while (!simulation_.advanceTo(sceneTime(next_), keepGoingInPart)) {
    if (!simulation_.fault().empty()) {
      ROS_ERROR("%s", simulation_.fault().c_str());
      publishStatus(elapsed());
      publishDiagnostics();
      return false;
    }
    if (!keepGoing_() || !serveDuringTick(began)) return false;
    part.end = Steady::now() + servePeriod;
  }
  publishState();
  ++next_;
  return true;
}

/// Serves what cannot wait for the end of a tick that began at `began`. Returns false if ~reset aborted it.
bool Node::serveDuringTick(double began) {
  const long long resets = resets_;
  const double now = elapsed();
  if (now - began > warningPeriod && warnings_.isDue(now)) {
    ROS_WARN("a tick from %.9g to %.9g s is at %.9g s after %.0f s of wall time; commands wait for its end",
             sceneTime(next_ - 1), sceneTime(next_), simulation_.time(), now - began);
  }
  publishHealth(now);
  inTick_ = true;
  ros::getGlobalCallbackQueue()->callAvailable();
  inTick_ = false;
  return resets == resets_;
}

// ---- What is published -------------------------------------------------------------------------

void Node::publishState() {
  clock_->publish(next_);
  const ros::Time stamp = clock_->stampOf(next_);
  if (staticTf_ && next_ == clock_->firstTick()) {
    staticTf_->sendTransform(Messages::baseInWorld(frames_, stamp));
  }
  if (hasSubscribers(jointStatesOut_)) jointStatesOut_.publish(messages_.jointStates(simulation_, stamp));
  if (pace_.falls(next_, settings_.tfRate)) {
    if (hasSubscribers(tfOut_)) tfOut_.publish(messages_.transforms(simulation_, stamp));
    views_.publish(simulation_, stamp);
  }
  if (hasSubscribers(linkStatesOut_)) linkStatesOut_.publish(messages_.linkStates(simulation_, stamp));
}

void Node::publishStatus(double now) {
  // Sample the real-time factor even without subscribers, for a later one.
  status_.real_time_factor = factor_.sample(simTime(), now);
  status_.header.stamp = clock_->now();
  if (status_.header.stamp.isZero() || !hasSubscribers(statusOut_)) return;
  describe(simulation_, status_);
  updateStatus();
  statusOut_.publish(status_);
}

void Node::publishDiagnostics() {
  updateStatus();
  // The updater's own period is simulation time, so force it. A message must not have the stamp 0.
  if (!ros::Time::now().isZero()) diagnostics_.force_update();
}

void Node::diagnose(diagnostic_updater::DiagnosticStatusWrapper& out) {
  using diagnostic_msgs::DiagnosticStatus;
  const std::string clockFault = master_->clockFault();
  if (!status_.fault.empty()) {
    out.summary(DiagnosticStatus::ERROR, status_.fault);
  } else if (!clockFault.empty()) {
    out.summary(DiagnosticStatus::WARN, clockFault);
  } else if (status_.lag > largestLag) {
    out.summaryf(DiagnosticStatus::WARN, "%.3f s behind %s", status_.lag, clock_->name().c_str());
  } else {
    out.summary(DiagnosticStatus::OK, status_.standstill.empty() ? "running" : status_.standstill);
  }
  out.add("follows", clock_->name());
  out.add("sim_time", status_.sim_time);
  out.add("real_time_factor", status_.real_time_factor);
  out.add("lag", status_.lag);
  out.add("overruns", status_.overruns);
  out.add("rejected_commands", status_.rejected_commands);
  out.add("last_rejection", status_.last_rejection);
}

/// Sets the fields of the status that the node determines.
void Node::updateStatus() {
  status_.sim_time = simTime();
  if (next_ > clock_->firstTick()) {
    status_.tick = static_cast<std::uint64_t>(next_ - 1);
    status_.tick_stamp = clock_->stampOf(next_ - 1);
  }
  status_.paused = paused_;
  status_.fault = simulation_.fault();
  status_.standstill = !status_.fault.empty() ? standstillByFault : paused_ ? "paused" : clock_->haltedBy();
  status_.overruns = overruns_;
  status_.lag = status_.standstill.empty() ? std::max(0.0, clock_->lag(next_ - 1)) : 0;
  commands_.describe(status_);
}

// ---- Time --------------------------------------------------------------------------------------

/// Returns the scene time of a stamp, s. A tick's stamp gives exactly the tick's time. Any other time is
/// measured from the origin of the stamps.
double Node::sceneTimeOf(ros::Time stamp) const {
  if (!clock_->hasBegun()) return std::numeric_limits<double>::infinity();
  const auto ns = static_cast<std::int64_t>(stamp.toNSec());
  const long long from = std::max(clock_->stampOrigin(), origin_);
  const double since = static_cast<double>(ns - clock_->ns(from)) / 1e9;
  const long long tick = from + std::llround(since * settings_.rate);
  return clock_->ns(tick) == ns ? sceneTime(tick) : sceneTime(from) + since;
}

void Node::restartClock() {
  resting_ = 0;
  clock_->begin(next_);
}

double Node::elapsed() const {
  return std::chrono::duration<double>(Steady::now() - start_).count();
}

}  // namespace planar_chain
