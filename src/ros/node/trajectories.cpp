#include "ros/node/trajectories.h"

#include <algorithm>
#include <cmath>

#include "planar_chain/planar.h"
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
  Indices driven;
  for (const auto& [name, joint] : joints) {
    const bool isDriven = std::any_of(drives.begin(), drives.end(),
                                      [at = joint](const Drive& drive) { return drive.joint == at; });
    if (isDriven) driven.emplace(name, joint);
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string path = entry("joint_trajectory/joint_names", i);
    if (joints.count(names[i]) != 0 && driven.count(names[i]) == 0) {
      const std::string expected = driven.empty()
                                       ? "a joint with a drive, such as drive: hold; no joint has one"
                                       : "a driven joint of the chain (" + inOrder(driven, 80) + ")";
      faults.push_back({path, expected, quoted(names[i])});
      continue;
    }
    const int joint = find(faults, path, "driven joint", names[i], driven);
    if (joint < 0) continue;
    const auto isIt = [joint](const Drive& drive) { return drive.joint == joint; };
    const auto drive = std::find_if(drives.begin(), drives.end(), isIt);
    if (std::any_of(named.begin(), named.end(), isIt)) {
      faults.push_back({path, "each joint once", quoted(names[i])});
    } else {
      named.push_back(*drive);
    }
  }
  if (names.empty())
    faults.push_back({"joint_trajectory/joint_names", "at least one driven joint", "nothing"});
  return named;
}

/// One trajectory of several motions, all from scene time `start` on.
class CommandedTrajectory {
 public:
  /// topic: such as "joint_trajectory".
  CommandedTrajectory(const std::string& topic, const std::vector<Point>& points, double start, double now,
                      Faults& faults)
      : topic_(topic), points_(points), start_(start), now_(now), faults_(faults) {}

  /// Adds the faults of the start, the times and the end.
  void check() const {
    if (!(start_ - now_ <= farthestStart)) {
      faults_.push_back(
          {topic_ + "/header/stamp", "0 for now, or the node's time, at most a day ahead",
           std::isfinite(start_) ? toText(start_ - now_) + " s ahead" : "a time before /clock has begun"});
    }
    if (points_.empty()) return faults_.push_back({topic_ + "/points", "at least one point", "nothing"});
    double before = 0;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const double time = points_[k].time_from_start.toSec();
      if (k == 0 ? !(time >= 0) : !(time > before)) {
        faults_.push_back(
            {path(k) + "/time_from_start",
             k == 0 ? "a time >= 0 s" : "a time after the point before, " + toText(before) + " s",
             toText(time)});
      }
      before = time;
    }
    for (const double rate : points_.back().velocities) {
      if (rate == 0 || !std::isfinite(rate)) continue;
      faults_.push_back({path(points_.size() - 1) + "/velocities",
                         "0 in the last point, where the motion ends", toText(rate)});
    }
  }

  std::string path(std::size_t k) const { return entry(topic_ + "/points", k); }

  /// Lets a law go through the i-th values of the points. Call it without faults only.
  void lead(MotionLaw& law, std::size_t i, const char* unit) const {
    const double begin = std::max(start_, now_);
    std::vector<MotionPoint> points;
    for (const Point& point : points_) {
      const double time = start_ + point.time_from_start.toSec();
      if (time <= begin) continue;
      MotionPoint& to = points.emplace_back();
      to.time = time;
      to.value = point.positions[i];
      if (!point.velocities.empty()) to.rate = point.velocities[i];
      if (!point.accelerations.empty()) to.acceleration = point.accelerations[i];
    }
    if (points.empty()) {
      return faults_.push_back({topic_ + "/points", "a point later than now",
                                toText(now_ - start_) + " s after the start of the trajectory"});
    }
    law = law.then(now_, begin, points);
    if (law.isModerate()) return;
    faults_.push_back({topic_ + "/points", MotionLaw::moderate(unit), "a faster motion"});
  }

 private:
  std::string topic_;
  const std::vector<Point>& points_;
  double start_, now_;
  Faults& faults_;
};

// ---- The base ------------------------------------------------------------------------------------

bool requireBase(const char* path, const Simulation& simulation, Faults& faults) {
  if (simulation.scene().base) return true;
  faults.push_back({path, "a scene whose base moves (the key `base`)", "one that has none"});
  return false;
}

/// Takes x, y and the rotation about z. The other components must be 0.
std::vector<double> planar(const geometry_msgs::Twist& twist, const std::string& path, const char* part,
                           Faults& faults) {
  const std::vector<double> rates{twist.linear.x, twist.linear.y, twist.angular.z};
  checkValues(faults, path, part, "SI units", rates, 3);
  for (const double out : {twist.linear.z, twist.angular.x, twist.angular.y}) {
    checkZero(faults, path + "[0]", out);
  }
  return rates;
}

using BasePoint = trajectory_msgs::MultiDOFJointTrajectoryPoint;

