#include "ros/view/views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "planar_chain/kane.h"
#include "planar_chain/value.h"

namespace planar_chain {

namespace {

const std_msgs::ColorRGBA red = colour(1, 0.33, 0.42), green = colour(0.4, 0.85, 0.5),
                          white = colour(0.95, 0.95, 0.95), black = colour(0.1, 0.1, 0.12);

// Sizes, in widths of a link; heights above the plane of motion, so that nothing hides what matters more.
constexpr double arrowWidth = 0.3;
constexpr double turnRadius = 2;
constexpr double centreRadius = 0.5, rim = 0.1;
constexpr double trailWidth = 0.3;
constexpr double coilInner = 0.9, coilOuter = 1.7, coilWidth = 0.17, coilTurns = 2.25;
constexpr double behind = -0.55, overBodies = 1.2, overCoils = 1.3, overPins = 1.4, onTop = 1.5;

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
      loads_(frames, "loads", onTop * drawing_.bar),
      pinForces_(frames, "pin_forces", overPins * drawing_.bar),
      springs_(frames, "springs", overBodies * drawing_.bar),
      path_(frames, "trail", behind * drawing_.bar),
      centres_(frames, "centres", overCoils * drawing_.bar) {
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
    return node.advertise<visualization_msgs::MarkerArray>(std::string("view/") + name, 2);
  };
  loadsOut_ = advertise("loads");
  pinForcesOut_ = advertise("pin_forces");
  springsOut_ = advertise("springs");
  trailOut_ = advertise("trail");
  centresOut_ = advertise("centres");
  energyOut_ = node.advertise<visualization_msgs::Marker>("view/energy", 2);
}

void Views::publish(const Simulation& simulation, ros::Time stamp) {
  const Chain& chain = simulation.scene().chain;
  const double t = simulation.time();
  if (isHeard(loadsOut_) || isHeard(pinForcesOut_) || isHeard(springsOut_) || isHeard(trailOut_) ||
      isHeard(centresOut_)) {
    simulation.linkMotions(motions_.data());
  }
  const auto show = [stamp](const ros::Publisher& out, Sketches& sketch, const auto& draw) {
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

Vec2d Views::seenBy(int link, Vec2d vector) const {
  return Rotation<double>::of(-motions_[static_cast<std::size_t>(link)].angle) * vector;
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
  const auto turn = [&](int link, Vec2d centre, double torque) {
    const double share = torque / drawing_.torque;
    if (std::fabs(share) < leastTold) return;
    const double sweep = std::copysign(fullTurn * std::fmin(1, std::sqrt(std::fabs(share))), share);
    loads_.on(link).turn(centre, turnRadius * drawing_.bar, -sweep / 2, sweep, width, red);
  };
  if (load.link != Load::none) {
    const Vec2d force = factor * load.force;
    if (length(force) > leastTold * drawing_.force) {
      loads_.on(load.link).arrow(load.point, load.point + seenBy(load.link, drawing_.arrow(force)), width,
                                 red);
    }
    turn(load.link, chain.links()[static_cast<std::size_t>(load.link)].com, factor * load.moment);
  }
  if (load.joint != Load::none) turn(load.joint, {}, factor * load.torque);
}

void Views::drawPinForces() {
  for (int i = 0; i < static_cast<int>(motions_.size()); i += stride_) {
    const Vec2d force = motions_[static_cast<std::size_t>(i)].pinForce;
    if (length(force) < leastTold * drawing_.force) continue;
    pinForces_.on(i).arrow({}, seenBy(i, drawing_.arrow(force)), arrowWidth * drawing_.bar, green);
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

  for (int i = 0; i < scene.chain.size(); i += stride_) {
    const Joint& joint = scene.chain.joints()[static_cast<std::size_t>(i)];
    if (joint.stiffness == 0 && !joint.isLimited()) continue;
    const double share = std::fabs(torques_[static_cast<std::size_t>(i)]) / drawing_.torque;
    springs_.on(i).coil({}, coilInner * drawing_.bar, coilOuter * drawing_.bar, 0, 2 * pi * coilTurns,
                        coilWidth * drawing_.bar, heat(share));
  }
}

void Views::drawTrail(const Simulation& simulation) {
  const double now = simulation.time();
  const LinkMotion& last = motions_.back();
  const Vec2d tip =
      last.innerPin + Rotation<double>::of(last.angle) * simulation.scene().chain.links().back().pin;
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
    path_.on(Sketches::base).band(from.tip, to.tip, width(from), width(to), shade(from), shade(to));
  }
}

/// A small sign on each body, a large one where the whole chain has its centre of mass.
void Views::drawCentres(const Chain& chain) {
  Vec2d sum;
  double mass = 0;
  for (int i = 0; i < chain.size(); ++i) {
    const Link& link = chain.links()[static_cast<std::size_t>(i)];
    sum += link.mass * motions_[static_cast<std::size_t>(i)].com;
    mass += link.mass;
    if (stride_ == 1) drawCentre(centres_.on(i), link.com, centreRadius * drawing_.bar);
  }
  if (chain.size() > 1) {
    drawCentre(centres_.on(Sketches::base), 1 / mass * sum, 1.6 * centreRadius * drawing_.bar);
  }
}

/// A disc in quarters, with a rim.
void Views::drawCentre(Sketch& sketch, Vec2d at, double radius) {
  for (int k = 0; k < 4; ++k) sketch.sector(at, radius, k * pi / 2, pi / 2, k % 2 == 0 ? white : black);
  sketch.coil(at, radius, radius, 0, 2 * pi, rim * drawing_.bar, white);
}

void Views::tellEnergy(const EnergyBalance& balance) {
  energy_.text = digits("kinetic", balance.now.kinetic) + digits("potential", balance.now.potential) +
                 digits("supplied", balance.supplied) + digits("dissipated", balance.dissipated) +
                 digits("balance", balance.residual);
}

}  // namespace planar_chain
