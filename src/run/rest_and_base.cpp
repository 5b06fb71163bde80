#include "dynamics/equilibrium.h"
#include "effects/effect_kind.h"
#include "ode/methods.h"
#include "run/simulation_parts.h"

namespace planar_chain {

std::vector<Load> Simulation::commands() const {
  const CommandEffect* commands = parts_->commands;
  if (!commands) return {};
  std::vector<double> omega(qd().size());
  scene_.chain.coordinates().toAbsolute(qd().data(), omega.data());
  return commands->inForce(time(), omega.data());
}

std::vector<double> Simulation::motorTorques() const {
  std::vector<double> torques(q().size(), 0.0);
  for (std::size_t i = 0; parts_->commands && i < torques.size(); ++i)
    torques[i] = parts_->commands->motorTorque(time(), static_cast<int>(i));
  return torques;
}

void Simulation::setMotorTorques(const std::vector<double>& torques) {
  CommandEffect* commands = parts_->commands;
  require(commands != nullptr, "this simulation was built without room for commands");
  require(torques.size() == q().size(), "torques must have one value a joint");
  const std::vector<double> present = motorTorques();
  std::vector<Fault> faults;
  double rounding = 0;  // of holding torques
  for (const double torque : torques) rounding = std::max(rounding, 1e-9 * std::abs(torque));
  for (std::size_t i = 0; i < torques.size(); ++i) {
    const Joint& joint = scene_.chain.joints()[i];
    const double limit = joint.has("effort_limit") ? joint.other("effort_limit") : largestFactor;
    const bool lags = joint.other(timeConstant) > 0;
    if (lags ? std::abs(torques[i]) <= limit : std::abs(torques[i] - present[i]) <= rounding) continue;
    faults.push_back({"motor_torques/" + std::to_string(i),
                      lags ? "a torque from " + toText(-limit) + " to " + toText(limit) + " N m"
                           : toText(present[i]) + " N m, as commanded: " + joint.name + " has no lag",
                      toText(torques[i])});
  }
  if (!faults.empty()) throw Refused(std::move(faults));
  parts_->actOtherwise();
  parts_->derivatives.reset();
  for (std::size_t i = 0; i < torques.size(); ++i)
    commands->setMotorTorque(time(), static_cast<int>(i), torques[i]);
}

FrameMotion Simulation::motion(const Frame& frame) {
  std::vector<LinkMotion> motions(q().size());
  require(frame.link >= 0 && index(frame.link) < motions.size(), "a frame must be on a link of the chain");
  linkMotions(motions.data());
  return motionOf(frame, scene_.chain.links()[index(frame.link)], motions[index(frame.link)]);
}

LinearModel Simulation::linearize(bool motors) const {
  Scene present = scene_;
  for (Load& command : commands()) present.loads.push_back(std::move(command));
  OperatingPoint about;
  if (motors) {
    std::vector<double> omega(qd().size());
    scene_.chain.coordinates().toAbsolute(qd().data(), omega.data());
    about.motors.emplace();
    if (parts_->commands) *about.motors = parts_->commands->motorsAt(time(), omega.data());
  }
  return linearModel(present, time(), vectorOf(q()), vectorOf(qd()), about);
}

const Scene& Simulation::scene() const {
  return scene_;
}

double Simulation::tolerance() const {
  return ode::hasFixedStep(scene_.integrator.method) ? 0 : scene_.integrator.tolerance;
}

void Simulation::settle(const std::function<bool()>& keepGoing) {
  Scene present = scene_;
  CommandEffect* commands = parts_->commands;
  if (commands) {
    for (Load& command : commands->inForce(time(), nullptr)) present.loads.push_back(std::move(command));
  }
  const std::vector<double> rest = equilibriumOf(present, time(), q(), mostSearchSteps, keepGoing);
  std::vector<double> still(rest.size(), 0.0);
  for (const Drive& drive : scene_.drives) still[index(drive.joint)] = qd()[index(drive.joint)];
  parts_->undoTrial();
  if (commands) commands->finish(time());
  setState(rest, still);
}

namespace {

/// The moment of a load on a carriage about its centre of mass, N m.
double carriageMoment(const Load& load, double t, const Chain& chain, double angle) {
  if (load.link == Load::none || chain.coordinates().turner(load.link) >= 0) return 0;
  const Vec2d arm = Rotation<double>::of(angle) * (load.point - chain.links()[index(load.link)].com);
  return factorAt(load, t) * (load.moment + cross(arm, load.force));
}

/// The moments of all effects on the first carriages, as many as `count`, about their centres of mass, N m.
double carriageMoments(const Scene& scene, double t, const std::vector<double>& q,
                       const std::vector<double>& qd, int count) {
  const auto n = static_cast<Eigen::Index>(q.size());
  Eigen::VectorXd F = Eigen::VectorXd::Zero(2 * n), M = Eigen::VectorXd::Zero(n), tau = M;
  for (const EffectKind* kind : effectKinds())
    kind->addDense(scene, t, Eigen::VectorXd::Map(q.data(), n), Eigen::VectorXd::Map(qd.data(), n),
                   {F, M, tau});
  return M.head(count).sum();
}

}  // namespace

BaseWrench Simulation::baseWrench() {
  const auto n = static_cast<std::size_t>(scene_.chain.size());
  std::vector<LinkMotion> motions(n);
  std::vector<double> tau(n), qdd(n, 0.0);
  linkMotions(motions.data());
  jointTorques(tau.data());
  // The force on the first revolute joint; then the forces on the carriages inside, with loads at the centre
  // of mass; then the moments of all.
  const std::size_t leading = index(scene_.chain.coordinates().leading());
  Vec2d ground = motions[0].innerPin, force = -1.0 * tipForce();
  if (leading > 0)
    ground -= q().front() * (Rotation<double>::of(motions[0].angle) * scene_.chain.joints().front().axis);
  double torque = 0;
  if (leading == n) {
    const Vec2d pin = Rotation<double>::of(motions.back().angle) * scene_.chain.links().back().pin;
    torque = -cross(motions.back().innerPin + pin - ground, force);
  } else {
    const double armature = inertiaIn(scene_.chain.joints()[leading]);
    if (armature > 0) accelerations(qdd.data());
    force = motions[leading].pinForce;
    torque = armature * qdd[leading] - tau[leading] - cross(motions[leading].innerPin - ground, force);
  }
  for (std::size_t i = leading; i-- > 0;) {
    torque -= cross(motions[i].com - ground, motions[i].pinForce - force) +
              scene_.chain.links()[i].inertia * motions[i].alpha;
    force = motions[i].pinForce;
  }
  if (leading > 0) {
    torque += carriageMoments(scene_, time(), q(), qd(), scene_.chain.coordinates().leading());
    for (const Load& command : commands())
      torque += carriageMoment(command, time(), scene_.chain, motions[0].angle);
  }
  return {-1.0 * force, torque};
}

}  // namespace planar_chain
