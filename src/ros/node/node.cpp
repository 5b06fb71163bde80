#include "ros/node/node.h"

#include <ros/console.h>
#include <ros/names.h>
#include <ros/this_node.h>
#include <ros/topic_manager.h>
#include <std_msgs/String.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "effects/effect_kind.h"
#include "ode/methods.h"
#include "reading/section.h"
#include "ros/view/drawing.h"

namespace planar_chain {

namespace {

constexpr long long fewTicks = 4;              // in a burst that catches up,
constexpr long long catchUpShare = 50;         // or the missing ticks divided by this if more,
constexpr double catchUpTime = 0.05;           // s of wall time at most
constexpr double factorSeconds = 5;            // over which the real-time factor is measured
constexpr double warningPeriod = 5;            // s
constexpr double meanShare = 0.05;             // of a tick in the mean load
constexpr double largestLag = 0.5;             // s, without a warning on /diagnostics and advice
constexpr double advicePeriod = 30;            // s
constexpr double diagnosticsPeriod = 1;        // s
constexpr double longestWait = 0.1;            // s, to notice a shutdown or a halted clock
constexpr double shortWait = 5e-3;             // s, while commands wait for the recorder
constexpr double longestWaitForRecorder = 15;  // s
constexpr double servePeriod = 0.1;            // s, during long ticks
constexpr int recordedAtOnce = 40;             // ticks, while a recorder listens,
constexpr double recordedRate = 2000;          // Hz of wall time, or twice the rate of ticks if that is more

constexpr char severalClocksFault[] =
    "/clock has several publishers. Time jumps between them. Stop all but one (rostopic info /clock lists "
    "them; rosnode cleanup removes dead ones)";

/// True if /use_sim_time is true and more than one node publishes /clock.
bool hasSeveralClocks() {
  return ros::TopicManager::instance()->getNumPublishers(ros::names::resolve("/clock")) > 1;
}

// ---- The log at the start ----------------------------------------------------------------------

/// The parts that the scene uses, and those that it leaves out.
std::string whatRuns(const Simulation& simulation) {
  const Scene& scene = simulation.scene();
  SceneWords words = wordsOf(scene);
  words.runs.push_back("energy guard");
  words.runs.push_back(scene.commandTimeout > 0
                           ? "commands that lapse after " + toText(scene.commandTimeout) + " s"
                           : "commands that hold until replaced");

  const IntegratorSettings& integrator = scene.integrator;
  const bool hasFixedStep = ode::hasFixedStep(integrator.method);
  std::ostringstream line;
  line << scene.chain.size() << (scene.chain.size() == 1 ? " link (" : " links (") << simulation.recursion()
       << ") by " << integrator.method << (hasFixedStep ? ", step " : ", tolerance ")
       << (hasFixedStep ? integrator.step : integrator.tolerance);
  if (integrator.rateTolerance && !hasFixedStep) line << ", rate tolerance " << *integrator.rateTolerance;
  if (integrator.loosestTolerance && !hasFixedStep) {
    line << ", yields to " << *integrator.loosestTolerance << " when late";
  }
  line << "; runs: " << inCommas(words.runs);
  if (!words.leftOut.empty()) line << "; not in this scene, at no cost: " << inCommas(words.leftOut);
  return line.str();
}

/// The time at which the drives and the base reach the end of their motion, s; infinite if there is none.
double endOfMotion(const Scene& scene) {
  std::vector<const MotionLaw*> laws;
  for (const Drive& drive : scene.drives) laws.push_back(&drive.law);
  if (scene.base) laws.insert(laws.end(), {&scene.base->x, &scene.base->y, &scene.base->angle});
  double end = 0;
  for (const MotionLaw* law : laws) {
    if (law->amplitude() != 0) return std::numeric_limits<double>::infinity();
    end = std::fmax(end, law->pieces().back().start);
  }
  return end > 0 ? end : std::numeric_limits<double>::infinity();
}

/// Which topics are published, and which are disabled.
std::string whatIsPublished(const PublishSettings& settings, const Frames& frames) {
  std::ostringstream line, disabled;
  line << "publishes on demand: joint_states";
  (settings.linkStates ? line << " and " : disabled << "; disabled: ") << "link_states";
  line << " at " << settings.rate << " Hz, ";
  if (settings.tf) line << "tf at " << settings.tfRate << " Hz below " << frames.base << ", ";
  line << "status at " << settings.statusRate << " Hz, views at " << settings.tfRate << " Hz";
  if (!settings.tf) disabled << (settings.linkStates ? "; disabled: tf" : ", tf");
  return line.str() + disabled.str();
}

}  // namespace

Node::Node(const Scene& scene, std::function<std::optional<Scene>()> changedScene)
    : settings_(scene.publish),
      changedScene_(std::move(changedScene)),
      clock_(makeClock(scene)),
      ticks_{settings_.rate, clock_->firstTick()},
      commands_(ticks_, [this](ros::Time stamp) { return sceneTimeOf(stamp); }),
      times_(static_cast<std::size_t>(2 + std::ceil(factorSeconds * settings_.statusRate))),
      warnings_(warningPeriod),
      advice_(advicePeriod),
      clockWarnings_(advicePeriod),
      rests_(recordedAtOnce, recordedAtOnce / std::max(recordedRate, 2 * settings_.rate)) {
  // Advertise the topics of the scene.
  sceneOut_ = inner_.advertise<std_msgs::String>("scene", 1, true);
  load(scene);
  statusOut_ = inner_.advertise<SimStatus>("status", queueFor(settings_.statusRate));
  status_.header.frame_id = messages_->frames().base;

  // Subscribe to commands, on a queue of their own.
  commands_.listen(ros::NodeHandle("~"));
  advertiseServices();
  diagnostics_.setHardwareID("none");
  diagnostics_.add("simulation", this, &Node::diagnose);
  ROS_INFO("%s; time: %s", whatIsPublished(settings_, messages_->frames()).c_str(), clock_->name().c_str());
}

/// Makes what depends on the scene alone. Its publish settings are those of the start.
/// @throws Refused for frame names that collide; then nothing has changed
void Node::load(const Scene& scene) {
  auto simulation = std::make_unique<Simulation>(scene, Commands::capacity, true);
  messages_ = std::make_unique<Messages>(*simulation, ros::this_node::getName(), true);
  simulation_ = std::move(simulation);
  commands_.moveTo(*simulation_);
  allowYielding();
  status_.method.clear();
  auto before = std::exchange(statesOut_, {});
  messages_->forEach([&](const Topic& topic, auto make) {
    if (topic.isLatched) return;
    using Message = std::decay_t<decltype(*make(ros::Time()))>;
    ros::Publisher& out = statesOut_[topic.name] = before[topic.name];
    if (!out) out = outer_.advertise<Message>(topic.name, topic.queue);
  });
  std_msgs::String text;
  text.data = scene.text;
  sceneOut_.publish(text);
  messages_->measurements().forEachTopic([&](const std::string& topic, double rate, const auto& example) {
    ros::Publisher& out = statesOut_[topic] = before[topic];
    const std::uint32_t queue = queueFor(std::max(rate, settings_.rate));
    if (!out) out = outer_.advertise<std::decay_t<decltype(example)>>(topic, queue);
  });
  outer_.setParam("robot_description", urdfOf(scene, messages_->frames(), messages_->frames().every == 1));
  ROS_INFO("%s", whatRuns(*simulation_).c_str());
  motionEnd_ = endOfMotion(scene);
  for (const Note& note : scene.notes) ROS_WARN("%s", toString(note).c_str());
}

/// As at the start.
void Node::allowYielding() {
  const IntegratorSettings& settings = simulation_->scene().integrator;
  toleranceControl_.reset();
  if (settings.loosestTolerance && !ode::hasFixedStep(settings.method)) {
    toleranceControl_.emplace(settings.tolerance, *settings.loosestTolerance);
  }
  load_ = stepsOfTick_ = stepsBefore_ = 0;
}

// ---- The run -----------------------------------------------------------------------------------

void Node::waitForRecorder(bool (*keepGoing)()) {
  const auto isRecorded = [&] {
    return commands_.areRecorded() && hasSubscribers(statusOut_) &&
           std::all_of(statesOut_.begin(), statesOut_.end(),
                       [](const auto& topic) { return hasSubscribers(topic.second); });
  };
  isWaiting_ = true;
  const double end = steadyTime() + longestWaitForRecorder;
  while (keepGoing() && !isRecorded() && steadyTime() < end) {
    publishStatus();
    commands_.collect();
    ros::WallDuration(longestWait).sleep();
  }
  isWaiting_ = false;
  if (isRecorded() || !keepGoing()) return;
  ROS_WARN("no recorder has subscribed to every topic within %g s: the run starts without",
           longestWaitForRecorder);
}

void Node::run(bool (*keepGoing)()) {
  keepGoing_ = keepGoing;
  const auto every = [this](double period, auto action) {
    return outer_.createSteadyTimer(ros::WallDuration(period),
                                    [action](const ros::SteadyTimerEvent& /*now*/) { action(); });
  };
  const ros::SteadyTimer timers[] = {every(1 / settings_.statusRate, [this] { publishStatus(); }),
                                     every(diagnosticsPeriod, [this] { publishDiagnostics(); }),
                                     every(longestWait, [this] { clock_->publishAgain(); })};
  while (keepGoing_()) {
    const bool isHalted = paused_ || !simulation_->fault().empty();
    if (!isHalted && !isClockRunning_) {
      resting_ = 0;
      clock_->begin(ticks_.next);
    }
    isClockRunning_ = !isHalted;
    const double wait = isHalted ? longestWait : runDueTicks();
    if (paused_) showSetState();
    const double longest = commands_.haveWaiting() ? shortWait : longestWait;
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(std::clamp(wait, 0.0, longest)));
    commands_.serveAtItsPace();
  }
}

