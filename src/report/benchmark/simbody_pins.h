#pragma once

/// A chain as Simbody's mobilized bodies, whose frames stand in their centres of mass.

#include <Simbody.h>

#include "planar_chain/chain.h"

namespace planar_chain::benchmarks {

/// Adds links, from the ground outwards.
class SimbodyPins {
 public:
  /// matter must outlive this object.
  explicit SimbodyPins(SimTK::SimbodyMatterSubsystem& matter)
      : matter_(matter), before_(matter.getGround().getMobilizedBodyIndex()), pinBefore_(0) {}

  SimTK::MobilizedBody::Pin add(const Link& link) {
    const SimTK::Vec3 com(link.com.x, link.com.y, 0), pin(link.pin.x, link.pin.y, 0);
    const SimTK::MassProperties mass(link.mass, SimTK::Vec3(0), SimTK::Inertia(link.inertia));
    const SimTK::MobilizedBody::Pin body(matter_.updMobilizedBody(before_), SimTK::Transform(pinBefore_),
                                         SimTK::Body::Rigid(mass), SimTK::Transform(-com));
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
