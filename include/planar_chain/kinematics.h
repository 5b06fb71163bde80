#pragma once

/// Where a point of the chain is and how it moves, and the joint angles that bring it to a place.
///
///     v = J q̇ + (base)        a = J q̈ + J̇ q̇ + (base)        ω, α likewise
///
/// J has the rows x, y and angle. Column j is (k̂×(P − O_j), 1) of a revolute joint at the pin O_j, and (d_j,
/// 0) of a prismatic one along d_j; 0 for joints outside of the link. J̇ q̇ is the acceleration at q̈ = 0 on a
/// base at rest.
///
/// q, q̇ and q̈ are relative, one number a joint: rad, or m of prismatic joints. Vectors have base-frame
/// components. If the base moves, it is where its laws have it at t. These functions allocate, and take O(n).

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "planar_chain/motion.h"
#include "planar_chain/scene.h"

namespace planar_chain {

/// The motion of a frame: of its point, and of its axes.
struct FrameMotion {
  Vec2d position;                  ///< m
  double angle = 0;                ///< rad, not wrapped
  Vec2d velocity;                  ///< m/s
  double rate = 0;                 ///< rad/s
  Vec2d acceleration;              ///< m/s²
  double angularAcceleration = 0;  ///< rad/s²
};

/// Returns the frame of this name: one of the scene's, or "tip", at the outer pin of the last link.
/// @throws Refused, at the path "frame", if there is none
Frame frameNamed(const Scene& scene, const std::string& name);

/// @throws Refused for wrong sizes, numbers that are not finite, and a frame on no link of the chain
FrameMotion motionOf(const Scene& scene, const Frame& frame, double t, const Eigen::VectorXd& q,
                     const Eigen::VectorXd& qd, const Eigen::VectorXd& qdd);
/// The motion of a frame on this link, from that of the link. Allocates nothing.
FrameMotion motionOf(const Frame& frame, const Link& link, const LinkMotion& motion);

/// Returns J, 3 × n.
/// @throws Refused as motionOf()
Eigen::MatrixXd jacobianOf(const Scene& scene, const Frame& frame, double t, const Eigen::VectorXd& q);

/// Joint angles that were searched for a place.
struct Reached {
  Eigen::VectorXd q;       ///< n
  double distance = 0;     ///< of the frame's point from the place, m
  double turn = 0;         ///< of its axes from the angle, rad; 0 if none was asked for
  bool isReached = false;  ///< to 1e-12 of the chain's reach and of the place, and 1e-12 rad
};

/// Searches the joint angles at which a frame is at a place and, if given, has an angle (rad, counted in
/// whole turns or not). Joints stay within their limits, and driven ones where their laws have them at t.
/// Damped least squares from `start`, by default the scene's first angles; if that does not get there, from
/// other angles too, the same ones each time. Returns the first solution that it finds; if there is none, the
/// nearest pose that it has found.
/// @throws Refused as motionOf(), and for a chain whose tip is held
Reached inverseKinematics(const Scene& scene, const Frame& frame, Vec2d place,
                          std::optional<double> angle = std::nullopt,
                          const std::optional<Eigen::VectorXd>& start = std::nullopt, double t = 0);

}  // namespace planar_chain
