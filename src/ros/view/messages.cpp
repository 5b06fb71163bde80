#include "ros/view/messages.h"

#include <utility>

#include "planar_chain/planar.h"

namespace planar_chain {

Messages::Messages(Simulation& simulation, const std::string& node, bool hasViews)
    : simulation_(simulation),
      node_(node),
      frames_(framesOf(simulation.scene(), node)),
      measurements_(simulation, node, frames_) {
  const Scene& scene = simulation.scene();
  const auto n = static_cast<std::size_t>(scene.chain.size());

  // Size the joint states and the link states.
  for (const Joint& joint : scene.chain.joints()) jointStates_.name.push_back(joint.name);
  jointStates_.effort.resize(n);
  linkStates_.header.frame_id = frames_.base;
  baseWrench_.header.frame_id = tipWrench_.header.frame_id = frames_.base;
  for (const Link& link : scene.chain.links()) linkStates_.name.push_back(link.name);
  linkStates_.pose.resize(n);
  linkStates_.velocity.resize(n);
  linkStates_.acceleration.resize(n);
  linkStates_.pin_force.resize(n);
  motions_.resize(n);

  // Set the frames of the transforms. They are constant.
  std::string parent = frames_.base;
  const auto add = [&](const std::string& frame) {
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = std::exchange(parent, frame);
    transform.child_frame_id = frame;
    transforms_.transforms.push_back(transform);
  };
  if (scene.base) add(frames_.pin);
  for (int i = 0; i < scene.chain.size(); ++i) {
    if (!frames_.has(i)) continue;
    add(frames_.links[index(i)]);
    framed_.push_back(i);
  }
  geometry_msgs::TransformStamped& base = staticTransforms_.transforms.emplace_back();
  base.header.frame_id = frames_.world;
  base.child_frame_id = frames_.base;
  base.transform.translation.x = scene.publish.offset.x;
  base.transform.translation.z = scene.publish.offset.y;
  base.transform.rotation.x = base.transform.rotation.w = std::sqrt(0.5);
  for (const auto* all : {&frames_.onLinks, &frames_.ofImus}) {
    for (const Frame& frame : *all) {
      geometry_msgs::TransformStamped& to = staticTransforms_.transforms.emplace_back();
      to.header.frame_id = frames_.of(frame.link);
      to.child_frame_id = frames_.of(frame);
      copy(frame.point, to.transform.translation);
      to.transform.rotation.z = std::sin(frame.angle / 2);
      to.transform.rotation.w = std::cos(frame.angle / 2);
    }
  }
  if (hasViews) views_.emplace(simulation, frames_);
}

sensor_msgs::JointState& Messages::jointStates(ros::Time stamp) {
  jointStates_.header.stamp = stamp;
  jointStates_.position = simulation_.q();
  jointStates_.velocity = simulation_.qd();
  simulation_.jointTorques(jointStates_.effort.data());
  return jointStates_;
}

LinkStates& Messages::linkStates(ros::Time stamp) {
  linkStates_.header.stamp = stamp;
  simulation_.linkMotions(motions_.data());
  for (std::size_t i = 0; i < motions_.size(); ++i) {
    const LinkMotion& link = motions_[i];
    copy(link.com, linkStates_.pose[i]);
    linkStates_.pose[i].theta = link.angle;
    copy(link.velocity, linkStates_.velocity[i].linear);
    linkStates_.velocity[i].angular.z = link.omega;
    copy(link.acceleration, linkStates_.acceleration[i].linear);
    linkStates_.acceleration[i].angular.z = link.alpha;
    copy(link.pinForce, linkStates_.pin_force[i]);
  }
  return linkStates_;
}

geometry_msgs::WrenchStamped& Messages::baseWrench(ros::Time stamp) {
  baseWrench_.header.stamp = stamp;
  const BaseWrench wrench = simulation_.baseWrench();
  copy(wrench.force, baseWrench_.wrench.force);
  baseWrench_.wrench.torque.z = wrench.torque;
  return baseWrench_;
}

geometry_msgs::WrenchStamped& Messages::tipWrench(ros::Time stamp) {
  tipWrench_.header.stamp = stamp;
  copy(simulation_.tipForce(), tipWrench_.wrench.force);
  return tipWrench_;
}

tf2_msgs::TFMessage& Messages::transforms(ros::Time stamp) {
  const Chain& chain = simulation_.scene().chain;
  auto transform = transforms_.transforms.begin();
  const auto set = [&](Vec2d position, double angle) {
    transform->header.stamp = stamp;
    copy(position, transform->transform.translation);
    transform->transform.rotation.z = std::sin(angle / 2);
    transform->transform.rotation.w = std::cos(angle / 2);
    ++transform;
  };
  // The base's frame does not move. That of its pin does.
  if (simulation_.scene().base) {
    simulation_.linkMotions(motions_.data());
    const LinkMotion& first = motions_.front();
    const double q = simulation_.q().front();
    const Joint& joint = chain.joints().front();
    joint.isPrismatic
        ? set(first.innerPin - q * (Rotation<double>::of(first.angle) * joint.axis), first.angle)
        : set(first.innerPin, first.angle - q);
  }
  int i = 0;
  for (const int framed : framed_) {
    // Go from the frame before to this one, link by link.
    Vec2d position;
    double angle = 0;
    for (; i <= framed; ++i) {
      const auto turn = Rotation<double>::of(angle);
      const Joint& joint = chain.joints()[index(i)];
      const double q = simulation_.q()[index(i)];
      if (i > 0) position += turn * chain.links()[index(i - 1)].pin;
      if (joint.isPrismatic) {
        position += turn * (q * joint.axis);
      } else {
        angle += q;
      }
    }
    set(position, angle);
  }
  return transforms_;
}

tf2_msgs::TFMessage& Messages::staticTransforms(ros::Time stamp) {
  for (geometry_msgs::TransformStamped& transform : staticTransforms_.transforms)
    transform.header.stamp = stamp;
  return staticTransforms_;
}

namespace {

/// Returns the method of the first steps. `auto` chooses it when it makes them, so a copy makes them.
std::string firstMethod(const Simulation& simulation) {
  if (simulation.scene().integrator.method != "auto") return simulation.method();
  Simulation copy(simulation.scene());
  copy.setState(simulation.q(), simulation.qd());
  copy.advanceTo(1 / simulation.scene().publish.rate, [] { return false; });
  return copy.method();
}

}  // namespace

void describe(Simulation& simulation, SimStatus& status) {
  const Statistics statistics = simulation.statistics();
  const EnergyBalance balance = simulation.energyBalance();
  status.sim_time = status.scene_time = simulation.time();
  if (statistics.steps > 0) {
    status.method = simulation.method();
  } else if (status.steps > 0 || status.method.empty()) {
    status.method = firstMethod(simulation);
  }
  status.steps = static_cast<std::uint64_t>(statistics.steps);
  status.rejected_steps = static_cast<std::uint64_t>(statistics.rejected);
  status.rescues = static_cast<std::uint64_t>(statistics.rescues);
  status.evaluations = static_cast<std::uint64_t>(statistics.evaluations);
  status.error_estimate = statistics.localError;
  status.tolerance = simulation.tolerance();
  status.kinetic = balance.now.kinetic;
  status.potential = balance.now.potential;
  status.work_supplied = balance.supplied;
  status.dissipated = balance.dissipated;
  status.energy_balance = balance.residual;
  status.closure_error = simulation.closureError();
  status.closure_margin = simulation.closureMargin();
  status.fault = simulation.fault();
  const auto sum = [&](const std::vector<long long>& counts, std::uint64_t& all,
                       std::vector<std::string>& joints) {
    all = 0;
    joints.clear();
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (counts[i] == 0) continue;
      all += static_cast<std::uint64_t>(counts[i]);
      joints.push_back(simulation.scene().chain.joints()[i].name);
    }
  };
  sum(simulation.cutOffs(), status.torques_cut_off, status.joints_cut_off);
  sum(simulation.velocityExcesses(), status.velocities_exceeded, status.joints_too_fast);
}

}  // namespace planar_chain
