#include "planar_chain/ros/views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "planar_chain/kane.h"
#include "planar_chain/value.h"

namespace planar_chain {

namespace {

constexpr double pi = 3.14159265358979323846;

const std_msgs::ColorRGBA red = colour(1, 0.33, 0.42), green = colour(0.4, 0.85, 0.5),
                          white = colour(0.95, 0.95, 0.95), black = colour(0.1, 0.1, 0.12);

// Sizes, in widths of a link; heights above the plane of motion, so that nothing hides what matters more.
constexpr double arrowWidth = 0.3;
constexpr double turnRadius = 2;
constexpr double centreRadius = 0.5, rim = 0.1;
constexpr double trailWidth = 0.3;
constexpr double coilInner = 0.9, coilOuter = 1.7, coilWidth = 0.17, coilTurns = 2.25;
constexpr double behind = -0.55, overBodies = 0.8, overCoils = 0.9, overPins = 1, onTop = 1.1;

constexpr double fullTurn = 5;       // rad, of an arrow for the largest torque that is told apart
constexpr double leastTold = 0.005;  // of the force or torque of Drawing
constexpr double trailTime = 2;      // s
constexpr double trailRate = 100;    // Hz, at most
constexpr double onePart = 1e-9;     // s: what acts for less is over

/// From slack, grey, through yellow to red.
std_msgs::ColorRGBA heat(double share) {
  const double x = std::clamp(share, 0.0, 1.0);
  return x < 0.5 ? colour(0.55 + 0.9 * x, 0.62 + 0.5 * x, 0.7 - x) : colour(1, 1.55 - 1.36 * x, 0.2);
}

std::string digits(const char* name, double joules) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%s %.3g J\n", name, joules);
  return text.data();
}

bool isHeard(const ros::Publisher& topic) {
  return topic.getNumSubscribers() > 0;
}

}  // namespace

Views::Views(ros::NodeHandle& node, const Scene& scene, const Frames& frames)
    : drawing_(scene),
      stride_((scene.chain.size() + most - 1) / most),
      motions_(static_cast<std::size_t>(scene.chain.size())),
      torques_(static_cast<std::size_t>(scene.chain.size())),
      loads_(frames.base, "loads", onTop * drawing_.bar),
      pinForces_(frames.base, "pin_forces", overPins * drawing_.bar),
      springs_(frames.base, "springs", overBodies * drawing_.bar),
      path_(frames.base, "trail", behind * drawing_.bar),
      centres_(frames.base, "centres", overCoils * drawing_.bar) {
  energy_.header.frame_id = frames.base;
  energy_.ns = "energy";
  energy_.type = visualization_msgs::Marker::TEXT_VIEW_FACING;
  // Beside the circle that the chain can reach.
  energy_.pose.position.x = -1.15 * drawing_.reach;
  energy_.pose.position.y = 0.85 * drawing_.reach;
  energy_.pose.orientation.w = 1;
  energy_.scale.z = 0.07 * drawing_.reach;
  energy_.color = colour(0.85, 0.88, 0.92);

  const auto advertise = [&node](const char* name) {
    return node.advertise<visualization_msgs::Marker>(std::string("view/") + name, 2);
  };
  loadsOut_ = advertise("loads");
  pinForcesOut_ = advertise("pin_forces");
  springsOut_ = advertise("springs");
  trailOut_ = advertise("trail");
  centresOut_ = advertise("centres");
  energyOut_ = advertise("energy");
}

void Views::publish(const Simulation& simulation, ros::Time stamp) {
  const Chain& chain = simulation.scene().chain;
  const double t = simulation.time();
  if (isHeard(loadsOut_) || isHeard(pinForcesOut_) || isHeard(springsOut_) || isHeard(trailOut_) ||
      isHeard(centresOut_)) {
    simulation.linkMotions(motions_.data());
  }
  const auto show = [stamp](const ros::Publisher& out, Sketch& sketch, const auto& draw) {
    if (!isHeard(out)) return;
    sketch.clear();
    draw();
    out.publish(sketch.message(stamp));
  };
  show(loadsOut_, loads_, [&] { drawLoads(simulation, t); });
  show(pinForcesOut_, pinForces_, [&] { drawPinForces(); });
  show(springsOut_, springs_, [&] { drawSprings(simulation, t); });
  show(trailOut_, path_, [&] { drawTrail(simulation); });
  show(centresOut_, centres_, [&] { drawCentres(chain); });
  if (isHeard(energyOut_)) {
    tellEnergy(simulation.energyBalance());
    energy_.header.stamp = stamp;
    energyOut_.publish(energy_);
  }
}

Vec2d Views::pointOf(int link, Vec2d point) const {
  const LinkMotion& motion = motions_[static_cast<std::size_t>(link)];
  return motion.innerPin + Rotation<double>::of(motion.angle) * point;
}

void Views::drawLoads(const Simulation& simulation, double t) {
  const Scene& scene = simulation.scene();
  for (const Load& load : scene.loads) drawLoad(scene.chain, load, factorAt(load, t));
  for (const Load& load : simulation.commands()) {
    if (load.stop - t > onePart) drawLoad(scene.chain, load, factorAt(load, t));
  }
}