/// Takes x, y and the angle of one point. angle: that of the point before.
Point planar(const BasePoint& point, const std::string& path, double& angle, Faults& faults) {
  Point plane;
  plane.time_from_start = point.time_from_start;
  const auto checkSize = [&](const char* part, std::size_t size, bool isNeeded) {
    if (size == 1 || (size == 0 && !isNeeded)) return;
    faults.push_back({path + "/" + part, isNeeded ? "one, of the base" : "one, of the base, or none",
                      std::to_string(size)});
  };
  checkSize("transforms", point.transforms.size(), true);
  checkSize("velocities", point.velocities.size(), false);
  checkSize("accelerations", point.accelerations.size(), false);

  for (const geometry_msgs::Transform& at : point.transforms) {
    const double x = at.rotation.x, y = at.rotation.y, z = at.rotation.z, w = at.rotation.w;
    constexpr double rounded = 1e-3;  // of a quaternion with three digits
    if (!(x == 0 && y == 0 && std::abs(z * z + w * w - 1) < rounded)) {
      faults.push_back({path + "/transforms[0]/rotation", "a unit quaternion about z",
                        "(" + toText(x) + ", " + toText(y) + ", " + toText(z) + ", " + toText(w) + ")"});
    }
    angle += std::remainder(2 * std::atan2(z, w) - angle, 2 * pi);
    checkFinite(faults, path + "/transforms[0]/translation/x", "m", at.translation.x);
    checkFinite(faults, path + "/transforms[0]/translation/y", "m", at.translation.y);
    checkZero(faults, path + "/transforms[0]/translation/z", at.translation.z);
    plane.positions = {at.translation.x, at.translation.y, angle};
  }
  const auto take = [&](const char* part, const auto& twists, std::vector<double>& to) {
    for (const geometry_msgs::Twist& twist : twists) to = planar(twist, path + "/" + part, part, faults);
  };
  take("velocities", point.velocities, plane.velocities);
  take("accelerations", point.accelerations, plane.accelerations);
  return plane;
}

}  // namespace

std::vector<Drive> lawsOf(const trajectory_msgs::JointTrajectory& message, double start,
                          const Simulation& simulation, const std::map<std::string, int>& joints,
                          std::vector<Fault>& faults) {
  const std::vector<std::string>& names = message.joint_names;
  std::vector<Drive> laws = drivesOf(names, simulation.scene().drives, joints, faults);
  const CommandedTrajectory trajectory("joint_trajectory", message.points, start, simulation.time(), faults);
  for (std::size_t k = 0; k < message.points.size(); ++k) {
    const Point& point = message.points[k];
    const auto check = [&](const char* part, const char* unit, const std::vector<double>& values) {
      checkValues(faults, trajectory.path(k) + "/" + part, part, unit, values, names.size());
    };
    check("positions", "rad", point.positions);
    if (!point.velocities.empty()) check("velocities", "rad/s", point.velocities);
    if (!point.accelerations.empty()) check("accelerations", "rad/s²", point.accelerations);
  }
  trajectory.check();
  for (std::size_t i = 0; i < laws.size() && faults.empty(); ++i) trajectory.lead(laws[i].law, i, "rad");
  return laws;
}

BaseLaws lawsOf(const trajectory_msgs::MultiDOFJointTrajectory& message, double start,
                const Simulation& simulation, std::vector<Fault>& faults) {
  if (!requireBase("base_trajectory", simulation, faults)) return {};
  BaseLaws laws = *simulation.scene().base;
  const std::vector<std::string>& names = message.joint_names;
  if (names != std::vector<std::string>{"base"}) {
    faults.push_back({"base_trajectory/joint_names", "one name, base",
                      names.size() == 1 ? quoted(names.front()) : std::to_string(names.size())});
  }
  double angle = laws.angle.at(std::max(start, simulation.time())).value;
  std::vector<Point> points;
  const CommandedTrajectory trajectory("base_trajectory", points, start, simulation.time(), faults);
  for (const BasePoint& point : message.points) {
    points.push_back(planar(point, trajectory.path(points.size()), angle, faults));
  }
  trajectory.check();
  std::size_t i = 0;
  for (MotionLaw* law : {&laws.x, &laws.y, &laws.angle}) {
    if (faults.empty()) trajectory.lead(*law, i++, law == &laws.angle ? "rad" : "m");
  }
  return laws;
}

void checkBase(const std::vector<geometry_msgs::Pose2D>& pose, const std::vector<geometry_msgs::Twist>& twist,
               const Simulation& simulation, std::vector<Fault>& faults) {
  if (pose.empty() && twist.empty()) return;
  requireBase("base_pose", simulation, faults);
  if (pose.size() != 1 || twist.size() != 1) {
    return faults.push_back({"base_pose", "one pose and one twist, or neither",
                             std::to_string(pose.size()) + " and " + std::to_string(twist.size())});
  }
  checkValues(faults, "base_pose", "coordinates", "m, rad", {pose[0].x, pose[0].y, pose[0].theta}, 3);
  planar(twist[0], "base_twist", "rates", faults);
}

BaseLaws lawsTo(const geometry_msgs::Pose2D& pose, const geometry_msgs::Twist& twist, double end,
                const Simulation& simulation) {
  const double now = simulation.time();
  const BaseLaws& before = *simulation.scene().base;
  const GivenMotion angle = before.angle.at(now);
  const double reached = angle.value + (angle.rate + twist.angular.z) / 2 * (end - now);
  const double turns = std::round((reached - pose.theta) / (2 * pi));
  return {before.x.to(now, end, pose.x, twist.linear.x), before.y.to(now, end, pose.y, twist.linear.y),
          before.angle.to(now, end, pose.theta + 2 * pi * turns, twist.angular.z)};
}

}  // namespace planar_chain
