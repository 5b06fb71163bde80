/// report_listen FILE SECONDS SCENE: measures how late the ticks of a running node arrive.
///
/// Writes FILE: a line "missing N", ticks that never came; "overruns N", as ~status counts them; then "late
/// S" for each tick: the time from its stamp, when it is due, to its arrival here; and "work S" for each tick
/// of the same scene computed here: the thread's time on the processor.

#include <planar_chain/SimStatus.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/JointState.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <vector>

#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "report/timing.h"
#include "tools/common.h"

namespace planar_chain::tools {
namespace {

constexpr double settling = 1;   // s, in which connections are made
constexpr double patience = 30;  // s for the first tick

class Listener {
 public:
  explicit Listener(double seconds) : seconds_(seconds) {
    const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
    ticks_ = node_.subscribe("/joint_states", 10000, &Listener::take, this, hints);
    status_ = node_.subscribe("/planar_chain/status", 10, &Listener::takeStatus, this);
  }

  /// @throws std::runtime_error when nothing comes
  void listen() {
    const ros::WallTime begin = ros::WallTime::now();
    while (ros::ok() && !isDone_) {
      ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.05));
      const double waited = (ros::WallTime::now() - begin).toSec();
      if (waited > patience + settling + seconds_) throw std::runtime_error("no tick comes");
    }
  }

  void write(std::ostream& out, double rate) const {
    const long long due = std::llround((last_ - first_).toSec() * rate) + 1;
    out << "missing " << due - static_cast<long long>(late_.size()) << "\noverruns "
        << overruns_ - overrunsThen_ << '\n';
    for (const double each : late_) out << "late " << each << '\n';
  }

 private:
  void take(const ros::MessageEvent<const sensor_msgs::JointState>& event) {
    const ros::Time stamp = event.getMessage()->header.stamp, now = event.getReceiptTime();
    if (begin_.isZero()) begin_ = now;
    const double since = (now - begin_).toSec() - settling;
    if (since < 0 || isDone_) return;
    if (late_.empty()) {
      first_ = stamp;
      overrunsThen_ = overruns_;
    }
    last_ = stamp;
    late_.push_back((now - stamp).toSec());
    isDone_ = since > seconds_;
  }
  void takeStatus(const SimStatus& status) { overruns_ = status.overruns; }

  ros::NodeHandle node_;
  ros::Subscriber ticks_, status_;
  double seconds_;
  ros::Time begin_, first_, last_;
  std::vector<double> late_;
  std::uint64_t overruns_ = 0, overrunsThen_ = 0;
  bool isDone_ = false;
};

void writeWork(std::ostream& out, const Scene& scene, double seconds) {
  Simulation simulation(scene);
  for (long long k = 1; static_cast<double>(k) < seconds * scene.publish.rate; ++k) {
    bool isGood = false;
    const double work =
        secondsOf([&] { isGood = simulation.advanceTo(static_cast<double>(k) / scene.publish.rate); });
    if (!isGood) throw std::runtime_error(simulation.fault());
    out << "work " << work << '\n';
  }
}

int listen(const char* path, double seconds, const char* scenePath) {
  const Scene scene = readSceneText(loadText(scenePath));
  Listener listener(seconds);
  listener.listen();
  std::ofstream out(path);
  listener.write(out, scene.publish.rate);
  writeWork(out, scene, seconds);
  if (!out.flush()) throw std::runtime_error(std::string(path) + " cannot be written");
  return 0;
}

}  // namespace
}  // namespace planar_chain::tools

int main(int argc, char** argv) {
  ros::init(argc, argv, "report_listen");
  if (argc != 4) return 2;
  try {
    return planar_chain::tools::listen(argv[1], std::strtod(argv[2], nullptr), argv[3]);
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "report_listen: %s\n", failure.what());
    return 1;
  }
}
