#pragma once

/// A chain as DART's Skeleton, joints' springs and dampers included; no loads.

#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>

#include "planar_chain/chain.h"

namespace planar_chain::benchmarks {

inline dart::dynamics::SkeletonPtr skeletonOf(const Chain& chain) {
  const auto skeleton = dart::dynamics::Skeleton::create("chain");
  skeleton->setGravity({chain.gravity().x, chain.gravity().y, 0});
  dart::dynamics::BodyNode* before = nullptr;
  Vec2d pinBefore;
  for (int i = 0; i < chain.size(); ++i) {
    const Link& link = chain.links()[static_cast<std::size_t>(i)];
    const Joint& own = chain.joints()[static_cast<std::size_t>(i)];
    dart::dynamics::RevoluteJoint::Properties joint;
    joint.mName = link.name + "_joint";
    joint.mSpringStiffnesses[0] = own.stiffness;
    joint.mRestPositions[0] = own.restAngle;
    joint.mDampingCoefficients[0] = own.damping;
    joint.mAxis = Eigen::Vector3d::UnitZ();
    joint.mT_ParentBodyToJoint.translation() << pinBefore.x, pinBefore.y, 0;
    dart::dynamics::BodyNode::Properties body;
    body.mName = link.name;
    const Eigen::Vector3d com(link.com.x, link.com.y, 0);
    const Eigen::Matrix3d inertia = link.inertia * Eigen::Matrix3d::Identity();
    body.mInertia = dart::dynamics::Inertia(link.mass, com, inertia);
    before = skeleton
                 ->createJointAndBodyNodePair<dart::dynamics::RevoluteJoint, dart::dynamics::BodyNode>(
                     before, joint, body)
                 .second;
    pinBefore = link.pin;
  }
  return skeleton;
}

}  // namespace planar_chain::benchmarks
