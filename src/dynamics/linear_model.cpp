#include "planar_chain/linear_model.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "dynamics/general_motion.h"
#include "dynamics/given_state.h"
#include "dynamics/motion_change.h"
#include "dynamics/scene_snapshot.h"
#include "effects/motors.h"
#include "planar_chain/kane.h"
#include "reading/names.h"

namespace planar_chain {

namespace {

using Eigen::VectorXd;

std::string shown(double number) {
  char text[30];
  std::snprintf(text, sizeof text, "%.9g", number);
  return text;
}

// ---- The torques ------------------------------------------------------------------------------------

/// The torques that make q̈ = 0, or of driven joints that of their laws.
VectorXd holdingTorques(const Scene& scene, double t, const VectorXd& q, const VectorXd& qd) {
  VectorXd qdd = VectorXd::Zero(q.size());
  for (const Drive& drive : scene.drives) qdd[drive.joint] = drive.law.at(t).acceleration;
  VectorXd tau = inverseDynamics(scene, t, q, qd, qdd);
  for (const Drive& drive : scene.drives) tau[drive.joint] = 0;
  return tau;
}

VectorXd checked(const Scene& scene, const VectorXd& tau) {
  std::vector<Fault> faults;
  if (checkNumbers("tau", scene, tau, "N m", faults)) {
    for (const Drive& drive : scene.drives) {
      if (tau[drive.joint] == 0) continue;
      faults.push_back({"tau", "0 N m in the driven joint " + scene.chain.joints()[index(drive.joint)].name,
                        toText(tau[drive.joint])});
    }
  }
  if (!faults.empty()) throw Refused(std::move(faults));
  return tau;
}

/// The scene with these torques, and without friction in joints at rest if they slip.
Scene sceneAbout(const Scene& given, const VectorXd& qd, const OperatingPoint& about) {
  Scene scene = given;
  if (!about.slips) return scene;
  std::vector<Joint> joints = scene.chain.joints();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (qd[static_cast<Eigen::Index>(i)] != 0) continue;
    for (const char* key : {"friction", "breakaway"}) {
      if (joints[i].has(key)) joints[i].others.set(key, 0);
    }
  }
  scene.chain = Chain(scene.chain.links(), std::move(joints), scene.chain.gravity());
  return scene;
}

void addTorques(const VectorXd& tau, Scene& scene) {
  for (int i = 0; i < tau.size(); ++i) {
    if (tau[i] != 0) scene.loads.push_back({"tau", Load::none, {}, {}, 0, i, tau[i]});
  }
}

// ---- The notes --------------------------------------------------------------------------------------

void noteSticking(const Scene& scene, const Couplings& couplings, std::vector<std::string>& notes) {
  std::vector<bool> isDriven(scene.q.size(), false);
  for (const Drive& drive : scene.drives) isDriven[index(drive.joint)] = true;
  std::vector<std::string> stuck;
  for (std::size_t i = 0; i < isDriven.size(); ++i) {
    if (couplings.joints[i].isPrescribed && !isDriven[i]) stuck.push_back(scene.chain.joints()[i].name);
  }
  if (stuck.empty()) return;
  notes.push_back(listed(stuck) + (stuck.size() > 1 ? " stick" : " sticks") +
                  ": A and B hold while the friction does, and the columns of B are 0. In Python and in "
                  "equations, friction \"slips\" linearizes a joint at rest as one that slips");
}

/// Notes the joints of a chain at rest that accelerate, by qdd. given: without the torques tau.
void noteMotion(const Scene& given, double t, const VectorXd& q, const VectorXd& qdd,
                std::vector<std::string>& notes) {
  constexpr double still = 1e-6;  // rad/s², m/s²: torques of six digits hold it no better
  std::vector<std::string> moving;
  for (int i = 0; i < q.size(); ++i) {
    if (!(std::abs(qdd[i]) > still)) continue;
    const Joint& joint = given.chain.joints()[index(i)];
    moving.push_back(joint.name + " " + shown(qdd[i]) + (joint.isPrismatic ? " m/s^2" : " rad/s^2"));
  }
  if (moving.empty()) return;
  std::string note = "this state is no equilibrium, its accelerations are not 0: " + listed(moving);
  try {
    const VectorXd tau = holdingTorques(given, t, q, VectorXd::Zero(q.size()));
    constexpr int most = 12;  // numbers in a line
    std::string numbers;
    for (int i = 0; i < tau.size(); ++i) numbers += (i > 0 ? "," : "") + shown(tau[i]);
    note += ". The torques tau" + (tau.size() > most ? " \"holding\"" : " = " + numbers) + " would hold it";
  } catch (const Refused&) {  // the held tip moves
  }
  notes.push_back(note);
}

void noteLimits(const Scene& scene, const VectorXd& tau, std::vector<std::string>& notes) {
  for (int i = 0; i < tau.size(); ++i) {
    const Joint& joint = scene.chain.joints()[index(i)];
    const double limit = joint.other("effort_limit");
    if (!joint.has("effort_limit") || std::abs(tau[i]) <= limit) continue;
    const std::string unit = joint.isPrismatic ? " N" : " N m";
    notes.push_back("tau: " + shown(tau[i]) + unit + " in " + joint.name + " is beyond its effort_limit, " +
                    shown(limit) + unit + ": no command gives it");
  }
}

/// With `hasMotors` only dead times are left out.
void noteMotors(const Scene& scene, bool hasMotors, std::vector<std::string>& notes) {
  std::vector<std::string> left;
  for (const Joint& joint : scene.chain.joints()) {
    const double delay = joint.other("command_delay");
    if (delay > 0) {
      left.push_back("of " + joint.name + " (command_delay " + shown(delay) + " s)");
    } else if (!hasMotors && changesCommands(joint)) {
      left.push_back("of " + joint.name);
    }
  }
  if (left.empty()) return;
  notes.push_back(hasMotors
                      ? "A and B have no command delays, " + listed(left)
                      : "A and B leave out the motors and command delays " + listed(left) +
                            "; dtau is the torque that acts. In Python, motors=True has lags as states");
}

// ---- Motors -----------------------------------------------------------------------------------------

std::vector<LinearMotor> motorsOf(const Chain& chain, const VectorXd& qd, const OperatingPoint& about,
                                  const VectorXd& tau) {
  if (about.motors) return *about.motors;
  VectorXd omega(qd.size());
  chain.coordinates().toAbsolute(qd.data(), omega.data());
  return steadyMotors(chain, tau.data(), omega.data());
}

/// T ẋ = u − x. The torque is x, or on the line it changes by −damping δq̇ alone.
void addMotors(const std::vector<LinearMotor>& motors, LinearModel& model) {
  const Eigen::Index n = model.B.cols(), states = 2 * n;
  const Eigen::MatrixXd acts = model.B;
  Eigen::Index lags = 0;
  for (const LinearMotor& motor : motors) lags += motor.lag > 0;
  model.A.conservativeResizeLike(Eigen::MatrixXd::Zero(states + lags, states + lags));
  model.B.conservativeResizeLike(Eigen::MatrixXd::Zero(states + lags, n));
  Eigen::Index lagged = states;
  for (const LinearMotor& motor : motors) {
    const Eigen::Index j = motor.joint;
    model.A.col(n + j).head(states) -= motor.damping * acts.col(j);
    const VectorXd byTorque = (motor.isFree ? 1 : 0) * acts.col(j);
    model.B.col(j).setZero();
    if (motor.lag > 0) {
      model.A.col(lagged).head(states) = byTorque;
      model.A(lagged, lagged) = -1 / motor.lag;
      model.B(lagged++, j) = motor.isCutOff ? 0 : 1 / motor.lag;
    } else if (!motor.isCutOff) {
      model.B.col(j).head(states) = byTorque;
    }
  }
}

}  // namespace

