#include "ros/node/trajectories.h"

#include <algorithm>
#include <cmath>

#include "ros/messages/incoming.h"

namespace planar_chain {

namespace {

using Faults = std::vector<Fault>;
using Point = trajectory_msgs::JointTrajectoryPoint;

std::string entry(const std::string& path, std::size_t i) {
  return path + "[" + std::to_string(i) + "]";
}

/// Returns the drive of each joint that is named.
std::vector<Drive> drivesOf(const std::vector<std::string>& names, const std::vector<Drive>& drives,
                            const std::map<std::string, int>& joints, Faults& faults) {
  std::vector<Drive> named;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string path = entry("joint_trajectory/joint_names", i);
    const int joint = find(faults, path, joints, names[i]);
    if (joint < 0) continue;
    const auto isIt = [joint](const Drive& drive) { return drive.joint == joint; };
    const auto drive = std::find_if(drives.begin(), drives.end(), isIt);
    if (drive == drives.end()) {
      faults.push_back({path, "a driven joint", quoted(names[i])});
    } else if (std::any_of(named.begin(), named.end(), isIt)) {
      faults.push_back({path, "each joint once", quoted(names[i])});
    } else {
      named.push_back(*drive);
    }
  }
  if (names.empty())
    faults.push_back({"joint_trajectory/joint_names", "at least one driven joint", "nothing"});
  return named;
}

void checkPoints(const std::vector<Point>& points, std::size_t joints, Faults& faults) {
  if (points.empty()) faults.push_back({"joint_trajectory/points", "at least one point", "nothing"});
  double before = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Point& point = points[k];
    const std::string path = entry("joint_trajectory/points", k);
    const auto check = [&](const char* part, const char* unit, const std::vector<double>& values) {
      checkValues(faults, path + "/" + part, part, unit, values, joints);
    };
    check("positions", "rad", point.positions);
    if (!point.velocities.empty()) check("velocities", "rad/s", point.velocities);
    if (!point.accelerations.empty()) check("accelerations", "rad/s²", point.accelerations);
    const double time = point.time_from_start.toSec();
    if (k == 0 ? !(time >= 0) : !(time > before)) {
      faults.push_back({path + "/time_from_start",
                        k == 0 ? "a time >= 0 s" : "a time after the point before, " + toText(before) + " s",
                        toText(time)});
    }
    before = time;
  }
  if (points.empty()) return;
  for (const double rate : points.back().velocities) {
    if (rate == 0 || !std::isfinite(rate)) continue;
    faults.push_back({entry("joint_trajectory/points", points.size() - 1) + "/velocities",
                      "0 rad/s in the last point, where the joints stay", toText(rate)});
  }
}

}  // namespace

std::vector<Drive> lawsOf(const trajectory_msgs::JointTrajectory& message, double start,
                          const Simulation& simulation, const std::map<std::string, int>& joints,
                          std::vector<Fault>& faults) {
  const std::vector<std::string>& names = message.joint_names;
  std::vector<Drive> laws = drivesOf(names, simulation.scene().drives, joints, faults);
  checkPoints(message.points, names.size(), faults);
  const double now = simulation.time(), begin = std::max(start, now);
  if (!(start - now <= farthestStart)) {
    faults.push_back(
        {"joint_trajectory/header/stamp", "0 for now, or the node's time, at most a day ahead",
         std::isfinite(start) ? toText(start - now) + " s ahead" : "a time before /clock has begun"});
  }
  if (!faults.empty()) return laws;

  for (std::size_t i = 0; i < laws.size(); ++i) {
    std::vector<MotionPoint> points;
    for (const Point& point : message.points) {
      const double time = start + point.time_from_start.toSec();
      if (time <= begin) continue;
      MotionPoint& to = points.emplace_back();
      to.time = time;
      to.value = point.positions[i];
      if (!point.velocities.empty()) to.rate = point.velocities[i];
      if (!point.accelerations.empty()) to.acceleration = point.accelerations[i];
    }
    if (points.empty()) {
      faults.push_back({"joint_trajectory/points", "a point later than now",
                        toText(now - start) + " s after the start of the trajectory"});
      return laws;
    }
    laws[i].law = laws[i].law.then(now, begin, points);
    if (laws[i].law.isFinite()) continue;
    faults.push_back({"joint_trajectory/points", "finite rates and accelerations", "numbers too large"});
  }
  return laws;
}

}  // namespace planar_chain
