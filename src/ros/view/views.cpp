#include "ros/view/views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "effects/ground_springs.h"
#include "effects/springs.h"
#include "effects/stops.h"
#include "planar_chain/kane.h"

namespace planar_chain {

namespace {

const Colour red = colour(1, 0.33, 0.42), green = colour(0.4, 0.85, 0.5), white = colour(0.95, 0.95, 0.95),
             black = colour(0.1, 0.1, 0.12), violet = colour(0.75, 0.5, 1), orange = colour(0.98, 0.65, 0.15),
             yellow = colour(0.95, 0.9, 0.5), paleYellow = colour(0.95, 0.9, 0.5, 0.2);

// Sizes, in widths of a link.
constexpr double arrowWidth = 0.3;
constexpr double turnRadius = 2;
constexpr double centreRadius = 0.5, rim = 0.1;
constexpr double trailWidth = 0.3;
constexpr double brakeRadius = 1.45, brakeWidth = 0.4, padSweep = 0.85 * pi;
constexpr double limitRadius = 4, limitInner = 0.8, limitWidth = 0.4, railMark = 5;
constexpr double coilInner = 0.9, coilOuter = 1.7, coilWidth = 0.17, coilTurns = 2.25;
constexpr int zigzags = 8;  // of a straight spring
// Heights above the plane of motion, in widths of a link. The more important figure is on top.
constexpr double behind = -0.55, farBehind = -0.65, underCoils = 1.1, overBodies = 1.2, overCoils = 1.3,
                 overPins = 1.4, onTop = 1.5;

constexpr double fullTurn = 5;           // rad, of the arrow of Drawing::torque and of larger ones
constexpr double leastDrawn = 0.005;     // share of Drawing's force or torque
constexpr double trailTime = 2;          // s
constexpr double trailRate = 100;        // Hz, at most
constexpr int newest = 4;                // points of the trail that move with the last link
constexpr int mostPins = 4096;           // of a drawn chain; rviz ends lines after 16384
constexpr double leastRemaining = 1e-9;  // s: a command that lasts no longer is not drawn

/// Grey at 0, yellow at a half, red at 1.
Colour heat(double share) {
  const double x = std::clamp(share, 0.0, 1.0);
  return x < 0.5 ? colour(0.55 + 0.9 * x, 0.62 + 0.5 * x, 0.7 - x) : colour(1, 1.55 - 1.36 * x, 0.2);
}

Colour colourOf(int link) {
  const Paint& paint = paintOf(link);
  return colour(paint.red, paint.green, paint.blue);
}

/// The link that rviz follows (src/tools/show.py): the last link without mass of a chain that nothing holds.
int linkOfView(const Scene& scene, const Frames& frames) {
  const int moving = scene.chain.coordinates().leading() - 1;
  return floats(scene.chain) && frames.has(moving) ? moving : Sketch::base;
}

}  // namespace

Views::Views(Simulation& simulation, const Frames& frames)
    : simulation_(simulation),
      chain_(simulation.scene().chain),
      frames_(frames),
      drawing_(simulation.scene()),
      stride_((chain_.size() + most - 1) / most),
      motions_(chain_.links().size()),
      torques_(chain_.links().size()),
      energy_(drawing_, frames.of(linkOfView(simulation.scene(), frames)), drawing_.torque),
      scale_(drawing_, frames, linkOfView(simulation.scene(), frames)) {
  // Name the figures.
  const double bar = drawing_.bar;
  const auto add = [&](const char* name, double height, auto drawn, double lineWidth = 0) {
    views_.push_back({name, Sketch(frames, name, height * bar, lineWidth * bar), drawn});
  };
  if (frames.every > 1) add("chain", 0, &Views::drawChain, 1);
  add("loads", onTop, &Views::drawLoads);
  add("pin_forces", overPins, &Views::drawPinForces);
  add("springs", overBodies, &Views::drawSprings);
  add("friction", underCoils, &Views::drawFriction);
  add("drives", onTop, &Views::drawDrives);
  add("limits", farBehind, &Views::drawLimits);
  add("trail", behind, &Views::drawTrail, trailWidth);
  add("centres", overCoils, &Views::drawCentres);
}

visualization_msgs::MarkerArray& Views::draw(View& view, ros::Time stamp) {
  if (!std::exchange(hasMotions_, true)) simulation_.linkMotions(motions_.data());
  view.sketch.clear();
  (this->*view.draw)(view.sketch);
  return view.sketch.message(stamp);
}

Pose Views::poseOf(int link) const {
  const LinkMotion& motion = motions_[index(link)];
  return {motion.innerPin, Rotation<double>::of(motion.angle)};
}

/// From here on the sketch draws in the axes of a link: in its frame, or in that of the base if it has none.
/// origin: of the coordinates that follow, link frame.
Sketch& Views::on(Sketch& sketch, int link, Vec2d origin) const {
  const auto [pin, turn] = poseOf(link);
  return frames_.has(link) ? sketch.on(link, {origin, {}})
                           : sketch.on(Sketch::base, {pin + turn * origin, turn});
}

/// From here on the sketch draws in the axes of the body outside of which a joint is, as q does: from where
/// the joint's link is at q = 0.
Sketch& Views::inside(Sketch& sketch, int joint) const {
  if (joint > 0) return on(sketch, joint - 1, chain_.links()[index(joint - 1)].pin);
  const auto [pin, turn] = poseOf(0);
  const double q = simulation_.q()[0];
  const Joint& first = chain_.joints()[0];
  return sketch.on(Sketch::base, first.isPrismatic ? Pose{pin - turn * (q * first.axis), turn}
                                                   : Pose{pin, Rotation<double>::of(motions_[0].angle - q)});
}

Vec2d Views::tip() const {
  return motions_.back().innerPin + poseOf(chain_.size() - 1).turn * chain_.links().back().pin;
}

template <class Act>
void Views::forLoads(Act act) const {
  const double t = simulation_.time();
  for (const Load& load : simulation_.scene().loads) act(load, factorAt(load, t));
  for (const Load& command : simulation_.commands()) act(command, factorAt(command, t));
}

/// An arrow at a point of a link. The force has base-frame components.
void Views::drawForce(Sketch& sketch, int link, Vec2d point, Vec2d force, const Colour& paint) {
  if (length(force) <= leastDrawn * drawing_.force) return;
  const auto [origin, turn] = poseOf(link);
  const Vec2d root = motions_[index(std::min(chain_.coordinates().leading(), chain_.size() - 1))].innerPin;
  const Vec2d arrow = drawing_.arrow(force, origin + turn * point - root);
  const Rotation<double> toLink{turn.c, -turn.s};
  on(sketch, link).arrow(point, point + toLink * arrow, arrowWidth * drawing_.bar, paint);
}

/// An arrow around a point of a link. It grows with the square root of the torque.
void Views::drawTurn(Sketch& sketch, int link, Vec2d centre, double torque, const Colour& paint) {
  const double share = torque / drawing_.torque;
  if (std::fabs(share) < leastDrawn) return;
  const double sweep = std::copysign(fullTurn * std::fmin(1, std::sqrt(std::fabs(share))), share);
  on(sketch, link).turn(centre, turnRadius * drawing_.bar, sweep, arrowWidth * drawing_.bar, paint);
}

/// Draws a torque in a joint as an arc, or a force along a prismatic joint's axis as an arrow that begins at
/// its block's end.
void Views::drawInJoint(Sketch& sketch, int joint, double torque, const Colour& paint) {
  const Joint& own = chain_.joints()[index(joint)];
  if (!own.isPrismatic) return drawTurn(sketch, joint, {}, torque, paint);
  if (std::fabs(torque) < leastDrawn * drawing_.force) return;
  const Vec2d along = std::copysign(1, torque) * own.axis;
  const double bar = drawing_.bar, from = halfBlock(chain_, joint) * bar;
  on(sketch, joint).arrow(from * along, (from + drawing_.push(torque)) * along, arrowWidth * bar, paint);
}

void Views::drawLoads(Sketch& sketch) {
  forLoads([&](const Load& load, double factor) {
    if (load.stop - simulation_.time() <= leastRemaining) return;
    if (load.link != Load::none) {
      drawForce(sketch, load.link, load.point, factor * load.force, red);
      drawTurn(sketch, load.link, chain_.links()[index(load.link)].com, factor * load.moment, red);
    }
    if (load.joint != Load::none) drawInJoint(sketch, load.joint, factor * load.torque, red);
  });
}

/// In a driven joint only the drive acts.
void Views::drawDrives(Sketch& sketch) {
  const std::vector<Drive>& drives = simulation_.scene().drives;
  if (drives.empty()) return;
  simulation_.jointTorques(torques_.data());
  for (const Drive& drive : drives) {
    if (drive.joint % stride_ != 0) continue;
    drawInJoint(sketch, drive.joint, torques_[index(drive.joint)], violet);
  }
}

/// Two pads at each joint with friction: of a ring, or straight ones along a prismatic joint's axis. A joint
/// that sticks has the rate 0 exactly.
void Views::drawFriction(Sketch& sketch) {
  const double bar = drawing_.bar;
  for (int i = 0; i < chain_.size(); i += stride_) {
    if (!hasSymbol(chain_.joints()[index(i)], Symbol::brake)) continue;
    const Colour& paint = simulation_.qd()[index(i)] == 0 ? green : orange;
    const Joint& joint = chain_.joints()[index(i)];
    const Vec2d half = halfBlock(chain_, i) * bar * joint.axis;
    for (const double side : {0.0, pi}) {
      const Vec2d aside = std::cos(side) * brakeRadius * bar * perp(joint.axis);
      joint.isPrismatic
          ? on(sketch, i).band(aside - half, aside + half, brakeWidth * bar, brakeWidth * bar, paint)
          : on(sketch, i).coil({}, brakeRadius * bar, brakeRadius * bar, side - padSweep / 2, padSweep,
                               brakeWidth * bar, paint);
    }
  }
}

void Views::drawPinForces(Sketch& sketch) {
  for (int i = 0; i < chain_.size(); i += stride_)
    drawForce(sketch, i, {}, motions_[index(i)].pinForce, green);
}

void Views::drawSprings(Sketch& sketch) {
  // Find the torques of springs, stops and dampers.
  const auto vector = [](const std::vector<double>& values) {
    return Eigen::VectorXd(
        Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size())));
  };
  const Eigen::VectorXd q = vector(simulation_.q()), qd = vector(simulation_.qd());
  Eigen::VectorXd F = Eigen::VectorXd::Zero(2 * q.size()), M = Eigen::VectorXd::Zero(q.size()), tau = M;
  for (const EffectKind* kind : {&springKind(), &stopKind()}) {
    kind->addDense(simulation_.scene(), simulation_.time(), q, qd, {F, M, tau});
  }

  // Draw a coil on each joint that has a spring or stops. A prismatic joint's spring lies along its axis.
  for (int i = 0; i < chain_.size(); i += stride_) {
    const Joint& joint = chain_.joints()[index(i)];
    if (!hasSymbol(joint, Symbol::coil)) continue;
    const double share = std::fabs(tau[i]) / (joint.isPrismatic ? drawing_.force : drawing_.torque);
    if (joint.isPrismatic && joint.stiffness > 0) {
      drawAlongAxis(sketch, i, heat(share));
      continue;
    }
    on(sketch, i).coil({}, coilInner * drawing_.bar, coilOuter * drawing_.bar, 0, 2 * pi * coilTurns,
                       coilWidth * drawing_.bar, heat(share));
  }
  drawGroundSprings(sketch);
}