LinearModel linearModel(const Scene& given, double t, const VectorXd& q, const VectorXd& qd,
                        const OperatingPoint& about) {
  const int n = given.chain.size();
  if (q.size() != n || qd.size() != n) {
    throw std::invalid_argument("q and qd must have one value a joint");
  }
  Scene scene = sceneAbout(given, qd, about);
  const Scene bare = scene;
  VectorXd tau =
      about.isHeld ? holdingTorques(scene, t, q, qd) : checked(scene, about.tau.value_or(VectorXd::Zero(n)));
  addTorques(tau, scene);
  SceneSnapshot snapshot(scene, t, q, qd);
  const Evaluation& at = snapshot.evaluation();
  EffectTangents tangents(n, snapshot.effects);
  tangents.takeConstant(snapshot.effects);
  tangents.takeJoints(snapshot.effects, at.state());
  tangents.takeForces(snapshot.effects, at.state());
  const Couplings& couplings = snapshot.motion.couplings(t);
  const bool hasForces = snapshot.effects.acting() == LoadKind::forces;

  // δq̈ while joint j, with all that turns with it, turns or slides by `turn`, speeds up by `speed`, and has
  // `torque` more.
  MotionChange change(snapshot.mechanism);
  const Coordinates& coordinates = scene.chain.coordinates();
  const auto along = [&](int j, double turn, double speed, double torque) {
    for (int i = 0; i < n; ++i) {
      const double hangs =
          i == j || (i > j && !coordinates.isPrismatic(i) && !coordinates.isPrismatic(j)) ? 1 : 0;
      change.turn[index(i)] = hangs * turn;
      change.speed[index(i)] = hangs * speed;
    }
    std::fill(change.N.begin(), change.N.end(), 0.0);
    coordinates.addTorque(torque, j, change.N.data());
    change.find(at, hasForces, couplings, tangents);
    Eigen::VectorXd result(n);
    coordinates.toRelative(change.xdd.data(), result.data());
    return result;
  };

  LinearModel model{Eigen::MatrixXd::Zero(2 * n, 2 * n), Eigen::MatrixXd::Zero(2 * n, n), std::move(tau),
                    VectorXd(n)};
  coordinates.toRelative(at.slopes(), model.qdd.data());
  noteSticking(scene, couplings, model.notes);
  if (qd.isZero(0)) noteMotion(bare, t, q, model.qdd, model.notes);
  noteLimits(scene, model.tau, model.notes);
  const bool hasMotors = about.motors || about.hasSteadyMotors;
  noteMotors(scene, hasMotors, model.notes);
  model.A.topRightCorner(n, n).setIdentity();
  for (int j = 0; j < n; ++j) {
    model.A.col(j).tail(n) = along(j, 1, 0, -tangents.k[index(j)]);
    model.A.col(n + j).tail(n) = along(j, 0, 1, -tangents.d[index(j)]);
    model.B.col(j).tail(n) = along(j, 0, 0, 1);
  }
  if (hasMotors) addMotors(motorsOf(scene.chain, qd, about, model.tau), model);
  return model;
}

}  // namespace planar_chain