void Views::drawLoad(const Chain& chain, const Load& load, double factor) {
  const double width = arrowWidth * drawing_.bar;
  const auto turn = [&](Vec2d centre, double torque) {
    const double share = torque / drawing_.torque;
    if (std::fabs(share) < leastTold) return;
    const double sweep = std::copysign(fullTurn * std::fmin(1, std::sqrt(std::fabs(share))), share);
    loads_.turn(centre, turnRadius * drawing_.bar, pi / 2 - sweep / 2, sweep, width, red);
  };
  if (load.link != Load::none) {
    const Vec2d force = factor * load.force;
    if (length(force) > leastTold * drawing_.force) {
      const Vec2d at = pointOf(load.link, load.point);
      loads_.arrow(at, at + drawing_.arrow(force), width, red);
    }
    const Vec2d centre = chain.links()[static_cast<std::size_t>(load.link)].com;
    turn(pointOf(load.link, centre), factor * load.moment);
  }
  if (load.joint != Load::none) {
    turn(motions_[static_cast<std::size_t>(load.joint)].innerPin, factor * load.torque);
  }
}

void Views::drawPinForces() {
  for (std::size_t i = 0; i < motions_.size(); i += static_cast<std::size_t>(stride_)) {
    const LinkMotion& motion = motions_[i];
    if (length(motion.pinForce) < leastTold * drawing_.force) continue;
    pinForces_.arrow(motion.innerPin, motion.innerPin + drawing_.arrow(motion.pinForce),
                     arrowWidth * drawing_.bar, green);
  }
}

/// What springs and stops of a joint hold, and its damper takes: all torque in it but that of loads and
/// commands.
void Views::drawSprings(const Simulation& simulation, double t) {
  const Scene& scene = simulation.scene();
  simulation.jointTorques(torques_.data());
  const auto leaveOut = [&](const Load& load) {
    if (load.joint == Load::none) return;
    torques_[static_cast<std::size_t>(load.joint)] -= factorAt(load, t) * load.torque;
  };
  std::for_each(scene.loads.begin(), scene.loads.end(), leaveOut);
  const std::vector<Load> commands = simulation.commands();
  std::for_each(commands.begin(), commands.end(), leaveOut);

  for (std::size_t i = 0; i < motions_.size(); ++i) {
    const Joint& joint = scene.chain.joints()[i];
    if (joint.stiffness == 0 && !joint.isLimited()) continue;
    springs_.coil(motions_[i].innerPin, coilInner * drawing_.bar, coilOuter * drawing_.bar, motions_[i].angle,
                  2 * pi * coilTurns, coilWidth * drawing_.bar,
                  heat(std::fabs(torques_[i]) / drawing_.torque));
  }
}

void Views::drawTrail(const Simulation& simulation) {
  const double now = simulation.time();
  const int last = static_cast<int>(motions_.size()) - 1;
  const Vec2d tip = pointOf(last, simulation.scene().chain.links().back().pin);
  if (!trail_.empty() && now < trail_.back().time) trail_.clear();  // a reset
  if (trail_.empty() || now - trail_.back().time >= 1 / trailRate) trail_.push_back({now, tip});
  while (now - trail_.front().time > trailTime) trail_.pop_front();

  const auto shade = [now](const Spot& spot) {
    return colour(0.55, 0.8, 1, 0.8 * (1 - (now - spot.time) / trailTime));
  };
  const auto width = [&](const Spot& spot) {
    return trailWidth * drawing_.bar * (1 - (now - spot.time) / trailTime);
  };
  for (std::size_t k = 1; k < trail_.size(); ++k) {
    const Spot &from = trail_[k - 1], &to = trail_[k];
    path_.band(from.tip, to.tip, width(from), width(to), shade(from), shade(to));
  }
}

/// A small sign on each body, a large one where the whole chain has its centre of mass.
void Views::drawCentres(const Chain& chain) {
  Vec2d sum;
  double mass = 0;
  for (std::size_t i = 0; i < motions_.size(); ++i) {
    sum += chain.links()[i].mass * motions_[i].com;
    mass += chain.links()[i].mass;
    if (stride_ == 1) drawCentre(motions_[i].com, centreRadius * drawing_.bar);
  }
  drawCentre(1 / mass * sum, 1.6 * centreRadius * drawing_.bar);
}

/// A disc in quarters, with a rim.
void Views::drawCentre(Vec2d at, double radius) {
  for (int k = 0; k < 4; ++k) {
    centres_.sector(at, radius, k * pi / 2, pi / 2, k % 2 == 0 ? white : black);
  }
  centres_.coil(at, radius, radius, 0, 2 * pi, rim * drawing_.bar, white);
}

void Views::tellEnergy(const EnergyBalance& balance) {
  energy_.text = digits("kinetic", balance.now.kinetic) + digits("potential", balance.now.potential) +
                 digits("supplied", balance.supplied) + digits("dissipated", balance.dissipated) +
                 digits("balance", balance.residual);
}

}  // namespace planar_chain
