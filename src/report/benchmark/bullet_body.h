#pragma once

/// A chain as Bullet's btMultiBody, in double precision; no springs, dampers, loads.

#include <BulletDynamics/Featherstone/btMultiBody.h>

#include <memory>

#include "planar_chain/chain.h"

namespace planar_chain::benchmarks {

inline std::unique_ptr<btMultiBody> bodyOf(const Chain& chain) {
  const int n = chain.size();
  auto body = std::make_unique<btMultiBody>(n, 0, btVector3(0, 0, 0), true, false);
  const btVector3 axis(0, 0, 1);
  btVector3 pinFromComBefore(0, 0, 0);
  for (int i = 0; i < n; ++i) {
    const Link& link = chain.links()[static_cast<std::size_t>(i)];
    const btVector3 com(link.com.x, link.com.y, 0), pin(link.pin.x, link.pin.y, 0);
    const btVector3 inertia(link.inertia, link.inertia, link.inertia);
    const Joint& joint = chain.joints()[static_cast<std::size_t>(i)];
    if (joint.isPrismatic) {
      body->setupPrismatic(i, link.mass, inertia, i - 1, btQuaternion::getIdentity(),
                           btVector3(joint.axis.x, joint.axis.y, 0), pinFromComBefore, com, true);
    } else {
      body->setupRevolute(i, link.mass, inertia, i - 1, btQuaternion::getIdentity(), axis, pinFromComBefore,
                          com, true);
    }
    pinFromComBefore = pin - com;
  }
  body->finalizeMultiDof();
  body->setLinearDamping(0);
  body->setAngularDamping(0);
  body->setUseGyroTerm(false);  // a body that stays in its plane has none
  return body;
}

}  // namespace planar_chain::benchmarks