/// A zigzag from the ground to the link; a straight line if the spring is slack.
void Views::drawGroundSprings(Sketch& sketch) {
  for (int i = 0; i < chain_.size(); ++i) {
    const Link& link = chain_.links()[index(i)];
    if (link.springs.empty()) continue;
    const LinkMotion& motion = motions_[index(i)];
    const auto [pin, turn] = poseOf(i);
    for (const GroundSpring& spring : link.springs) {
      const Vec2d X = turn * spring.point, v = motion.velocity + motion.omega * perp(X - turn * link.com);
      const double pull = pullOf(spring, pin + X, v);
      const bool isSlack = spring.goesSlack && pull == 0;
      sketch.on(Sketch::base)
          .zigzag(spring.ground, pin + X, isSlack ? 0 : coilInner * drawing_.bar, zigzags,
                  coilWidth * drawing_.bar, heat(std::fabs(pull) / drawing_.force));
    }
  }
}

/// A spring from the inner end of a prismatic joint's rail to its block.
void Views::drawAlongAxis(Sketch& sketch, int joint, const Colour& paint) {
  const Vec2d axis = chain_.joints()[index(joint)].axis;
  const double bar = drawing_.bar, from = railOf(simulation_.scene(), joint, drawing_.links).from;
  inside(sketch, joint)
      .zigzag(from * axis, simulation_.q()[index(joint)] * axis, coilInner * bar, zigzags, coilWidth * bar,
              paint);
}

