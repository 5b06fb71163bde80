#pragma once

/// How a scene is drawn: sizes for the markers and the URDF, bodies as bars, and the URDF.

#include <string>
#include <vector>

#include "planar_chain/scene.h"
#include "ros/messages/frames.h"
#include "ros/view/extent.h"

namespace planar_chain {

struct Drawing : Extent {
  explicit Drawing(const Scene& scene);

  double unit;    ///< m: the mean length of a link, at least an eighth of the reach
  double bar;     ///< m: the width of a link, narrow beside the shortest one that turns
  double force;   ///< N: drawn half a unit long. The chain's weight; without gravity, the largest load
  double torque;  ///< N m: `force` at half the reach

  /// Returns the arrow of a force f (N), in m: proportional to it, but at most 1.5 units long. `from`: where
  /// it starts, m, in base axes from the inner pin of the first link that turns. An arrow that starts within
  /// the span ends at most 1.2 spans from the middle: in view.
  Vec2d arrow(Vec2d f, Vec2d from) const;
  /// Returns the length of the arrow of a force in a prismatic joint (N), in m. It grows with the square root
  /// of the force, as arcs do with the torque, to an eighth of the view's height for the chain's weight and
  /// more.
  double push(double f) const;
};

/// The length of a carriage along its rail, and of the block of a link that slides on a link that turns, in
/// widths of a link.
constexpr double carriageLength = 6, blockLength = 2;
/// Half of that of a prismatic joint.
double halfBlock(const Chain& chain, int joint);

/// A colour of links: three neighbours have different ones. The parts are in 0 … 1.
struct Paint {
  const char* name;  ///< of the URDF's material
  double red, green, blue;
};
const Paint& paintOf(int link);

/// A straight part of a body, in the link frame, m.
struct Bar {
  Vec2d from, to;
  double share = 1;  ///< of the full width
};

/// A body as it is drawn.
struct Figure {
  std::vector<Bar> bars;
  bool hasBob = false;  ///< at the centre of mass
  bool hasPin = true;   ///< at the origin; a link about as short as it is wide has none
};

/// True if nothing holds the first pin of a link that turns: two prismatic links without mass. They are not
/// drawn.
bool floats(const Chain& chain);

/// A thin bar joins the pins. A thick one shows the mass: the uniform rod with the body's mass, centre of
/// mass and moment of inertia, or a bob, if the centre of mass is in line with the pins. A rod that would
/// extend beyond both pins ends at the farther one. Else two thick bars join the pins to the centre of mass.
Figure figureOf(const Link& link, const Drawing& drawing);

/// Returns the scene as URDF, for rviz and other engines. Its root is the world frame, z up; a fixed joint
/// turns the base frame upright. Each link frame is at the link's inner pin, and its joint (axis +z, damping
/// and limits of the scene) is at the outer pin of the link before. Links have the names of their /tf frames,
/// prefix included. Joints have the names in joint_states. A moment of inertia I about +z becomes that of a
/// flat body: izz = I, ixx = iyy = I/2. Without links it has the ground alone.
std::string urdfOf(const Scene& scene, const Frames& frames, bool hasLinks = true);

/// The keys of the scene that change its motion and that URDF does not have, such as "drive".
std::vector<std::string> notInUrdf(const Scene& scene);

}  // namespace planar_chain