/// Runs some of the ticks that are due. Returns the wall time until the next, s.
double Node::runDueTicks() {
  began_ = served_ = steadyTime();
  if (began_ < resting_) return resting_ - began_;
  const long long due = clock_->due(ticks_.next);

  // Catch up in bursts: more ticks at once would overrun the queues of subscribers, and commands are served
  // in between.
  const double pause = clock_->catchUpPause();
  const long long late = due - ticks_.next;
  const long long burst = pause > 0 ? std::max(fewTicks, late / catchUpShare) : late + 1;
  const long long last = std::min(due, ticks_.next + burst - 1);
  while (ticks_.next <= last && steadyTime() - began_ <= catchUpTime) {
    restForRecorder();
    const double start = steadyTime();
    if (!tick()) return 0;
    controlTolerance(steadyTime() - start);
  }
  if (ticks_.next > due) return clock_->untilDue(ticks_.next);
  ++overruns_;
  resting_ = began_ + pause;
  return pause;
}

/// Call after a tick that took `work` s of wall time. Loosens the tolerance if ticks are late, and tightens
/// it if there is time. If ticks stay late, logs recommendations.
void Node::controlTolerance(double work) {
  const double period = clock_->catchUpPause();
  if (period <= 0) return;  // no clock to keep pace with, or of an unknown speed
  const double delay = -clock_->untilDue(ticks_.next);
  const auto steps = static_cast<double>(simulation_->statistics().steps);
  const double share = load_ > 0 ? meanShare : 1;
  load_ += share * (work / period - load_);
  stepsOfTick_ += share * (steps - std::exchange(stepsBefore_, steps) - stepsOfTick_);
  const double before = simulation_->tolerance();
  const double next = toleranceControl_ ? toleranceControl_->after(work / period, delay, period) : before;
  if (next != before) {
    CommandTaken input = inputOf(CommandTaken::TOLERANCE);
    input.tolerance = next;
    commands_.take(input);
    const double loosest = *simulation_->scene().integrator.loosestTolerance;
    ROS_LOG(next == loosest ? ros::console::levels::Warn : ros::console::levels::Info,
            ROSCONSOLE_DEFAULT_NAME, "at %.9g s the tolerance %s %g%s", simulation_->time(),
            next > before ? "yields to" : "comes back to", next,
            next == loosest ? ", the loosest that is allowed" : "");
  } else if (delay > largestLag && advice_.isDue()) {
    ROS_WARN("%s",
             adviceFor(simulation_->scene().integrator, next, load_, stepsOfTick_, period, settings_.rate)
                 .c_str());
  }
}