/// A pale sector of the angles that a joint allows, or a line across its axis at each limit.
void Views::drawLimits(Sketch& sketch) {
  const double bar = drawing_.bar;
  for (int i = 0; i < chain_.size(); i += stride_) {
    const Joint& joint = chain_.joints()[index(i)];
    if (!joint.isLimited()) continue;
    const Vec2d pin = chain_.links()[index(i)].pin;
    const Vec2d body = length(pin) > 0 ? pin : chain_.links()[index(i)].com;
    const double zero = joint.isPrismatic ? 0 : std::atan2(body.y, body.x);
    for (const double limit : {joint.lower, joint.upper}) {
      if (!std::isfinite(limit)) continue;
      const Vec2d along = joint.isPrismatic ? joint.axis : Rotation<double>::of(zero + limit) * Vec2d{1, 0};
      const Vec2d mark = joint.isPrismatic ? railMark / 2 * bar * perp(along) : limitRadius * bar * along;
      const Vec2d middle = joint.isPrismatic ? limit * along : Vec2d{};
      inside(sketch, i).band(middle + (joint.isPrismatic ? -1 : limitInner / limitRadius) * mark,
                             middle + mark, limitWidth * bar, limitWidth * bar, yellow);
    }
    if (joint.isPrismatic || !std::isfinite(joint.upper - joint.lower)) continue;
    const double sweep = std::fmin(joint.upper - joint.lower, 2 * pi);
    inside(sketch, i).sector({}, limitRadius * bar, zero + joint.lower, sweep, paleYellow);
  }
}

