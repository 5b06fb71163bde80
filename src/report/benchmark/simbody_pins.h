#pragma once

/// A chain, its slides included, as Simbody's mobilized bodies, whose frames stand in their centres of mass.

#include <Simbody.h>

#include "planar_chain/chain.h"

namespace planar_chain::benchmarks {

/// Adds links, from the ground outwards.
class SimbodyPins {
 public:
  /// matter must outlive this object.
  explicit SimbodyPins(SimTK::SimbodyMatterSubsystem& matter)
      : matter_(matter), before_(matter.getGround().getMobilizedBodyIndex()), pinBefore_(0) {}

  SimTK::MobilizedBody add(const Link& link, const Joint& joint) {
    const SimTK::Vec3 com(link.com.x, link.com.y, 0), pin(link.pin.x, link.pin.y, 0);
    const SimTK::Body::Rigid rigid(
        SimTK::MassProperties(link.mass, SimTK::Vec3(0), SimTK::Inertia(link.inertia)));
    SimTK::MobilizedBody body;
    if (joint.isPrismatic) {
      const SimTK::Rotation rail(std::atan2(joint.axis.y, joint.axis.x), SimTK::ZAxis);
      body = SimTK::MobilizedBody::Slider(matter_.updMobilizedBody(before_), {rail, pinBefore_}, rigid,
                                          {rail, -com});
    } else {
      body = SimTK::MobilizedBody::Pin(matter_.updMobilizedBody(before_), {pinBefore_}, rigid, {-com});
    }
    before_ = body.getMobilizedBodyIndex();
    pinBefore_ = pin - com;
    return body;
  }

 private:
  SimTK::SimbodyMatterSubsystem& matter_;
  SimTK::MobilizedBodyIndex before_;
  SimTK::Vec3 pinBefore_;
};

}  // namespace planar_chain::benchmarks