/// While paused, publishes the state after a reset or ~settle. Its stamp is as after a resume.
void Node::showSetState() {
  if (ticks_.next != ticks_.set || !clock_->hasBegun()) return;
  began_ = served_ = steadyTime();
  clock_->begin(ticks_.next);
  tick();
}

/// Returns false if the integration fails, the tick is aborted, or the node ends. Then publishes no state.
bool Node::tick() {
  const double before = simulation_->time();
  const auto isInTime = [this] { return keepGoing_() && steadyTime() < served_ + servePeriod; };
  while (!isInTime() || !simulation_->advanceTo(ticks_.sceneTime(ticks_.next), isInTime)) {
    if (!simulation_->fault().empty()) {
      ROS_ERROR("%s", simulation_->fault().c_str());
      publishStatus();
      publishDiagnostics();
      return false;
    }
    if (!keepGoing_() || !serveDuringTicks()) return false;
  }

  clock_->publish(ticks_.next);
  const ros::Time stamp = clock_->stampOf(ticks_.next);
  messages_->forEach([&](const Topic& topic, auto make) {
    if (!topic.isDue(ticks_, ticks_.next)) return;
    if (topic.isLatched) return staticTf_.sendTransform(messages_->staticTransforms(stamp).transforms);
    const ros::Publisher& out = statesOut_.at(topic.name);
    if (hasSubscribers(out)) out.publish(*make(stamp));
  });
  messages_->measurements().forEach(
      ticks_, ticks_.next, stamp,
      [&](const std::string& topic, const auto& message) { statesOut_.at(topic).publish(message); });
  ++ticks_.next;
  if (before < motionEnd_ && simulation_->time() >= motionEnd_) {
    ROS_INFO("the scene's motion has ended at %g s; rosservice call %s/reset repeats it", motionEnd_,
             ros::this_node::getName().c_str());
  }
  return true;
}