void Views::drawTrail(Sketch& sketch) {
  // Add the tip, and remove what is too old or too close. A state that was set begins a new trail, and so
  // does a tick after others that nobody watched.
  const double now = simulation_.time();
  const double longestPause = 2 / simulation_.scene().publish.tfRate;
  if (std::exchange(timesSet_, simulation_.timesSet()) != simulation_.timesSet() ||
      (!trail_.empty() && now - trail_.rbegin()->first > longestPause))
    trail_.clear();
  if (trail_.size() > 1 && trail_.rbegin()->first - std::next(trail_.rbegin())->first < 1 / trailRate)
    trail_.erase(std::prev(trail_.end()));
  trail_[now] = tip();
  while (now - trail_.begin()->first > trailTime) trail_.erase(trail_.begin());

  // Draw a line that fades with age.
  if (trail_.size() < 2) return;
  sketch.on(Sketch::base);
  for (const auto& [time, point] : trail_) {
    sketch.corner(point, colour(0.55, 0.8, 1, 0.8 * (1 - (now - time) / trailTime)));
  }

  // rviz shows a marker a frame later than the links. The newest part moves with the last link, up to the
  // tip.
  const int last = chain_.size() - 1;
  const Pose pose = poseOf(last);
  const Rotation<double> back{pose.turn.c, -pose.turn.s};
  sketch.on(last);
  int count = 0;
  for (auto point = trail_.rbegin(); point != trail_.rend() && count < newest; ++point, ++count) {
    sketch.corner(back * (point->second - pose.origin), colour(0.55, 0.8, 1, 0.8));
  }
}

void Views::drawCentres(Sketch& sketch) {
  Vec2d sum;
  double mass = 0;
  for (int i = 0; i < chain_.size(); ++i) {
    const Link& link = chain_.links()[index(i)];
    sum += link.mass * motions_[index(i)].com;
    mass += link.mass;
    if (stride_ == 1 && link.mass > 0) drawCentre(on(sketch, i), link.com, centreRadius * drawing_.bar);
  }
  // Draw a larger symbol for the whole chain.
  if (chain_.size() > 1) {
    drawCentre(sketch.on(Sketch::base), 1 / mass * sum, 1.6 * centreRadius * drawing_.bar);
  }
}

/// The usual symbol: a disc in quarters. The black ones have a rim.
void Views::drawCentre(Sketch& sketch, Vec2d at, double radius) {
  const double edge = rim * drawing_.bar;
  for (int k = 0; k < 4; ++k) {
    const bool isWhite = k % 2 == 0;
    sketch.sector(at, isWhite ? radius + edge / 2 : radius, k * pi / 2, pi / 2, isWhite ? white : black);
    if (!isWhite) sketch.coil(at, radius, radius, k * pi / 2, pi / 2, edge, white);
  }
}

/// The whole chain as a line through its pins and the own points of prismatic links, in the colours of links
/// by turns.
void Views::drawChain(Sketch& sketch) {
  const int step = (chain_.size() + mostPins - 1) / mostPins;
  for (int i = 0; i < chain_.size(); i += step) {
    sketch.on(Sketch::base).corner(motions_[index(i)].innerPin, colourOf(i / stride_));
  }
  sketch.corner(tip(), colourOf((chain_.size() - 1) / stride_));
}

}  // namespace planar_chain