/// Serves what cannot wait for the end of long ticks. Returns false if ~reset aborted them.
bool Node::serveDuringTicks() {
  const long long resets = resets_;
  if (steadyTime() - began_ > warningPeriod && warnings_.isDue()) {
    ROS_WARN("ticks up to %.9g s are at %.9g s after %.0f s of wall time; commands wait for their end",
             ticks_.sceneTime(ticks_.next), simulation_->time(), steadyTime() - began_);
  }
  inTick_ = true;
  ros::getGlobalCallbackQueue()->callAvailable();
  commands_.collect();
  inTick_ = false;
  served_ = steadyTime();
  return resets == resets_;
}

// ---- What is published -------------------------------------------------------------------------

void Node::publishStatus() {
  // Sample the real-time factor even without subscribers, for a later one.
  sampleTimes();
  const double simulated = times_.back().first - times_.front().first;
  const double passed = times_.back().second - times_.front().second;
  status_.real_time_factor = passed > 0 ? simulated / passed : 0;
  status_.header.stamp = clock_->now();
  if (status_.header.stamp.isZero() || !hasSubscribers(statusOut_)) return;
  describe(*simulation_, status_);
  updateStatus();
  statusOut_.publish(status_);
}

void Node::publishDiagnostics() {
  updateStatus();
  commands_.warnOfRefusals();
  severalClocks_ = hasSeveralClocks();
  if (severalClocks_ && clockWarnings_.isDue()) ROS_WARN("%s", severalClocksFault);
  // The updater's own period is simulation time, so force it. Stamps must not be 0, and it adds to them.
  constexpr double latest = 4294967000;  // s: five minutes before ros::Time ends
  if (const double now = ros::Time::now().toSec(); now > 0 && now < latest) diagnostics_.force_update();
}

void Node::diagnose(diagnostic_updater::DiagnosticStatusWrapper& out) {
  using diagnostic_msgs::DiagnosticStatus;
  if (!status_.fault.empty()) {
    out.summary(DiagnosticStatus::ERROR, status_.fault);
  } else if (severalClocks_) {
    out.summary(DiagnosticStatus::WARN, severalClocksFault);
  } else if (std::exchange(jumpsTold_, clock_->jumps()) != clock_->jumps()) {
    out.summary(DiagnosticStatus::WARN, clock_->name() + " jumped; the stamps restarted at its time");
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
  out.add("clock_jumps", clock_->jumps());
  out.add("rejected_commands", status_.rejected_commands);
  out.add("last_rejection", status_.last_rejection);
}

/// Sets the fields of the status that the node determines.
void Node::updateStatus() {
  status_.sim_time = ticks_.simTime(simulation_->time());
  if (ticks_.next > ticks_.first) {
    status_.tick = static_cast<std::uint64_t>(ticks_.next - 1);
    status_.tick_stamp = clock_->stampOf(ticks_.next - 1);
  }
  status_.paused = paused_;
  status_.fault = simulation_->fault();
  status_.standstill = !status_.fault.empty() ? standstillByFault
                       : isWaiting_           ? "waiting for the recorder"
                       : paused_              ? "paused"
                                              : clock_->haltedBy();
  status_.overruns = overruns_ + clock_->drops();
  status_.clock_jumps = clock_->jumps();
  status_.lag = status_.standstill.empty() ? std::max(0.0, clock_->lag(ticks_.next - 1)) : 0;
  commands_.describe(status_);
}

// ---- Time --------------------------------------------------------------------------------------

/// Returns the scene time of a stamp, s. A tick's stamp gives exactly the tick's time. Any other time is
/// measured from the origin of the stamps.
double Node::sceneTimeOf(ros::Time stamp) const {
  if (!clock_->hasBegun()) return std::numeric_limits<double>::infinity();
  const auto ns = static_cast<std::int64_t>(stamp.toNSec());
  const long long from = std::max(clock_->stampOrigin(), ticks_.origin);
  const double since = static_cast<double>(ns - clock_->ns(from)) / 1e9;
  const long long tick = from + std::llround(since * settings_.rate);
  return clock_->ns(tick) == ns ? ticks_.sceneTime(tick) : ticks_.sceneTime(from) + since;
}

}  // namespace planar_chain
